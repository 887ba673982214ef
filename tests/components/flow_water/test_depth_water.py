"""Water that moves with a depth-averaged flow, from a scene to its run file: mass, fields, resume, refusals."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_goes_on_alike

LEVEL, PORES, DRY = 0.5, 0.55, 450.0
WET = DRY + PORES * LEVEL * 1000.0
WATER = {"scheme": "one_phase", "level": LEVEL, "porosity": PORES, "excess": 0.8, "consolidation": 0.05}
SNOW = {"kind": "elastic", "density": DRY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}


def scene(**changes):
    """Wet snow that slides down a plane of 25 degrees, over a drain, and out at its foot."""
    tables = {
        "name": "slush", "dimension": 3, "end_time": 4.0, "output": {"interval": 1.0, "fields": [
            "pore_pressure", "excess_pressure", "saturation", "liquid_water", "density", "depth"]},
        "solver": {"method": "depth", "dx": 2.0},
        "domain": {"min": [0.0, 0.0, -60.0], "max": [40.0, 20.0, 40.0]},
        "terrain": {"kind": "plane", "point": [0.0, 0.0, 20.0], "angle": 25.0, "friction": 0.6},
        "water": {**WATER, "drains": [{"x": [20.0, 26.0]}]},
        "materials": {"snow": SNOW},
        "bodies": [{"name": "release", "material": "snow", "shape": {
            "kind": "layer", "bottom": 0.0, "top": 1.0,
            "region": {"polygon": [[2.0, 4.0], [18.0, 4.0], [18.0, 16.0], [2.0, 16.0]]}}}]}
    for key, value in changes.items():
        table, _, name = key.partition("__")
        tables[table] = {**tables[table], name: value} if name else value
    return Scene.model_validate(tables)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The whole run."""
    return snowmpm.run(scene(end_time=8.0, output__interval=0.5), tmp_path_factory.mktemp("slush"))


def test_mass_of_snow_and_water(run):
    history = run.history
    assert 0.0 < history["removed_mass"][10] < history["mass"][0]
    for name in ("mass", "water"):
        now, gone = ("mass", "removed_mass") if name == "mass" else ("water_mass", "removed_water")
        total = history[now] + history[gone]
        np.testing.assert_allclose(total, total[0], rtol=1e-12)
    np.testing.assert_allclose(history["water_mass"], history["mass"] * PORES * LEVEL * 1000.0 / WET, rtol=1e-12)
    assert history["momentum_residual"][-1] < 1e-5


def test_fields_of_frames(run):
    first, later = run.frame(0).fields, run.frame(4)
    for fields in (first, later.fields):
        np.testing.assert_allclose(fields["density"], WET, rtol=1e-6)
        np.testing.assert_allclose(fields["saturation"], LEVEL, rtol=1e-6)
        np.testing.assert_allclose(fields["liquid_water"], LEVEL * PORES, rtol=1e-6)
    weight = 9.81 * np.cos(np.radians(25.0)) * first["depth"]
    np.testing.assert_allclose(first["excess_pressure"], 0.8 * (WET - 500.0) * weight, rtol=1e-3)
    np.testing.assert_allclose(first["pore_pressure"], first["excess_pressure"] + 500.0 * weight, rtol=1e-3)
    x = later.points[:, 0] + run.origin[0]
    over = (x > 20.5) & (x < 25.5)
    assert over.any() and (later.fields["excess_pressure"][over] == 0.0).all()
    soon = run.frame(1).fields["excess_pressure"]  # by P7, 0.64 of the start are left after T = 0.1
    assert np.median(soon) / np.median(first["excess_pressure"]) == pytest.approx(0.64, abs=0.12)
    assert (later.fields["pore_pressure"] > -0.01).all()


