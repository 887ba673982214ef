"""Water in the pores from a scene to its run file: budget, events, fields, bits after a checkpoint, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from tests.support.same_runs import assert_goes_on_alike, assert_same

SCENE = Path(__file__).with_name("soaked_slope.toml")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The whole run."""
    return snowmpm.run(load_scene(SCENE), tmp_path_factory.mktemp("soaked"))


def test_water_is_accounted_for(run):
    history = run.history
    assert np.max(history["water_residual"]) < 1e-10
    solid = history["mass"] + history["removed_mass"] - history["water_mass"] - history["removed_water"]
    np.testing.assert_allclose(solid, solid[0], rtol=1e-12)
    assert history["removed_water"][-1] > 0.0 == history["removed_water"][0]
    assert history["momentum_residual"][-1] < 1e-10
    # 5 kg/m2/s over the 1.1 m of the slab in plan that the rain meets, for 0.07 s, to a column of cells and a step
    assert history["added_water"][-1] == pytest.approx(5.0 * 1.1 * 0.07, rel=0.12)
    total = history["water_mass"] + history["drained_water"] + history["removed_water"] - history["added_water"]
    np.testing.assert_allclose(total, total[0], rtol=1e-10)


def test_a_drain_that_opens(run):
    """Water drips from the overhang at the lower end; once the ground drains, much more leaves."""
    drained = np.interp((0.04, 0.08, 0.12), run.history["time"], run.history["drained_water"])
    assert drained[0] > 0.0 and drained[2] - drained[1] > 5.0 * drained[0]


def test_fields_of_frames(run):
    frame = run.frame(1).fields
    assert frame["saturation"].min() > 0.0 and frame["saturation"].max() <= 1.0 + 1e-6
    assert (frame["pore_pressure"] >= 0.0).all()
    np.testing.assert_allclose(frame["liquid_water"], frame["saturation"] * frame["porosity"], rtol=1e-5)
    wet = frame["saturation"] > 0.42
    assert wet.any()


def test_the_summary_has_the_water(run):
    summary = json.loads((Path(run.path).parent / "summary.json").read_text())
    assert "water_mass" in json.dumps(summary)


def to(simulation, time):
    while simulation.time < time:
        simulation.step(until=time)
    return simulation


def test_a_resumed_run_is_the_same_to_the_bit(tmp_path):
    """Stopped while it rains, with the drain still closed."""
    whole = to(Simulation(load_scene(SCENE, {"end_time": 0.08})), 0.04)
    assert_goes_on_alike(whole, 0.07, tmp_path)


def test_a_load_on_a_body_stays_itself_while_it_rains(tmp_path):
    """It gets heavier by more than 5 %, and its impulse is F t. A run that is resumed gives the same bits."""
    scene = load_scene(SCENE, {"end_time": 0.08, "water.suction": 0.0, "events": [
        {"kind": "rain", "rate": 2000.0}, {"kind": "load", "body": "slab", "force": [500.0, 0.0]}]})
    whole = to(Simulation(scene), 0.03)
    first = whole.audit()["mass"]
    assert_goes_on_alike(whole, 0.06, tmp_path)
    row = whole.audit()
    assert row["mass"] > 1.05 * first and row["momentum_residual"] < 1e-12


def test_water_settles_with_the_snow():
    """A saturated layer at rest under its buoyant weight: hydrostatic water, effective stress of the rest."""
    scene = load_scene(SCENE, {
        "terrain.angle": 0.0, "events": [], "initial.stress": "settle", "initial.tolerance": 0.02,
        "bodies": [{"name": "slab", "material": "snow", "shape": {
            "kind": "box", "min": [0.0, 0.0], "max": [4.0, 0.6]}}],
        "domain.boundary": {"x_min": "slip", "x_max": "slip"}, "domain.min": [0.0, -0.4], "solver.dx": 0.1,
        "water.saturation": 1.0, "water.table": 0.6, "water.porosity": 0.4, "materials.snow.density": 1600.0,
        "materials.snow.youngs_modulus": 5e6})  # grains heavier than water: snow would float
    simulation = Simulation(scene)
    fields = simulation.particles
    z = fields["position"][:, 1]
    # Pressures stay while the layer settles, by some millimetres
    np.testing.assert_allclose(fields["pore_pressure"], 9810.0 * (0.6 - z), atol=30.0)
    submerged = (1600.0 + 1000.0 * 0.4 - 1000.0) * 9.81
    middle = (z > 0.1) & (z < 0.3)
    expected = -(submerged * (0.6 - z[middle])).mean()
    assert fields["stress"][middle, 1].mean() == pytest.approx(expected, rel=0.15)
    row = simulation.audit()
    assert row["water_residual"] < 1e-13
    simulation.step()
    assert simulation.audit()["water_residual"] < 1e-13


