"""Numbers for "no data" that a raster does not declare are found, and real ground is not."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.terrain.raster import read_raster
from snowmpm.terrain.undeclared import undeclared_heights
from tests.support.project import ROOT

rasterio = pytest.importorskip("rasterio")

GAP = (slice(12, 17), slice(8, 16))


def mountain(rows=40, columns=30, top=2400.0):
    """A slope of 35 degrees with bumps, cells of 10 m, rows from the south."""
    x, y = np.meshgrid(10.0 * np.arange(columns), 10.0 * np.arange(rows))
    return top - np.tan(np.radians(35.0)) * x + 6.0 * np.sin(x / 40.0) * np.cos(y / 55.0)


def written(path, z, nodata=None, dtype="float32", unit=None):
    """A GeoTIFF of heights, rows from the south."""
    transform = rasterio.transform.from_origin(6e5, 5.2e6 + 10.0 * len(z), 10.0, 10.0)
    with rasterio.open(path, "w", driver="GTiff", width=z.shape[1], height=z.shape[0], count=1, dtype=dtype,
                       crs="EPSG:32632", transform=transform, nodata=nodata) as target:
        target.write(z[::-1].astype(dtype), 1)
        if unit:
            target.units = (unit,)
    return path


def text(path, z, nodata):
    head = f"ncols {z.shape[1]}\nnrows {z.shape[0]}\nxllcorner 600000\nyllcorner 5200000\ncellsize 10\n"
    head += f"NODATA_value {nodata}\n"
    path.write_text(head + "\n".join(" ".join(f"{v:.9g}" for v in row) for row in z[::-1]))
    return path


@pytest.mark.parametrize("mark", [-32768.0, -32767.0, 32767.0, -9999.0, 9999.0, -99999.0, -3.4028234663852886e38,
                                  3.4028234663852886e38, 1e20, -1e30, 0.0, -500.0, 1e6, -1.0, 99.0, 255.0])
@pytest.mark.parametrize("kind", ["tif", "declared otherwise", "asc"])
def test_gaps_of_a_mountain(tmp_path, kind, mark):
    z = mountain()
    z[GAP] = mark
    if kind == "asc":
        path = text(tmp_path / "dem.asc", z, -32768 if mark == -9999.0 else -9999)
    else:
        path = written(tmp_path / "dem.tif", z, 1.0 if kind == "declared otherwise" else None)
    with pytest.warns(UserWarning, match="40 cells hold .* taken as no data"):
        raster = read_raster(path)
    assert np.isnan(raster.z[GAP]).all() and np.isnan(raster.z).sum() == 40
    assert np.nanmin(raster.z) > 2100.0


@pytest.mark.parametrize("mark", [-32768.0, 0.0, -9999.0])
def test_gaps_of_most_of_a_raster(tmp_path, mark):
    """A warped raster is a tilted strip with numbers for "none" in the corners."""
    z = mountain(60, 60)
    row, column = np.indices(z.shape)
    z[np.abs(row - column) > 12] = mark
    with pytest.warns(UserWarning, match="cells hold .* taken as no data"):
        raster = read_raster(written(tmp_path / "dem.tif", z, -1.0))
    assert (np.isnan(raster.z) == (np.abs(row - column) > 12)).all()


def test_what_interpolation_made_of_a_gap(tmp_path):
    from scipy.ndimage import zoom

    z = mountain()
    z[GAP] = -32768.0
    mixed, whole = zoom(z, 2.0, order=1), zoom(mountain(), 2.0, order=1)
    found = undeclared_heights(mixed, 5.0)
    left = np.where(found.where, np.nan, mixed) - whole
    assert np.nanmax(np.abs(left)) < 150.0  # what is less than that lies two cells off
    assert np.isfinite(left).mean() > 0.8


@pytest.mark.parametrize(("mark", "words"), [(0.0, "40 cells hold 0, 2... m below"),
                                             (-32768.0, "40 cells hold -32768, 12... m below")])
def test_heights_in_feet(tmp_path, mark, words):
    z = mountain()
    z[GAP] = 0.3048 * mark
    with pytest.warns(UserWarning, match=words):
        raster = read_raster(written(tmp_path / "dem.tif", z / 0.3048, -1.0, unit="foot"))
    assert np.nanmin(raster.z) > 2100.0


@pytest.mark.parametrize("z", [
    mountain(top=250.0),                                                # down to the sea
    np.maximum(mountain(top=150.0), 0.0),                               # and beyond it
    np.where(np.indices((40, 30))[1] > 15, mountain() - 900.0, mountain()),  # a wall of 900 m
    np.zeros((40, 30)), np.full((40, 30), 0.0) + np.indices((40, 30))[0],
    mountain(top=-300.0)], ids=["coast", "sea", "wall", "flat", "ramp", "below the sea"])
@pytest.mark.filterwarnings("error:.*cells hold")
def test_real_ground_stays(tmp_path, z):
    assert np.isfinite(read_raster(written(tmp_path / "dem.tif", z, -1e5)).z).all()


def test_a_raster_of_nothing_else_is_refused(tmp_path):
    with pytest.raises(InputError, match="has no elevation"):
        read_raster(written(tmp_path / "dem.tif", np.full((20, 20), -32768.0), -1.0))


@pytest.mark.parametrize("mark", [-9999.0, 32767.0, -3.4028234663852886e38])
def test_other_quantities_have_no_value_there(tmp_path, mark):
    z = np.full((40, 30), 0.3)
    z[GAP] = mark
    path = written(tmp_path / "mu.tif", z, 1.0)
    with pytest.warns(UserWarning, match="40 cells hold .*: taken as no data"):
        raster = read_raster(path, key="friction.mu", quantity="friction coefficients")
    assert np.isnan(raster.z[GAP]).all() and np.nanmax(raster.z) == pytest.approx(0.3)


def test_a_byte_order_mark_is_read(tmp_path):
    path = text(tmp_path / "dem.asc", mountain(), -9999)
    plain = read_raster(path).z
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert (read_raster(path).z == plain).all()


def test_gaps_that_failed():
    folder = ROOT.parent / "shared" / "cases" / "undeclared_no_data"
    if not folder.is_dir():
        pytest.skip("needs shared/cases")
    right = read_raster(folder / "gap_declared.tif").z
    for name in ("gap_undeclared.tif", "gap_wrong_tag.asc", "gap_zero.tif"):
        with pytest.warns(UserWarning, match="40 cells hold .* taken as no data"):
            z = read_raster(folder / name).z
        assert (np.isnan(z) == np.isnan(right)).all()


@pytest.mark.parametrize(("kind", "mark"), [("uint8", 255), ("uint16", 65535), ("int16", -32768), ("int16", 32767)])
def test_the_ends_of_a_scaled_band_are_no_values(tmp_path, kind, mark):
    """0.01 m a unit: 255 would be 2.55 m of snow, 65535 would be 655 m."""
    z = np.full((20, 20), 120)
    z[GAP] = mark
    path = written(tmp_path / "thickness.tif", z, dtype=kind)
    with rasterio.open(path, "r+") as target:
        target.scales = (0.01,)
    with pytest.warns(UserWarning, match=f"40 cells hold {mark}: taken as no data"):
        raster = read_raster(path, quantity="thicknesses of snow")
    assert np.isnan(raster.z[GAP]).all() and np.nanmax(raster.z) == pytest.approx(1.2)


@pytest.mark.parametrize(("unit", "metres"), [("cm", 0.01), ("ft", 0.3048), ("m", 1.0), (None, 1.0), ("1", 1.0)])
def test_the_unit_of_a_band_of_thicknesses_counts(tmp_path, unit, metres):
    path = written(tmp_path / "thickness.tif", np.full((20, 20), 90.0), unit=unit)
    if metres == 1.0:
        raster = read_raster(path, quantity="thicknesses of snow")
    else:
        with pytest.warns(UserWarning, match="thicknesses of snow are converted to metres"):
            raster = read_raster(path, quantity="thicknesses of snow")
    assert raster.z == pytest.approx(90.0 * metres)


@pytest.mark.parametrize("mark", [-1.0, -99.0, 255.0, 500.0])
def test_gaps_of_low_mountains(tmp_path, mark):
    """The steps to them are no higher than cliffs are, but no cliff goes all round a level floor."""
    z = mountain(top=900.0)
    z[GAP] = mark
    with pytest.warns(UserWarning, match=f"40 cells hold {mark:g}, .* taken as no data"):
        raster = read_raster(written(tmp_path / "dem.tif", z))
    assert np.isnan(raster.z[GAP]).all() and np.isnan(raster.z).sum() == 40
