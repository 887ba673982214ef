"""Every table that is keyed by a scheme has a row of each: a name that is forgotten must not become another."""

import itertools

import pytest

from snowmpm.measured.borders import shipped
from snowmpm.methods import METHODS
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.scenes.numerics import Solver
from snowmpm.schemes import BASES, GRADIENTS, TRANSFERS
from snowmpm.stepping.time_step import CRITICAL

SCHEMES = list(itertools.product(BASES, GRADIENTS, TRANSFERS))


@pytest.mark.parametrize(("key", "names"), [("kernel", BASES), ("gradient", GRADIENTS), ("transfer", TRANSFERS),
                                             ("method", METHODS)])
def test_scenes_take_every_name(key, names):
    assert Solver.model_json_schema()["properties"][key]["enum"] == list(names)


def test_every_basis_has_a_stencil_of_its_width():
    assert {name: stencil.width for name, stencil in STENCILS.items()} == {
        name: basis.width for name, basis in BASES.items()}


def test_every_scheme_has_a_critical_step():
    assert set(CRITICAL) == set(itertools.product(BASES, GRADIENTS))


@pytest.mark.parametrize("entry", ["long_step_lone_grain", "long_step_body"])
@pytest.mark.parametrize("scheme", SCHEMES, ids=" ".join)
def test_every_scheme_has_a_measured_border(entry, scheme):
    assert (entry, " ".join(scheme)) in shipped()


def test_names_are_their_keys():
    for table in (TRANSFERS, BASES):
        assert all(name == row.name for name, row in table.items())


def test_a_transfer_that_nobody_knows_is_refused():
    """By the table, also where no schema looked at it before."""
    with pytest.raises(KeyError):
        TRANSFERS["flipped"]
