"""Two real avalanche paths at two resolutions: how far the avalanche comes must not depend on the grid.

Release 2.4 m thick, twice what the surveys of the two polygons say, on cells of at most twice that and half of them.
Run-out, fall and travel angle agree within 3 %. The affected area of the one path changes by 9.6 %, and by 1 % from 2.4
to 2 m; that of the other does not agree yet: flow that is thinner than the particles are apart, 2.4 and 1.2 m, is a
scatter of single ones, which covers the more ground the larger they are. A third of the scene's stiffness, with the
hardening three times as large, so that the strength, K times it, is the same in fewer steps.
"""

from pathlib import Path

import numpy as np
import pytest

import snowmpm

REAL = Path(__file__).parents[1] / ".." / "shared" / "data" / "terrain"
PATHS = {"Gar": ("avaGar.asc", "relGar.shp", 88.0, 4.0), "Alr": ("avaAlr.tif", "relAlr.shp", 110.0, 4.8)}
"""Elevations, release, end [s], coarser dx [m]."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (REAL / "avaGar.asc").exists(), reason="real elevation models not at hand"),
]


@pytest.fixture(scope="module", params=PATHS)
def pair(request, tmp_path_factory):
    """The runs at dx and dx / 2."""
    pytest.importorskip("shapefile")
    pytest.importorskip("rasterio")
    terrain, release, end, coarse = PATHS[request.param]
    made = []
    for dx in (coarse, 0.5 * coarse):
        scene = snowmpm.load_scene("avalanche_on_raster", {
            "terrain.file": str((REAL / terrain).resolve()), "solver.dx": dx, "end_time": end, "output.interval": 1.0,
            "bodies.0.shape.region.file": str((REAL / release).resolve()), "bodies.0.shape.top": 2.4,
            "output.map_cell": 10.0, "materials.snow.youngs_modulus": 1e6, "materials.snow.hardening": 3.0})
        made.append(snowmpm.run(scene, tmp_path_factory.mktemp(request.param)))
    return made


def change(pair, name):
    coarse, fine = (run.hazard["numbers"][name] for run in pair)
    return fine / coarse - 1.0


@pytest.mark.parametrize("name", ["runout", "fall", "travel_angle", "reach_of_1_kPa", "reach_of_30_kPa"])
def test_run_out_does_not_depend_on_the_grid(pair, name):
    assert abs(change(pair, name)) < 0.1


def test_affected_area_does_not_depend_on_the_grid(pair, request):
    if "Alr" in request.node.name:
        request.applymarker(pytest.mark.xfail(strict=True, reason="28 % less on the finer grid: scattered edges"))
    assert abs(change(pair, "affected_area")) < 0.1


def test_where_the_flow_is_two_metres_deep_does_not_depend_on_the_grid(pair):
    deep = [int((np.nan_to_num(run.maps["peak_depth"].values) >= 2.0).sum()) for run in pair]
    assert deep[1] == pytest.approx(deep[0], rel=0.1)


def test_nothing_is_lost(pair):
    for run in pair:
        numbers, history = run.hazard["numbers"], run.history
        left = 1.0 - history["removed_mass"][-1] / history["mass"][0]
        assert numbers["deposit_volume"] == pytest.approx(left * numbers["release_volume"], rel=1e-3)
        assert left > 0.95 and 20.0 < numbers["travel_angle"] < 35.0
