"""`snowmpm maps` and what `snowmpm info` says of an avalanche."""

import sys

import numpy as np
import pytest

from snowmpm.io import RunWriter


@pytest.fixture
def avalanche(tmp_path):
    """A run with maps and a thalweg, without particles."""
    folder = tmp_path / "avalanche"
    with RunWriter(folder, provenance={"scene_name": "valley"}, origin=[6e5, 2e5, 1e3]) as writer:
        depth = np.zeros((12, 30))
        depth[4:8, 2:26] = 1.0
        for name, unit in (("release_depth", "m"), ("peak_depth", "m"), ("peak_pressure", "Pa")):
            values = depth * (np.arange(30) < 8) if name == "release_depth" else depth
            writer.map(name, values * (5e3 if unit == "Pa" else 1.0), 5.0, 5.0, 10.0, unit)
        s = np.arange(0.0, 250.0, 10.0)
        profile = {"s": s, "x": 6e5 + 25.0 + s, "y": np.full(25, 2e5 + 60.0), "z": 1200.0 - 0.4 * s,
                   "peak_depth": np.ones(25), "peak_speed": np.ones(25), "peak_pressure": np.full(25, 5e3),
                   "deposit_depth": np.zeros(25)}
        writer.hazard({"numbers": {"runout": 230.0, "fall": 92.0, "top": 1200.0, "travel_angle": 21.8,
                                   "area_above_1_kPa": 9600.0, "flow_depth": 0.1},
                       "profile": {name: values.tolist() for name, values in profile.items()},
                       "runout_line": [[600255.0, 200030.0], [600255.0, 200090.0]]})
    return folder


def test_maps_are_written_and_numbers_said(call, avalanche):
    pytest.importorskip("rasterio")
    result = call("maps", avalanche)
    assert result.code == 0, result.err
    written = {path.name for path in (avalanche / "maps").iterdir()}
    names = ("release_depth", "peak_depth", "peak_pressure")
    assert written == {*(f"{name}.{kind}" for name in names for kind in ("tif", "png")), "thalweg.png"}
    assert "travel angle [degrees]" in result.out and "area above 1 kPa [m2]" in result.out


def test_without_rasterio_the_pictures_are_left(call, avalanche, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    refused = call("maps", avalanche)
    assert refused.code == 2 and "snowmpm[gis]" in refused.err and "--pictures" in refused.err
    result = call("maps", avalanche, "--pictures", "-o", tmp_path / "drawn")
    assert result.code == 0 and not list((tmp_path / "drawn").glob("*.tif"))
    assert (tmp_path / "drawn" / "peak_depth.png").stat().st_size > 1000


def test_info_says_how_far_it_came(call, avalanche):
    result = call("info", avalanche)
    assert result.code == 0 and "runout [m]" in result.out and "peak_pressure [Pa]" in result.out


def test_a_run_without_maps(call, tmp_path):
    with RunWriter(tmp_path / "flat", provenance={}, dimension=2):
        pass
    result = call("maps", tmp_path / "flat")
    assert result.code == 2 and "three dimensions" in result.err
