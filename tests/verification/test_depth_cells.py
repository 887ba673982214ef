"""Depth-averaged avalanches on cells of half the size: areas, deposit and run-out hardly change."""

from pathlib import Path

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes.schema import Scene

pytestmark = pytest.mark.slow
TERRAIN = Path(__file__).resolve().parents[3] / "shared" / "data" / "terrain"
PATHS = {"avaGar": ("avaGar.asc", "relGar.shp"), "avaAlr": ("avaAlr.tif", "relAlr.shp")}
FILMS = {("avaGar", 0.1), ("avaAlr", 0.1), ("avaAlr", 0.5)}
"""Areas that change by more."""
BEYOND = (0.1, 0.5, 1.0, 2.0)
"""Thickness [m] beyond which areas are counted."""


def test_the_made_up_valley(tmp_path):
    found = []
    for dx in (5.0, 2.5):
        changes = {"solver.dx": dx, "output.map_cell": 5.0, "output.interval": 20.0, "end_time": 240.0}
        run = snowmpm.run(snowmpm.load_scene("avalanche_depth_averaged", changes), tmp_path / f"{dx:g}")
        found.append(run.hazard["numbers"])
    for name in ("affected_area", "area_above_1_kPa", "area_above_10_kPa", "deposit_area", "runout",
                 "largest_flow_speed"):
        assert found[1][name] == pytest.approx(found[0][name], rel=0.05), name


@pytest.fixture(scope="module", params=list(PATHS))
def areas(request, tmp_path_factory):
    """Name of a path, areas (2, 4) beyond BEYOND, and those of the deposit (2,), on cells of 5 and of 2.5 m."""
    raster, release = PATHS[request.param]
    if not (TERRAIN / raster).exists():
        pytest.skip("needs the terrain of AvaFrame")
    found, deposits = [], []
    for dx in (5.0, 2.5):
        run = snowmpm.run(Scene.model_validate({
            "name": "path", "dimension": 3, "end_time": 400.0, "output": {"interval": 20.0, "map_cell": 5.0},
            "solver": {"method": "depth", "dx": dx},
            "terrain": {"kind": "dem", "file": str(TERRAIN / raster),
                        "friction": {"law": "voellmy", "mu": 0.25, "xi": 2000.0}},
            "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
            "bodies": [{"name": "release", "material": "snow",
                        "shape": {"kind": "layer", "top": 1.5, "region": {"file": str(TERRAIN / release)}}}]}),
            tmp_path_factory.mktemp("path"))
        peak = np.nan_to_num(run.maps["peak_thickness"].values)
        found.append([(peak > least).sum() for least in BEYOND])
        deposits.append(run.hazard["numbers"]["deposit_area"])
    return request.param, np.array(found, float), np.array(deposits)


@pytest.mark.parametrize("k", range(len(BEYOND)), ids=[f"{one:g} m" for one in BEYOND])
def test_areas_on_a_real_path(areas, k, request):
    if (areas[0], BEYOND[k]) in FILMS:
        request.applymarker(pytest.mark.xfail(strict=True, reason="5 to 7 % less: films spread less far over gullies"
                                                                  " that finer cells see"))
    coarse, fine = areas[1][:, k]
    assert fine == pytest.approx(coarse, rel=0.05)


def test_the_deposit_on_a_real_path(areas, request):
    if areas[0] == "avaAlr":
        request.applymarker(pytest.mark.xfail(strict=True, reason="7.5 % less than on cells of 5 m"))
    coarse, fine = areas[2]
    assert fine == pytest.approx(coarse, rel=0.05)
