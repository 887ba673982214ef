"""Scenes with forest and with snow that becomes ground: maps, history, resume, and what is refused."""

import json
import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.scenes import Scene
from tests.support.same_runs import assert_same, assert_same_runs, run_with_signal

DENSITY = 200.0
WOOD = {"name": "larches", "region": {"x": [25.0, 45.0], "y": [8.0, 20.0]}, "drag": 0.02, "detrainment": 60.0}
STOPPED = {"law": "stopped", "time": 0.5}


def scene(**terrain):
    """A slab at the head of a slope of 30 degrees that runs out on the flat after 40 m."""
    return Scene.model_validate({
        "name": "wood", "dimension": 3, "end_time": 12.0, "output": {"interval": 1.0, "map_cell": 1.0},
        "solver": {"method": "depth", "dx": 1.0},
        "domain": {"min": [0.0, 0.0, -10.0], "max": [80.0, 20.0, 40.0], "boundary": {"y_min": "slip", "y_max": "slip"}},
        "terrain": {"kind": "profile", "points": [[0.0, 23.1], [40.0, 0.0], [80.0, 0.0]], "fillet": 20.0,
                    "friction": 0.3, **terrain},
        "materials": {"snow": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "slab", "material": "snow",
                    "shape": {"kind": "layer", "top": 1.0, "region": {"x": [3.0, 15.0], "y": [4.0, 16.0]}}}]})


@pytest.fixture(scope="module")
def wooded(tmp_path_factory):
    return snowmpm.run(scene(forest=[WOOD], deposition=STOPPED), tmp_path_factory.mktemp("wooded") / "run")


def test_what_is_laid_down_is_in_the_history_and_in_the_maps(wooded):
    """The deposit holds all snow: what flows, what trees stopped, and what came to rest."""
    history = wooded.history
    total = history["mass"] + history["laid_mass"] + history["removed_mass"]
    np.testing.assert_allclose(total, total[0], rtol=1e-6)
    assert history["removed_mass"][-1] == 0.0 and history["laid_mass"][-1] > 0.9 * total[0]
    assert (np.diff(history["laid_mass"]) >= 0.0).all()
    assert np.abs(history["momentum_residual"]).max() < 1e-6
    deposit = wooded.maps["deposit_depth"].values
    assert np.nansum(deposit) * 1.0 * DENSITY == pytest.approx(total[0], rel=2e-3)
    numbers = wooded.hazard["numbers"]
    assert numbers["deposit_mass"] == pytest.approx(total[0], rel=1e-6)
    assert numbers["release_mass"] == pytest.approx(total[0], rel=1e-6)
    assert wooded.summary["ended"].startswith("came to rest")


def test_trees_hold_snow_back(wooded, tmp_path):
    """Beside the forest the flow runs as far as without; in it, less far, and snow lies between the trees."""
    bare = snowmpm.run(scene(), tmp_path / "bare")
    reach = {}
    for name, run in (("bare", bare), ("wooded", wooded)):
        fast = np.nan_to_num(run.maps["peak_speed"].values) > 1.0
        reach[name] = [np.flatnonzero(fast[rows].any(axis=0)).max() for rows in (slice(4, 6), slice(12, 14))]
    assert abs(reach["wooded"][0] - reach["bare"][0]) <= 2
    assert reach["wooded"][1] < reach["bare"][1] - 5
    within = np.nan_to_num(wooded.maps["deposit_depth"].values[10:15, 27:33]).mean()
    assert within > 0.02 > np.nan_to_num(bare.maps["deposit_depth"].values[10:15, 27:33]).mean()


@pytest.mark.parametrize("stop", [pytest.param(2.3, marks=pytest.mark.slow), 6.7])
def test_resumed_to_the_bit(tmp_path, wooded, stop):
    """Stopped while it runs through the trees, and while it comes to rest."""
    parts = tmp_path / "parts"
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(scene(forest=[WOOD], deposition=STOPPED), parts, signal.SIGTERM, stop)
    run = snowmpm.run(scene(forest=[WOOD], deposition=STOPPED), parts, resume=True)
    assert_same_runs(wooded.path.parent, parts)
    for name, one in wooded.maps.items():
        assert_same(one.values, run.maps[name].values, name)


def grid(folder, values, name):
    rows, columns = values.shape
    head = f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n"
    (folder / name).write_text(head + "\n".join(" ".join(f"{value:g}" for value in row) for row in values) + "\n")
    return {"file": str(folder / name)}


