"""What `check` says of water in the pores."""

import pytest

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.setup.build import build
from tests.support.soaked_column import column


def said(**changes):
    """Keys and texts of the cautions about water."""
    scene = column(0.1, **changes)
    model = build(scene)
    found = cautions(SceneFacts(scene, model, model.solver()))
    return {caution.key: str(caution) for caution in found
            if caution.entry in ("undrained_step", "soaked_step") or caution.key.startswith("water")
            or "drained" in caution.says}


def test_nothing_of_the_usual_column():
    assert said() == {}


def test_the_explicit_split():
    text = said(water={"split": "explicit"})["water.split"]
    assert "undrained" in text and "semi_implicit" in text and "times shorter" in text


@pytest.mark.parametrize(("solver", "key"), [({"cfl": 0.9}, "solver.cfl"), ({"dt": 1.1e-3}, "solver.dt")])
def test_a_step_near_the_critical_one(solver, key):
    assert "atlas: soaked_step" in said(solver=solver)[key]


def test_drainage_within_a_cell():
    assert "0.1" in said(water={"permeability": 1.8e-14}, end_time=1.0)["solver.dx"]


def test_flow_beyond_darcy():
    coarse = {"law": "kozeny_carman", "grain_size": 0.02}
    assert "Reynolds" in said(water={"permeability": coarse}, gravity=9.81)["water.permeability"]