def test_melt_is_rain_of_the_latent_heat():
    """A flux of energy E gives the water of E / L, 333.4 kJ for each kilogram, at the same places."""
    times = {"start": 0.005, "stop": 0.03, "region": {"x": [0.0, 1.6]}}
    rows = []
    for wetting in ({"kind": "melt", "energy_flux": 5.0 * 333.4e3}, {"kind": "rain", "rate": 5.0}):
        simulation = to(Simulation(load_scene(SCENE, {"events": [{**wetting, **times}]})), 0.04)
        rows.append(simulation.audit())
    assert_same(*rows)
    assert rows[0]["added_water"] == pytest.approx(5.0 * 1.1 * 0.025, rel=0.12) and rows[0]["water_residual"] < 1e-10


@pytest.mark.parametrize(("changes", "key"), [
    ({"water.permeability": 0.0}, "water.permeability"),
    ({"water.permeability": -1e-9}, "water.permeability"),
    ({"water.permeability": {"law": "calonne", "grain_size": -1.0}}, "water.permeability.grain_size"),
    ({"water.permeability": {"law": "darcy"}}, 'water.permeability.law = "darcy": must be "calonne"'),
    ({"water.porosity": 1.0}, "water.porosity"),
    ({"water.porosity": 0.0}, "water.porosity"),
    ({"water.porosity": 1.2}, "water.porosity"),
    ({"materials.snow.density": 950.0}, "materials.snow.density"),
    ({"solver.precision": "f32"}, "solver.precision"),
    ({"solver.method": "sph", "events": []}, "water.scheme"),
    ({"initial.stress": "geostatic"}, "initial.stress"),
    ({"initial.stress": "settle", "initial.relaxation": "static"}, "initial.relaxation"),
    ({"events": [{"kind": "melt", "energy_flux": 0.0}]}, "events.0.energy_flux"),
    ({"events": [{"kind": "melt", "energy_flux": -1.0}]}, "events.0.energy_flux"),
    ({"events": [{"kind": "melt", "rate": 1.0}]}, "events.0.energy_flux"),
    ({"events": [{"kind": "melt", "energy_flux": 1.0, "start": 2.0, "stop": 1.0}]}, "events.0.stop"),
    ({"water.pressure": 1e3}, "water.pressure"),
    ({"water.sides": {"y_min": "drained"}}, "water.sides.y_min"),
    ({"events.0.rate": -1.0}, "events.0.rate"),
    ({"events.1.border": "roof"}, "events.1.border"),
    ({"events.1.border": "y_min"}, "events.1"),
    ({"water.permeability": {"file": "k.asc"}}, "water.permeability"),
])
def test_what_is_refused(changes, key):
    """Two lines at most, with the key."""
    with pytest.raises(InputError) as refusal:
        Simulation(load_scene(SCENE, changes))
    said = str(refusal.value)
    assert key in said and len(said.splitlines()) <= 2, said


def test_rain_needs_water(tmp_path):
    """Rain on, or melt in, a scene without the table `[water]`."""
    text = SCENE.read_text()
    (tmp_path / "dry.toml").write_text(text[: text.index("[water]")])
    for changes in ({}, {"events": [{"kind": "melt", "energy_flux": 100.0}]}):
        with pytest.raises(InputError, match=r"events.0.kind.*needs water") as refusal:
            load_scene(tmp_path / "dry.toml", changes)
        assert len(str(refusal.value).splitlines()) <= 2
