"""Friction from rasters: the value of the cell in which a place lies, in the terrain's coordinates or others."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.ground import Coulomb, MuI, RasterValue, Voellmy
from snowmpm.ground.friction import GroundFriction, on_nodes
from snowmpm.terrain.reference_system import ReferenceSystem

VALUES = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])  # from south to north
LAW = Voellmy(mu={"file": "mu.asc"}, xi=2000.0)


def write(path, values, cell=10.0, corner=(100.0, 50.0)):
    """An ESRI ASCII grid of rows from south to north; NaN is no data."""
    rows = [" ".join("-9999" if np.isnan(v) else f"{v:.6g}" for v in row) for row in values[::-1]]
    head = f"ncols {values.shape[1]}\nnrows {values.shape[0]}\nxllcorner {corner[0]}\nyllcorner {corner[1]}\n"
    path.write_text(f"{head}cellsize {cell}\nNODATA_value -9999\n" + "\n".join(rows) + "\n")


@pytest.fixture
def folder(tmp_path):
    write(tmp_path / "mu.asc", VALUES)
    return tmp_path


def test_places_have_the_value_of_their_cell(folder):
    x, y = np.array([100.0, 105.0, 109.99, 110.01, 129.0, 130.0]), np.array([50.0, 59.9, 60.1, 50.0, 69.0, 70.0])
    numbers = on_nodes(LAW, None, x, y, base_dir=folder)
    assert numbers.shape == (len(LAW.PARAMETERS._fields), 6)
    np.testing.assert_array_equal(numbers[0], [0.1, 0.1, 0.4, 0.2, 0.6, 0.6])
    np.testing.assert_allclose(numbers[1], 9.81 / 2000.0)
    assert (numbers[2:] == 0.0).all()


def test_a_single_place_reads_its_cell(folder):
    for x, y, mu in [(101.0, 51.0, 0.1), (129.0, 69.0, 0.6), (115.0, 65.0, 0.5)]:
        assert on_nodes(LAW, None, [x], [y], base_dir=folder)[0] == [mu]


def test_a_law_of_numbers_is_the_same_everywhere():
    law = Voellmy(mu=0.2, xi=1500.0, tau0=5.0, cohesion=50.0)
    numbers = on_nodes(law, None, np.zeros(4), np.arange(4.0), gravity=10.0)
    np.testing.assert_array_equal(numbers, np.repeat(np.array(law.parameters(10.0))[:, None], 4, axis=1))
    assert not GroundFriction(law, ".").varies


def test_rasters_of_two_numbers(folder):
    write(folder / "xi.asc", 1000.0 + 1000.0 * VALUES, cell=30.0)
    law = Voellmy(mu={"file": "mu.asc"}, xi={"file": "xi.asc"})
    assert law.rasters == {"mu": RasterValue(file="mu.asc"), "xi": RasterValue(file="xi.asc")}
    numbers = on_nodes(law, None, [101.0, 129.9], [51.0, 51.0], base_dir=folder)
    np.testing.assert_allclose(numbers[:2], [[0.1, 0.3], [9.81 / 1100.0] * 2])
    with pytest.raises(ValueError, match="mu, xi: a raster has no one number"):
        law.parameters()


def test_places_without_data_are_refused_with_their_number(folder):
    holed = VALUES.copy()
    holed[0, 1] = np.nan
    write(folder / "mu.asc", holed)
    x, y = np.array([105.0, 115.0, 116.0, 140.0]), np.array([55.0, 55.0, 55.0, 55.0])
    with pytest.raises(InputError, match=r"terrain.friction.mu.file = .*mu.asc.*: has no value at 3 of 4 places of the"
                                         r" grid on the terrain, the first at x = 115, y = 55"):
        on_nodes(LAW, None, x, y, base_dir=folder)
    numbers = on_nodes(LAW, None, x, y, base_dir=folder, on_terrain=np.array([True, False, False, False]))
    assert numbers[0, 0] == 0.1 and np.isin(numbers[0, 1:], VALUES).all() and numbers[0, 3] == 0.3


def test_a_raster_beside_the_terrain_is_refused(folder):
    with pytest.raises(InputError, match="has no value at 2 of 2 places"):
        on_nodes(LAW, None, [-500.0, -400.0], [55.0, 56.0], base_dir=folder)


@pytest.mark.parametrize(("value", "says"), [(12.0, "holds 12 at x = 115, y = 55"), (-0.2, "holds -0.2 at")])
def test_values_out_of_range_are_refused_where_they_are_used(folder, value, says):
    wrong = VALUES.copy()
    wrong[0, 1] = value
    write(folder / "mu.asc", wrong)
    with pytest.raises(InputError, match=rf"terrain.friction.mu.file = 'mu.asc': {says}.*must be from 0 to 10"):
        on_nodes(LAW, None, [105.0, 115.0], [55.0, 55.0], base_dir=folder)
    numbers = on_nodes(LAW, None, [105.0, 115.0], [55.0, 55.0], base_dir=folder, on_terrain=[True, False])
    assert 0.0 <= numbers[0, 1] <= 10.0


def test_values_that_contradict_each_other_are_refused(folder):
    law = MuI(mu_s=0.25, mu_2={"file": "mu.asc"}, grain_diameter=0.1, grain_density=400.0)
    with pytest.raises(InputError, match=r"terrain\.friction: mu_2 must not be below mu_s"):
        on_nodes(law, None, [105.0, 125.0], [55.0, 55.0], base_dir=folder)
    numbers = on_nodes(law, None, [105.0, 125.0], [55.0, 55.0], base_dir=folder, on_terrain=[False, True])
    assert numbers[1, 1] == pytest.approx(0.05)


@pytest.mark.parametrize(("file", "says"), [("nothing.asc", "no such file"), ("mu.png", "must be an .asc or .tif raster"
                                                                              " of values of mu")])
def test_files_that_are_no_rasters_are_refused(folder, file, says):
    (folder / "mu.png").write_bytes(b"")
    with pytest.raises(InputError, match=says):
        GroundFriction(Coulomb(mu={"file": file}), folder, None, "scene.toml").on_nodes([0.0], [0.0])


def test_a_raster_in_another_projection_is_read_at_the_same_places(folder):
    rasterio = pytest.importorskip("rasterio")
    austria, zone = ReferenceSystem.named("EPSG:31287", "here"), ReferenceSystem.named("EPSG:32633", "here")
    corner = np.array([400000.0, 450000.0])
    there = austria.carried(corner[None], zone)[0]
    # cells of 100 m around the corner, each with its own value
    values = np.arange(100.0).reshape(10, 10) / 100.0
    with rasterio.open(folder / "mu.tif", "w", driver="GTiff", width=10, height=10, count=1, dtype="float64",
                       crs="EPSG:32633", transform=rasterio.transform.from_origin(there[0] - 500.0, there[1] + 500.0,
                                                                                 100.0, 100.0)) as target:
        target.write(values[::-1], 1)
    rng = np.random.default_rng(1)
    places = corner + rng.uniform(-300.0, 300.0, (50, 2))
    moved = (austria.carried(places, zone) - there + 500.0) / 100.0
    clear = (np.abs(moved - np.round(moved)) > 1e-6).all(axis=1)
    expected = values[tuple(np.floor(moved[clear][:, ::-1]).astype(int).T)]
    found = on_nodes(Coulomb(mu={"file": "mu.tif"}), austria, *places[clear].T, base_dir=folder)[0]
    np.testing.assert_allclose(found, expected)
    with pytest.warns(UserWarning, match="the terrain names no coordinate system: taken as the same"):
        on_nodes(Coulomb(mu={"file": "mu.tif"}), None, [there[0]], [there[1]], base_dir=folder)


def test_degrees_are_refused(folder):
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(folder / "mu.tif", "w", driver="GTiff", width=3, height=3, count=1, dtype="float64",
                       crs="EPSG:4326", transform=rasterio.transform.from_origin(11.0, 48.0, 1.0, 1.0)) as target:
        target.write(np.full((3, 3), 0.3), 1)
    austria = ReferenceSystem.named("EPSG:31287", "here")
    x, y = ReferenceSystem.named("OGC:CRS84", "here").carried(np.array([[12.5, 46.5]]), austria)[0]
    with pytest.raises(InputError, match="is in degrees"):
        on_nodes(Coulomb(mu={"file": "mu.tif"}), austria, [x], [y], base_dir=folder)
