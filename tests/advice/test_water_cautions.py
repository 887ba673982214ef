"""What `check` says of water in the pores."""

import pytest

from snowmpm.advice.budget import Budget
from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build
from tests.support.soaked_column import column


def said(**changes):
    """Keys and texts of the cautions about water."""
    scene = column(0.1, **changes)
    model = build(scene)
    found = cautions(SceneFacts(scene, model, model.solver()))
    return {caution.key: str(caution) for caution in found
            if caution.entry in ("undrained_step", "soaked_step") or caution.key.startswith(("water", "events"))
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


def test_melt_that_the_grains_would_miss():
    """They keep their mass: 1600 kg/m3 in cells of 0.1 m."""
    event = {"kind": "melt", "energy_flux": 3.334e5, "start": 1.0, "stop": 16.0}
    assert said(events=[event], end_time=100.0) == {}
    text = said(events=[{**event, "stop": 21.0}], end_time=100.0)["events.0.energy_flux"]
    assert "20 kg/m2 melt, 12 % of the ice" in text


def budget(scene):
    model = build(scene)
    return Budget(SceneFacts(scene, model, model.solver()))


@pytest.mark.parametrize("scene", [column(0.1), load_scene("slushflow", {"solver.dx": 20.0})], ids=["u_p", "one_phase"])
def test_the_cost_of_water_is_in_the_forecast(scene):
    """A row of its own among the payments, which make up the total."""
    wet, dry = budget(scene), budget(scene.model_copy(update={"water": None}))
    paid = {payment.what: payment.seconds for payment in wet.payments()}
    (what,) = set(paid) - {payment.what for payment in dry.payments()}
    assert what.startswith("water in the") and paid[what] > 0.0
    assert sum(seconds for seconds in paid.values() if seconds) == pytest.approx(wet.total)
    assert wet.step() - dry.step() == pytest.approx(paid[what] / wet.facts.steps)


def test_layers_cost():
    wet = [budget(load_scene("slushflow", {"solver.dx": 20.0, "water.layers": n})).stages()["flow_water"]
           for n in (10, 40)]
    assert 1.0 < wet[1] / wet[0] <= 4.0
