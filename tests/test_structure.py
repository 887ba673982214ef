"""How simple the program is to change, as `.ci/structure.py` measures it, against what was asked for."""

import importlib.util

import pytest

from tests.support.project import ROOT

SCALARS = {  # formulas with the scalars of their source; arrays of tensors that Taichi wants to know the types of
    "materials/ellipse.py", "materials/rate_integration.py", "materials/stress_update.py"}


@pytest.fixture(scope="module")
def structure():
    spec = importlib.util.spec_from_file_location("structure", ROOT / ".ci" / "structure.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def figures(structure):
    rows, _, wide, of_method = structure.measured()
    return {name: value for name, value, _ in rows} | {"wide": [place for _, place in wide], "Method": of_method}


def test_a_component_is_named_by_one_file(figures):
    assert {value for name, value in figures.items() if name.startswith("files that name")} == {1}


def test_a_method_has_about_ten_members(figures):
    functions, attributes = map(int, figures["members of Method"].split(" + "))
    assert functions <= 10 and attributes <= 10


def test_attributes_are_read_by_their_names(figures):
    assert figures["getattr, hasattr"] <= 40


@pytest.mark.xfail(strict=True, reason="31 on the host: options of commands, films, files, seeds, water")
def test_functions_take_few_arguments(figures):
    assert {place for place in figures["wide"] if place.partition(":")[0] not in SCALARS} == set()


@pytest.mark.xfail(strict=True, reason="113 372: inputs, pages of reference, declarations of components and groups of "
                                       "arguments came, and what has no scene carries rows of the sources")
def test_lines_of_the_product(figures):
    assert figures["lines of the product"] <= 74_000


@pytest.mark.slow
def test_types_fit_in_functions_without_annotations(structure):
    assert structure.untyped_errors() == 0
