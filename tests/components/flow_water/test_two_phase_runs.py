"""Grains and water with columns of their own, from a scene to its run file: masses, fields, resume, check, refusals."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.toml import table_text
from tests.support.same_runs import assert_goes_on_alike

GRAINS, DRY = 2500.0, 1500.0
WATER = {"scheme": "two_phase", "grain_density": GRAINS, "consolidation": 0.05, "excess": 0.5,
         "drag": {"law": "anderson", "terminal_velocity": 1e-3}}


def tables(**changes):
    """Of a scene of wet debris that slides down a plane of 25 degrees, and out at its foot."""
    found = {
        "name": "debris", "dimension": 3, "end_time": 4.0, "output": {"interval": 1.0, "fields": [
            "pore_pressure", "excess_pressure", "porosity", "liquid_water", "density", "depth"]},
        "solver": {"method": "depth", "dx": 2.0, "precision": "f64"},
        "domain": {"min": [0.0, 0.0, -60.0], "max": [60.0, 20.0, 40.0]},
        "terrain": {"kind": "plane", "point": [0.0, 0.0, 20.0], "angle": 25.0, "friction": 0.6},
        "water": dict(WATER),
        "materials": {"debris": {"kind": "elastic", "density": DRY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "release", "material": "debris", "shape": {
            "kind": "layer", "bottom": 0.0, "top": 1.0,
            "region": {"polygon": [[2.0, 4.0], [18.0, 4.0], [18.0, 16.0], [2.0, 16.0]]}}}]}
    for key, value in changes.items():
        table, _, name = key.partition("__")
        found[table] = {**found[table], name: value} if name else value
    return found


def scene(**changes):
    """`Scene` of these tables."""
    return Scene.model_validate(tables(**changes))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return snowmpm.run(scene(), tmp_path_factory.mktemp("debris"))


def test_mass_of_grains_and_water(run):
    history = run.history
    assert history["removed_mass"][-1] > 0.0
    for now, gone in (("mass", "removed_mass"), ("water_mass", "removed_water")):
        total = history[now] + history[gone]
        np.testing.assert_allclose(total, total[0], rtol=1e-12)
    volume = history["water_mass"][0] / 1000.0 / 0.4
    assert history["mass"][0] == pytest.approx(volume * (DRY + 400.0), rel=1e-12)


def test_fields(run):
    first, later = run.frame(0).fields, run.frame(2).fields
    for fields in (first, later):
        wet = fields["liquid_water"] > 0.5
        np.testing.assert_allclose(fields["density"], np.where(wet, 1000.0, GRAINS), rtol=1e-6)
    np.testing.assert_allclose(first["porosity"], 0.4, atol=1e-6)
    assert 0.3 < np.median(later["porosity"]) < 0.5
    inner = first["depth"] > 0.9
    weight = 9.81 * np.cos(np.radians(25.0)) * first["depth"][inner]
    np.testing.assert_allclose(first["excess_pressure"][inner], 0.5 * 0.6 * (GRAINS - 1000.0) * weight, rtol=0.02)
    np.testing.assert_allclose((first["pore_pressure"] - first["excess_pressure"])[inner], 1000.0 * weight, rtol=0.02)


def test_resume_to_the_bit(tmp_path):
    whole = Simulation(scene())
    while whole.time < 3.0:
        whole.step(until=3.0)
    assert_goes_on_alike(whole, 4.0, tmp_path)
    assert whole.audit()["removed_water"] > 0.0


def test_wet_snow_cover_is_taken_up():
    """In the proportions of the flow; mass closes, and the ground sinks."""
    cover = {"law": "rate", "growth_rate": 0.01, "thickness": 0.5, "density": 900.0}
    simulation = Simulation(scene(terrain__entrainment=cover))
    start = simulation.audit()
    while simulation.time < 2.0:
        simulation.step(until=2.0)
    row = simulation.audit()
    assert row["entrained_mass"] > 0.01 * start["mass"]
    assert row["mass"] + row["removed_mass"] - row["entrained_mass"] == pytest.approx(start["mass"], rel=1e-12)
    gained = row["water_mass"] + row["removed_water"] - start["water_mass"]
    assert gained / row["entrained_mass"] == pytest.approx(400.0 / 1900.0, rel=0.1)


def test_rests_below_its_friction():
    """A saturated sheet over a drained ground, tan 8 degrees below mu rho' / rho: its middle does not creep."""
    simulation = Simulation(scene(terrain__angle=8.0, water__ground="drained", end_time=2.0))
    x = simulation.particles["position"]
    middle = (np.abs(x[:, 0] - 10.0) < 2.0) & (np.abs(x[:, 1] - 10.0) < 2.0)
    while simulation.time < 2.0:
        simulation.step(until=2.0)
    assert np.abs(simulation.particles["position"][middle] - x[middle]).max() < 0.03


@pytest.mark.parametrize(("changes", "key"), [
    ({"water__grain_density": 917.0}, "water.grain_density"),
    ({"water__grain_density": -1.0}, "water.grain_density"),
    ({"water__grain_density": 1200.0}, "materials.debris.density"),
    ({"water__drag": {"law": "anderson", "terminal_velocity": 0.0}}, "water.drag.terminal_velocity"),
    ({"water__drag": {"law": "darcy", "permeability": 0.0}}, "water.drag.permeability"),
    ({"water__drag": {"law": "darcy", "permeability": -1e-9}}, "water.drag.permeability"),
    ({"water__drag": {"law": "stokes"}}, "water.drag"),
    ({"water": {**WATER, "level": 0.5}}, "water.level"),
    ({"water": {k: v for k, v in WATER.items() if k != "drag"}}, "water.drag"),
    ({"terrain__deposition": {"time": 1.0}}, "water.scheme"),
    ({"terrain__entrainment": {"law": "erosion_energy", "thickness": 0.5, "density": 400.0}}, "terrain.entrainment"),
    ({"obstacles": [{"name": "mast", "shape": {"kind": "box", "min": [30.0, 8.0, 0.0], "max": [31.0, 9.0, 20.0]}}]},
     "water.scheme"),
])
def test_bad_input_is_refused(tmp_path, changes, key):
    """In two lines, with key, value and what is allowed."""
    file = tmp_path / "scene.toml"
    file.write_text(table_text(tables(**changes)), encoding="utf-8")
    with pytest.raises(InputError, match=key.replace(".", r"\.")) as refused:
        Simulation(snowmpm.load_scene(file))
    assert len(str(refused.value).splitlines()) <= 2
