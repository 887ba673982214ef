"""The straight avalanche of `tests.support.straight_avalanche`."""

import pytest

pytest.importorskip("rasterio")
pytest.importorskip("pyogrio")

from tests.support.straight_avalanche import lambert, write_avalanche


@pytest.fixture(scope="session")
def straight(tmp_path_factory):
    """The run at rest, with a projection."""
    return write_avalanche(tmp_path_factory.mktemp("straight"), crs=lambert())
