"""Runs of depth-averaged scenes: stopped and resumed to the bit, over open sides and over holes of a raster."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import SimulationError
from snowmpm.scenes import Scene, load_scene
from tests.support.same_runs import assert_same, assert_same_runs, run_with_signal

ANGLE, DX = 30.0, 1.0
NO_DATA = -9999.0


def scene(terrain=None, base_dir=None, **changes):
    """A slab of 15 x 10 m in plan, 1 m thick, on a plane of 40 m: it begins to leave after 2.5 s."""
    tables = {
        "name": "slab", "dimension": 3, "end_time": 4.0, "output": {"interval": 0.5},
        "solver": {"method": "depth", "dx": DX, "particles_per_cell": 9},
        "domain": {"min": [0.0, 0.0, -40.0], "max": [40.0, 20.0, 10.0]},
        "terrain": terrain or {"kind": "plane", "angle": ANGLE, "friction": 0.2},
        "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "slab", "material": "snow",
                    "shape": {"kind": "layer", "top": 1.0, "region": {"x": [5.0, 20.0], "y": [5.0, 15.0]}}}],
        **changes}
    return Scene.model_validate(tables)


def test_a_layer_has_its_thickness_normal_to_the_ground():
    """The volume of 1 m over 150 m2 in plan is 150 / cos m3, as in every other method."""
    audit = snowmpm.Simulation(scene()).audit()
    assert audit["mass"] == pytest.approx(200.0 * 150.0 / np.cos(np.radians(ANGLE)), rel=1e-6)


@pytest.mark.parametrize(("scheme", "stops"), [("columns", (1.7,)), ("volumes", (1.7,)), ("volumes", (0.6, 2.9))])
def test_resumed_to_the_bit(tmp_path, scheme, stops):
    """Stopped between frames, also while snow leaves: the same end, frames, history and maps."""
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    made = scene(solver={"method": "depth", "dx": DX, "particles_per_cell": 9, "depth": {"scheme": scheme}})
    snowmpm.run(made, whole)
    for i, time in enumerate(stops):
        with pytest.raises(KeyboardInterrupt):
            run_with_signal(made, parts, signal.SIGTERM, time, resume=i > 0)
    run = snowmpm.run(made, parts, resume=True)
    assert len(run.provenance["resumed"]) == len(stops)
    assert_same_runs(whole, parts)
    for name, raster in snowmpm.Run(whole).maps.items():
        assert_same(raster.values, run.maps[name].values, name)
    assert run.history["removed_mass"][-1] > 0.1 * run.history["mass"][0]


def test_history_closes(tmp_path):
    """What left is in it: mass to round-off of single precision, momentum to 1e-6."""
    history = snowmpm.run(scene(), tmp_path / "run").history
    total = history["mass"] + history["removed_mass"]
    np.testing.assert_allclose(total, total[0], rtol=1e-6)
    assert history["removed_mass"][-1] > 0.1 * total[0]
    assert np.abs(history["momentum_residual"]).max() < 1e-6
    assert (np.diff(history["contact_work"]) >= 0.0).all()


def raster(folder, hole=False):
    """The plane as an elevation raster, with or without a hole across half of the way."""
    x, y = np.meshgrid(np.arange(41) * 1.0, np.arange(21) * 1.0)
    z = -np.tan(np.radians(ANGLE)) * x
    if hole:
        z[(np.abs(x - 28.0) < 1.5) & (y > 10.5)] = NO_DATA
    head = f"ncols 41\nnrows 21\nxllcenter 0\nyllcenter 0\ncellsize 1\nNODATA_value {NO_DATA}\n"
    file = folder / ("hole.asc" if hole else "plane.asc")
    file.write_text(head + "\n".join(" ".join(f"{value:.6f}" for value in row) for row in z[::-1]) + "\n")
    return {"kind": "dem", "file": str(file), "friction": 0.2, "contact": "separate"}


@pytest.mark.parametrize("scheme", ["columns", "volumes"])
def test_a_raster_is_the_plane_that_it_holds(tmp_path, scheme):
    """To 1 %. The grids of cells lie half a cell apart; by finite volumes the front is a cell: there, to as much."""
    solver = {"method": "depth", "dx": DX, "particles_per_cell": 9, "depth": {"scheme": scheme}}
    on_plane, on_raster = (snowmpm.run(scene(terrain, end_time=2.0, solver=solver), tmp_path / name).history
                           for name, terrain in (("plane", None), ("raster", raster(tmp_path))))
    for name in ("front", "max_speed", "contact_work"):
        apart = 0.5 * DX / np.cos(np.radians(ANGLE)) if (name, scheme) == ("front", "volumes") else 0.0
        assert on_raster[name][-1] == pytest.approx(on_plane[name][-1], rel=0.01, abs=apart)


def test_snow_that_falls_into_a_hole_of_a_raster_is_counted(tmp_path):
    """Seen: a tenth of it by then."""
    with pytest.warns(UserWarning, match="30 of 861 cells without data"):
        history = snowmpm.run(scene(raster(tmp_path, hole=True), end_time=2.5), tmp_path / "holed").history
    total = history["mass"] + history["removed_mass"]
    np.testing.assert_allclose(total, total[0], rtol=1e-6)
    assert 0.05 * total[0] < history["removed_mass"][-1] < 0.5 * total[0]
    assert np.abs(history["momentum_residual"]).max() < 1e-6


def test_a_column_that_is_not_finite_is_named():
    simulation = snowmpm.Simulation(load_scene("avalanche_depth_averaged", {
        "solver.dx": 20.0, "solver.depth.scheme": "columns"}))
    store = simulation.solver.particles
    table = store.reals.to_numpy()
    table[5, 4] = np.nan
    store.reals.from_numpy(table)
    with pytest.raises(SimulationError, match=r"column \d+ has no finite velocity, at t = 0 s, step 0"):
        simulation.step()