def numbers(**forest):
    """Drag and detrainment at the nodes of the plan grid (nx, ny, 2)."""
    from snowmpm.components.forest_and_deposition.from_scene import forest_at

    simulation = snowmpm.Simulation(scene(forest=[forest]))
    places = simulation.solver.grid.places()
    return forest_at(simulation.scene, simulation.model.surface, places.reshape(-1, 2)).reshape(*places.shape)


def test_region_polygons_and_rasters_say_where_trees_are(tmp_path):
    """The same forest as a box, a polygon file and rasters without region."""
    box = numbers(**WOOD)
    assert (box[30, 10] == [0.02, 60.0]).all() and (box[24, 10] == 0.0).all() and (box[30, 7] == 0.0).all()
    ring = [[25.0, 8.0], [45.0, 8.0], [45.0, 20.0], [25.0, 20.0], [25.0, 8.0]]
    file = tmp_path / "wood.geojson"
    file.write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    with pytest.warns(UserWarning, match="coordinate system"):
        polygon = numbers(**{**WOOD, "region": {"file": str(file)}})
    drag, K = np.full((20, 80), -9999.0), np.zeros((20, 80))
    drag[:12, 25:45], K[:12, 25:45] = 0.02, 60.0  # the first row is that of the largest y
    raster = numbers(name="larches", drag=grid(tmp_path, drag, "drag.asc"), detrainment=grid(tmp_path, K, "k.asc"))
    np.testing.assert_array_equal(polygon, box)
    np.testing.assert_array_equal(raster, box)


@pytest.mark.parametrize(("forest", "told"), [
    ({"name": "one", "drag": 0.01}, "terrain.forest.0.region is missing"),
    ({"name": "one", "drag": -1.0, "region": {"x": [0.0, 1.0]}}, "terrain.forest.0.drag = -1.0"),
    ({"name": "one", "detrainment": {"file": "none.tif"}}, "terrain.forest.0.detrainment.file"),
    ({"name": "one", "region": {"polygon": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]}}, "has its middle in it"),
])
def test_forest_that_cannot_be_is_refused(forest, told):
    with pytest.raises(InputError, match=told) as refused:
        snowmpm.Simulation(snowmpm.load_scene("avalanche_depth_averaged", {"terrain.forest": [forest]}))
    assert len(str(refused.value).splitlines()) <= 2


def test_numbers_of_a_raster_out_of_range_are_refused(tmp_path):
    file = grid(tmp_path, np.full((20, 80), -2.0), "drag.asc")
    with pytest.raises(InputError, match=r"holds -2 at x = .* must be from 0 to 10"):
        snowmpm.Simulation(scene(forest=[{"name": "one", "drag": file}]))


@pytest.mark.parametrize(("change", "key"), [
    ({"terrain.forest": [{"name": "one", "region": {"x": [0.0, 1.0]}}]}, "terrain.forest.0.name"),
    ({"terrain.deposition.law": "stopped"}, "terrain.deposition.law")])
def test_other_methods_refuse_them(change, key):
    with pytest.raises(InputError, match=key) as refused:
        snowmpm.Simulation(snowmpm.load_scene("avalanche_on_raster", change))
    assert 'needs solver.method = "depth"' in str(refused.value)


def test_deposition_beside_periodic_sides_is_refused():
    tables = scene(deposition=STOPPED).model_dump(exclude_unset=True)
    tables["domain"]["boundary"] = {"y_min": "periodic", "y_max": "periodic"}
    with pytest.raises(InputError, match="periodic"):
        snowmpm.Simulation(Scene.model_validate(tables))


def test_a_forest_in_a_valley_resumes_to_the_bit():
    """Its energy too: what stops takes from nodes two cells away, on which the flow may lie no more."""
    wood = {"name": "larches", "region": {"x": [600200.0, 600500.0], "y": [200100.0, 200400.0]}, "detrainment": 60.0}
    given = snowmpm.load_scene("avalanche_depth_averaged", {"solver.dx": 20.0, "terrain.forest": [wood]})
    whole, resumed = snowmpm.Simulation(given), snowmpm.Simulation(given)
    for _ in range(10):
        whole.step()
    resumed.restore(whole.state())
    for _ in range(5):
        whole.step()
        resumed.step()
    assert_same(whole.audit(), resumed.audit())
    assert whole.audit()["laid_mass"] > 0.0
