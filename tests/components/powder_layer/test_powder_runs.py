"""The powder layer in runs: balances, maps that say what it is, bits, refusals."""

import hashlib
import json
import sys

import numpy as np
import pytest

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.compiler import runtime
from snowmpm.errors import InputError, SimulationError
from snowmpm.scenes import Scene
from snowmpm.setup.refusals import refuse_beyond
from tests.support.same_runs import assert_goes_on_alike
from tests.support.thread_counts import with_one_and_two_threads

NOTHING = {"suspension": "none", "core_drag": 0.0, "fall_speed": 0.0}


def scene(cloud=True, precision="f64", end=4.0, dx=2.0, **options):
    """A slab that slides down a plane of 35 degrees, with a cloud of fast suspension."""
    layer = {"kind": "layer", "top": 1.0, "region": {"x": [10.0, 50.0], "y": [15.0, 45.0]}}
    cloud = {"powder_layer": {"suspension_rate": 1e-3, **options}} if cloud else {}
    return Scene.model_validate({
        "name": "dust", "dimension": 3, "end_time": end, "output": {"interval": 1.0, "map_cell": 4.0},
        "solver": {"method": "depth", "dx": dx, "precision": precision},
        "domain": {"min": [0.0, 0.0, -140.0], "max": [160.0, 60.0, 20.0]},
        "terrain": {"kind": "plane", "angle": 35.0, "friction": {"law": "voellmy", "mu": 0.2, "xi": 2000.0}},
        "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "one", "material": "snow", "velocity": [16.0, 0.0, -11.2],
                    "shape": layer}], **cloud})


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_balances_of_a_run(precision, tmp_path):
    """Ice, air and momentum of the cloud to 1e-11 of their largest terms at every frame; the mass of the flow is what
    it gave and got, to 1e-9 (1e-6 in single precision, in which its own scheme rounds)."""
    history = snowmpm.run(scene(precision=precision, end=6.0), tmp_path / "run").history
    for name in ("ice", "air", "momentum"):
        assert history[f"cloud_{name}_residual"].max() < 1e-11
    passed = history["settled_mass"] - history["suspended_mass"] - history["removed_mass"]
    np.testing.assert_allclose(history["mass"], history["mass"][0] + passed, rtol=1e-9 if precision == "f64" else 1e-6)
    assert history["cloud_ice_mass"][-1] > 0.01 * history["mass"][0] and history["settled_mass"][-1] > 0.0
    assert history["cloud_air_taken_in"][-1] == pytest.approx(history["cloud_air_volume"][-1], rel=0.2)
    assert np.abs(history["momentum_residual"]).max() < 1e-6


def test_every_map_of_it_says_that_it_is_an_experiment(tmp_path):
    """Of heights, speeds, and pressures rho u^2 of the means; the flow's own maps are as they were."""
    run = snowmpm.run(scene(), tmp_path / "run")
    others = set(snowmpm.run(scene(cloud=False), tmp_path / "other").maps)
    added = set(run.maps) - others
    assert len(added) == 4 and all(name.endswith("_experiment") for name in added) and others < set(run.maps)
    pressure, speed = (run.maps[f"cloud_peak_{name}_experiment"] for name in ("pressure", "speed"))
    assert pressure.units == "Pa" and pressure.values.shape == run.maps["peak_pressure"].values.shape
    there = np.isfinite(pressure.values) & (pressure.values > 0.0)
    density = pressure.values[there] / speed.values[there] ** 2
    assert 1.3 < np.median(density) < 50.0


def test_a_run_ends_when_flow_and_dust_are_at_rest(tmp_path):
    """Not while the cloud's ice moves, and not as late as its air comes to rest."""
    tables = scene(end=200.0).model_dump(exclude_unset=True)
    tables |= {"terrain": {"kind": "plane", "angle": 0.0, "friction": 0.5}, "stop": {"at_rest": True}}
    run = snowmpm.run(Scene.model_validate(tables), tmp_path / "run")
    assert run.summary["ended"].startswith("came to rest") and run.times[-1] < 150.0
    assert run.history["cloud_momentum"][-1] < 0.5 * run.history["cloud_momentum"].max()


