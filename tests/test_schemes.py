"""Every table that is keyed by a scheme has a row of each: a name that is forgotten must not become another."""

import itertools

import numpy as np
import pytest
from pydantic import ValidationError

from snowmpm.advice.cautions import RULES
from snowmpm.errors import InputError
from snowmpm.materials import LAWS
from snowmpm.measured import costs
from snowmpm.measured.borders import shipped
from snowmpm.methods import METHODS
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.running.failure import SYMPTOMS
from snowmpm.scenes.numerics import Solver
from snowmpm.schemes import BASES, GRADIENTS, SCHEMES, TRANSFERS, misfit
from snowmpm.stepping.time_step import CRITICAL


@pytest.mark.parametrize(("key", "names"), [("kernel", BASES), ("gradient", GRADIENTS), ("transfer", TRANSFERS),
                                             ("method", METHODS)])
def test_scenes_take_every_name(key, names):
    assert Solver.model_json_schema()["properties"][key]["enum"] == list(names)


def test_every_basis_has_a_stencil_of_its_width():
    assert {name: stencil.width for name, stencil in STENCILS.items()} == {
        name: basis.width for name, basis in BASES.items()}


def test_every_scheme_has_a_critical_step():
    assert set(CRITICAL) == {scheme[:2] for scheme in SCHEMES}
    for kernel, gradient, transfer in SCHEMES:
        assert CRITICAL[kernel, gradient].of(TRANSFERS[transfer]) > 0.0


@pytest.mark.parametrize("scheme", itertools.product(BASES, GRADIENTS, TRANSFERS), ids=" ".join)
def test_what_does_not_go_together_is_refused(scheme):
    """And nothing else is: averaged hats want the gradients of the shape functions, and no affine velocity."""
    chosen = dict(zip(("kernel", "gradient", "transfer"), scheme, strict=True))
    refused = BASES[scheme[0]].box and (scheme[1] != "shape" or scheme[2] not in ("pic", "flip"))
    assert (scheme not in SCHEMES) == bool(refused)
    if not refused:
        Solver(dx=0.1, **chosen)
        return
    key, value, allowed = misfit(*scheme)
    with pytest.raises(ValidationError, match=f'must be "{allowed[0]}".* beside kernel = "{scheme[0]}"'):
        Solver(dx=0.1, **chosen)
    assert chosen[key] == value and key == ("gradient" if scheme[1] != "shape" else "transfer")


@pytest.mark.parametrize("entry", ["long_step_lone_grain", "long_step_body"])
@pytest.mark.parametrize("scheme", SCHEMES, ids=" ".join)
def test_every_scheme_has_a_measured_border(entry, scheme):
    assert (entry, " ".join(scheme)) in shipped(), f"measure it: snowmpm study stability --only {entry} -o DIR"


@pytest.mark.parametrize("scheme", SCHEMES, ids=" ".join)
def test_the_critical_step_is_the_measured_one(scheme):
    """1.5 %: it was measured to 1 %, the border in steps of a few per mille below it."""
    kernel, gradient, transfer = scheme
    border = shipped()["long_step_lone_grain", " ".join(scheme)].value
    assert CRITICAL[kernel, gradient].of(TRANSFERS[transfer]) == pytest.approx(border, rel=0.015)


PRECISIONS = ("f32", "f64")


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("scheme", SCHEMES, ids=" ".join)
def test_every_scheme_has_a_measured_cost(scheme, dimension):
    kernel, gradient, transfer = scheme
    for precision in PRECISIONS:
        assert costs.transfers(costs.Scheme(dimension, precision, kernel, gradient, transfer)) > 0.0


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", LAWS)
def test_every_law_has_a_measured_cost(kind, dimension):
    for precision in PRECISIONS:
        assert np.isfinite(costs.law(costs.Scheme(dimension, precision), kind))


@pytest.mark.parametrize(("method", "dimension"), [(name, dimension) for name, entry in METHODS.items()
                                                   for dimension in entry.capabilities.dimensions])
def test_every_method_has_a_measured_cost(method, dimension):
    load = costs.StepLoad({"elastic": 1000}, blocks=10, node_blocks=20, contact_blocks=5, surfaces=2)
    for precision in METHODS[method].capabilities.precisions:
        found = costs.stages(costs.Scheme(dimension, precision, method=method), load)
        assert found["particles"] > 0.0 and found["calls"] > 0.0


@pytest.mark.parametrize("changed", [{"transfer": "shpic"}, {"kernel": "quartic"}, {"gradient": "none"}])
def test_a_cost_that_was_not_measured_is_an_error(changed):
    with pytest.raises(InputError, match="its cost was not measured"):
        costs.transfers(costs.Scheme(2, **changed))
    with pytest.raises(InputError, match="no row law, 2, f32, foam"):
        costs.law(costs.Scheme(2), "foam")


def test_every_method_has_rules_and_symptoms():
    assert set(RULES) == set(METHODS) == set(SYMPTOMS) and all(RULES.values())


def test_names_are_their_keys():
    for table in (TRANSFERS, BASES):
        assert all(name == row.name for name, row in table.items())


def test_a_transfer_that_nobody_knows_is_refused():
    """By the table, also where no schema looked at it before."""
    with pytest.raises(KeyError):
        TRANSFERS["flipped"]