def test_water_carries_snow_that_would_lie_still(tmp_path):
    dry = snowmpm.run(scene(end_time=1.0, water=None, solver__depth={"scheme": "columns"}), tmp_path / "dry")
    wet = snowmpm.run(scene(end_time=1.0), tmp_path / "wet")
    speed = [run.history["total_momentum"][-1] / run.history["mass"][0] for run in (dry, wet)]
    assert speed[0] < 0.1 < 1.0 < speed[1]


@pytest.mark.slow
def test_snow_cover_that_is_taken_up_is_as_wet(tmp_path):
    """Mass is that of the start and of the cover, less what left; of all of it, the same share is water."""
    history = snowmpm.run(scene(terrain__entrainment={"law": "rate", "growth_rate": 0.02, "thickness": 0.3,
                                                      "density": 600.0}), tmp_path).history
    assert history["entrained_mass"][-1] > 0.1 * history["mass"][0]
    np.testing.assert_allclose(history["mass"] + history["removed_mass"] - history["entrained_mass"],
                               history["mass"][0], rtol=1e-6)
    np.testing.assert_allclose(history["water_mass"], history["mass"] * PORES * LEVEL * 1000.0 / WET, rtol=1e-12)


def to(simulation, time):
    while simulation.time < time:
        simulation.step(until=time)
    return simulation


def test_a_resumed_run_is_the_same_to_the_bit(tmp_path):
    """After columns have left, with one release that is still to come."""
    first = scene().bodies[0]
    chosen = scene(bodies=[first.model_dump(), {**first.model_dump(), "name": "late", "start_time": 5.5, "shape": {
        "kind": "layer", "bottom": 0.0, "top": 0.5, "region": {"x": [2.0, 6.0]}}}], end_time=8.0)
    whole = to(Simulation(chosen), 5.0)
    assert whole.audit()["removed_water"] > 0.0
    assert_goes_on_alike(whole, 6.5, tmp_path)


def test_a_forecast_slides_further_on_wet_ground():
    """Blocks of `check` lose the part of their friction that water bears."""
    ways = {}
    for name, water in (("dry", None), ("wet", WATER)):
        simulation = Simulation(scene(water=water, end_time=60.0, terrain__friction=0.5, domain={
            "min": [0.0, 0.0, -600.0], "max": [400.0, 20.0, 40.0]}))
        ways[name] = simulation.solver.course(60.0, 1.0).speed
    assert ways["wet"] > ways["dry"]


@pytest.mark.parametrize(("changes", "key"), [
    ({"water": {"permeability": 1e-9}}, "water.scheme"),
    ({"water.scheme": "three_phase"}, "water.scheme"),
    ({"water.level": 0.0}, "water.level"),
    ({"water.level": 1.1}, "water.level"),
    ({"water.level": 1.0, "water.porosity": 0.5}, "water.level"),
    ({"water.porosity": 1.0}, "water.porosity"),
    ({"water.porosity": -0.1}, "water.porosity"),
    ({"water.excess": 1.5}, "water.excess"),
    ({"water.consolidation": -1.0}, "water.consolidation"),
    ({"water": {"scheme": "one_phase"}}, "water.consolidation"),
    ({"water.layers": 2}, "water.layers"),
    ({"water.permeability": 1e-9}, "water.permeability"),
    ({"water.drains": [{"x": [60.0, 70.0]}]}, "water.drains.0"),
    ({"materials.snow.density": 950.0}, "materials.snow.density"),
    ({"events": [{"kind": "rain", "rate": 0.1}]}, "events.0.kind"),
    ({"switch": [{"to": "mpm", "when": "t > 1", "solver": {"dx": 1.0}}]}, "switch.0"),
    ({"solver.method": "mpm", "solver.dx": 20.0, "solver.precision": "f64"}, "water.scheme"),
])
def test_bad_input_is_refused(changes, key):
    """In two lines, with key, value and what is allowed."""
    with pytest.raises(InputError, match=key.replace(".", r"\.")) as refused:
        Simulation(load_scene("slushflow", changes))
    assert len(str(refused.value).splitlines()) <= 2
