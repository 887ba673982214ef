"""Scenes end to end: library scenes take their first steps, map coordinates cost nothing, loads trigger, real data."""

from pathlib import Path

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes import library
from tests.support.made_path import THICKNESS, write_path

RELEASE = Path(__file__).with_name("release.toml")
REAL = Path(__file__).parents[1] / ".." / "shared" / "data" / "terrain"

FIRST = {"end_time": 0.02, "output.interval": 0.01, "initial.stress": "geostatic"}
SHORT = {"end_time": 4e-6, "output.interval": 2e-6, "initial.stress": "none"}
COARSE = {
    "column_collapse_2d": {"solver.dx": 0.025},
    "column_collapse_3d": {"solver.dx": 0.05},
    "elastic_beam": {"solver.dx": 0.1 / 3},
    "flume_impact": {"solver.dx": 0.05},
    "oedometer": {"solver.dx": 0.25, "initial.stress": "isotropic"},
    "sand_between_plates": {"solver.dx": 0.02},
    "slope_failure": {"solver.dx": 1.0},
    "slab_release_2d": {"solver.dx": 0.2},
    "remote_trigger_2d": {"solver.dx": 0.2},
    "whumpf_2d": {"solver.dx": 0.2},
    "skier_trigger": {"solver.dx": 0.2},
    "natural_release": {"solver.dx": 0.2},
    "microstructure_2d": {"solver.dx": 1e-4, **SHORT},
    "microstructure": {"solver.dx": 2e-4, **SHORT},
    "slab_release": {"solver.dx": 0.64},
    "slab_release_resolved": {"solver.dx": 0.5, "solver.particles_per_cell": 4},
    "crown_and_flanks": {"solver.dx": 0.5},
    "avalanche_on_raster": {"solver.dx": 3.0},
    "avalanche_depth_averaged": {"solver.dx": 10.0},
    "slushflow": {"solver.dx": 10.0},
    "flow_cold_dense": {"solver.dx": 0.5},
    "flow_warm_shear": {"solver.dx": 0.5},
    "flow_sliding_slab": {"solver.dx": 0.5},
    "flow_warm_plug": {"solver.dx": 0.5},
    "impact_wall_2d": {"solver.dx": 0.25},
    "impact_wedge_2d": {"solver.dx": 0.25},
    "impact_mast": {"solver.dx": 0.4},
    "boulders_2d": {},
    "block_wall_2d": {"solver.dx": 0.0625},
    "slush_dam_2d": {"solver.dx": 0.1, "initial.stress": "none"},
    "flexible_wall_2d": {},
    "fence_2d": {"initial.stress": "none"},
    "mast": {"domain.max": [2.0, 2.4, 4.0], "solver.particles_per_cell": 1},
    "pst_2d": {"solver.dx": 0.05},
    "pst": {"solver.dx": 0.05, "saw_test.length": 1.5},
}


def test_every_library_scene_has_a_coarse_form():
    assert set(COARSE) == set(library())


@pytest.mark.parametrize("name", sorted(COARSE))
def test_library_scene_takes_its_first_steps(name, tmp_path):
    scene = snowmpm.load_scene(name, {**FIRST, **COARSE[name]})
    run = snowmpm.run(scene, tmp_path)
    assert len(run) == 3 and run.complete
    frame = run.frame(-1)
    assert np.isfinite(frame.points).all() and len(frame) == run.summary["particles"]
    assert run.history["momentum_residual"][-1] < 1e-5  # float32
    assert run.history["unconverged"][-1] == 0
    assert run.history["mass"][-1] == pytest.approx(
        run.history["mass"][0], rel=1e-8 if scene.solver.in_volumes else 1e-12)


BOTH = ("column_collapse_2d", "flume_impact", "oedometer", "sand_between_plates", "slope_failure",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("column_collapse_3d", "elastic_beam",
                                                                  "slab_release_2d")))


@pytest.mark.parametrize("name", BOTH)
def test_library_scene_takes_its_first_steps_by_sph(name, tmp_path):
    changes = {**FIRST, **COARSE[name], "solver.method": "sph"}
    run = snowmpm.run(snowmpm.load_scene(name, changes), tmp_path)
    assert len(run) == 3 and run.complete
    assert np.isfinite(run.frame(-1).points).all() and len(run.frame(-1)) == run.summary["particles"]
    assert run.history["momentum_residual"][-1] < 1e-5  # float32


