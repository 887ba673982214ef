"""A small massif, and a region on it, for all tests of regions."""

import warnings

import numpy as np
import pytest

pytest.importorskip("rasterio")
pytest.importorskip("pyogrio")

from snowmpm.region import massif
from snowmpm.region.elevations import Grid, write_blocks
from snowmpm.terrain.reference_system import ReferenceSystem
from tests.support.region import TEXT


@pytest.fixture(scope="package")
def scheduler():
    """Address of a scheduler with two workers, which are started when the first test wants them."""
    pytest.importorskip("distributed")
    from snowmpm.campaigns import cluster
    from snowmpm.campaigns.spec import Cluster

    with cluster.site(Cluster(workers=2)) as found:
        yield found.client.scheduler.address


@pytest.fixture(scope="session")
def terrain(tmp_path_factory):
    """GeoTIFF of 4 km by 4 km in cells of 10 m, somewhere steep."""
    folder = tmp_path_factory.mktemp("massif")
    return massif.write(folder / "massif.tif", side=4000.0, cell=10.0, seed=4)


@pytest.fixture
def region_file(terrain, tmp_path):
    """Function of further TOML text -> path of the file of a region."""
    (tmp_path / "massif.tif").write_bytes(terrain.read_bytes())

    def made(more="", text=TEXT, name="region.toml"):
        path = tmp_path / name
        path.write_text(text.format(more=more))
        return path

    return made


@pytest.fixture(autouse=True)
def quiet():
    """Without warnings of packages that read files."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        yield


@pytest.fixture
def raster(tmp_path):
    """Function of heights (rows from the north, columns), their cell -> GeoTIFF."""

    def made(z, cell=5.0, name="ground.tif", system="EPSG:21781", corner=(600_000.0, 200_000.0)):
        found = system and ReferenceSystem.named(system, "test")
        grid = Grid(corner[0], corner[1] + z.shape[0] * cell, cell, *z.shape, found)
        return write_blocks(tmp_path / name, grid, [((0, z.shape[0]), (0, z.shape[1]), np.asarray(z, float))])

    return made