def test_check_says_that_it_is_an_experiment():
    for wanted in (True, False):
        found = advise(scene(cloud=wanted))
        assert any("an experiment" in str(one) for one in found.cautions) == wanted
        assert ("powder layer" in found.facts) == wanted


def test_a_flow_that_exchanges_nothing_is_unchanged_to_the_bit():
    """State and history of the flow with a cloud that takes and gives nothing."""
    ends = []
    for cloud in (True, False):
        simulation = snowmpm.Simulation(scene(cloud=cloud, **(NOTHING if cloud else {})))
        while simulation.time < 3.0:
            simulation.step(3.0)
        ends.append((simulation.solver.particles.state_array.copy(), simulation.audit()))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert all(ends[0][1][name] == value for name, value in ends[1][1].items())


def test_it_goes_on_to_the_bit(tmp_path):
    made = scene(cover_load=2.0, cover_stress=0.5, suspension="shear_excess", suspension_rate=1.0, profile="motpsa")
    simulation = snowmpm.Simulation(made)
    while simulation.time < 1.0:
        simulation.step(1.0)
    assert simulation.solver.adapters["powder_layer"].cloud.ice_mass > 0.0
    assert_goes_on_alike(simulation, 2.0, tmp_path)


def test_what_it_does_not_go_with_is_refused():
    """Columns, other methods, and a snow cover that the flow takes up besides."""
    tables = scene().model_dump(exclude_unset=True)
    columns = {**tables, "solver": {**tables["solver"], "depth": {"scheme": "columns"}}}
    mpm = {**tables, "solver": {**tables["solver"], "method": "mpm"}}
    cover = {**tables, "powder_layer": {"cover_load": 5.0}, "terrain": {
        **tables["terrain"], "entrainment": {"law": "rate", "growth_rate": 0.01, "thickness": 0.3}}}
    for wrong, words in ((columns, "does not go with solver.depth.scheme"), (mpm, 'needs solver.method = "depth"'),
                         (cover, "does not go with terrain.entrainment")):
        with pytest.raises(InputError, match=words):
            refuse_beyond(Scene.model_validate(wrong))


def test_one_and_two_threads_agree():
    """To the bit, on a flow that one thread alone does not take."""
    one, two = with_one_and_two_threads("tests.components.powder_layer.test_powder_runs")
    assert one["digest"] == two["digest"] and not one["serial"]


def digest():
    """Of flow and cloud after some steps, and whether one thread takes all loops."""
    simulation = snowmpm.Simulation(scene(precision="f32", dx=0.5))
    for _ in range(20):
        simulation.step(10.0)
    cloud = simulation.solver.adapters["powder_layer"].cloud
    numbers = simulation.solver.particles.state_array.tobytes() + cloud.state.tobytes() + repr(cloud.sums).encode()
    return {"digest": hashlib.sha256(numbers).hexdigest(), "serial": cloud._serial, "threads": runtime.threads()}


if __name__ == "__main__":
    runtime.start("cpu", threads=int(sys.argv[1]))
    print(json.dumps(digest()))


def test_a_cloud_that_is_no_number_ends_the_run_by_its_cell():
    simulation = snowmpm.Simulation(scene())
    simulation.step()
    cloud = simulation.solver.adapters["powder_layer"].cloud
    cloud.inner[10, 12, 2] = np.nan
    with pytest.raises(SimulationError, match=r"cell \(\d+, \d+\) has no finite height or velocity, at t"):
        simulation.step()


@pytest.mark.parametrize("value", [np.nan, -1.0])
def test_a_changed_checkpoint_is_refused(value):
    adapter = snowmpm.Simulation(scene()).solver.adapters["powder_layer"]
    state = adapter.state()
    adapter.restore(state)
    state["state"][9, 9, 0] = value
    with pytest.raises(ValueError, match="none of this scene"):
        adapter.restore(state)