def moved_release(tmp_path, name, shift):
    """The release scene, `shift` metres along x, run to 0.05 s."""
    text = RELEASE.read_text()
    ends = f"points = [[{shift}, 9.375], [{shift + 12.0}, 0.0]]"
    for before, after in (("points = [[0.0, 9.375], [12.0, 0.0]]", ends),
                          ("x = [0.5, 11.5]", f"x = [{shift + 0.5}, {shift + 11.5}]"),
                          ("x = [1.5, 10.5]", f"x = [{shift + 1.5}, {shift + 10.5}]"),
                          ("path = [[4.0, 6.0], [8.0, 3.0]]", f"path = [[{shift + 4.0}, 6.0], [{shift + 8.0}, 3.0]]")):
        assert before in text
        text = text.replace(before, after)
    path = tmp_path / f"{name}.toml"
    path.write_text(text)
    scene = snowmpm.load_scene(path, {"end_time": 0.05, "output.interval": 0.05, "initial.stress": "geostatic",
                                      "events.0.start": 0.0})
    return snowmpm.run(scene, tmp_path / name)


@pytest.mark.slow
def test_map_coordinates_lose_nothing_in_float32(tmp_path):
    """500 km east: float32 map coordinates would have a grain of 3 cm, a third of a cell."""
    here, there = (moved_release(tmp_path, name, shift) for name, shift in (("here", 0.0), ("there", 500_000.0)))
    assert there.origin[0] == pytest.approx(500_000.0, abs=1.0)
    a, b = here.frame(-1), there.frame(-1)
    order = [np.lexsort((frame.points[:, 2], frame.points[:, 0])) for frame in (a, b)]
    assert len(a) == len(b)
    # Seeding in float64 at 500 km leaves 1e-10 m; 150 float32 steps of a collapsing layer make a few ulps of that.
    np.testing.assert_allclose(a.points[order[0]], b.points[order[1]], rtol=0, atol=5e-6)
    speed = [np.linalg.norm(frame.fields["velocity"], axis=1) for frame in (a, b)]
    assert speed[0].mean() == pytest.approx(speed[1].mean(), rel=1e-4)


def test_a_load_releases_the_slab():
    """A skier-like load of 6 kN/m on the slab collapses the weak layer below; without it the slab stays."""
    load = {"kind": "load", "body": "slab", "start": 0.0, "stop": 0.5, "centre": [6.0, 5.9], "radius": 0.6,
            "force": [0.0, -6000.0]}
    collapsed = []
    for events in ([], [load]):
        simulation = snowmpm.Simulation(snowmpm.load_scene(RELEASE, {"events": events}))
        while simulation.time < 0.5:
            simulation.step(until=0.5)
        particles = simulation.particles
        collapsed.append((particles["damage"][particles["material"] == 1] > 0.99).mean())
    assert collapsed[0] == 0.0 and collapsed[1] > 0.05


def test_terrain_and_release_from_files(tmp_path):
    """Release polygon and thickness from a shapefile on a raster in map coordinates, 41 % of it no-data."""
    pytest.importorskip("shapefile")
    path = write_path(tmp_path / "path")
    scene = snowmpm.load_scene("avalanche_on_raster", {
        "terrain.file": str(path.dem), "solver.dx": 2.4, "end_time": 0.5, "output.interval": 0.5,
        "bodies.0.shape.region.file": str(path.release)})
    run = snowmpm.run(scene, tmp_path / "run")
    assert run.history["mass"][0] == pytest.approx(250.0 * THICKNESS * path.release_area(), rel=5e-3)
    assert run.history["momentum_residual"][-1] < 1e-5 and run.history["removed_particles"][-1] == 0


@pytest.mark.skipif(not (REAL / "avaGar.asc").exists(), reason="real elevation model not at hand")
def test_real_terrain(tmp_path):
    """Release polygon and thickness from a shapefile on a raster in map coordinates, 41 % of it no-data."""
    pytest.importorskip("shapefile")
    scene = snowmpm.load_scene("avalanche_on_raster", {
        "terrain.file": str((REAL / "avaGar.asc").resolve()), "solver.dx": 2.4, "end_time": 0.5, "output.interval": 0.5,
        "bodies.0.shape.region.file": str((REAL / "relGar.shp").resolve())})
    run = snowmpm.run(scene, tmp_path)
    slope_area = 51_463.0  # m2 along the slope of 40 700 m2 in plan
    assert run.history["mass"][0] == pytest.approx(250.0 * 1.2 * slope_area, rel=0.01)  # curved ground: 0.4 % measured
    assert run.history["momentum_residual"][-1] < 1e-5 and run.history["removed_particles"][-1] == 0
    assert 0.2 < run.history["max_speed"][-1] < 9.81 * 0.5  # it starts to slide, slower than free fall
    assert {"peak_depth", "peak_speed"} <= set(run.maps)
    assert np.nanmax(run.maps["peak_depth"].values) == pytest.approx(1.5, abs=0.7)  # 1.2 m / cos(slope)
