"""The elevation raster of the scene library."""

from pathlib import Path

import numpy as np

from snowmpm.terrain import generate_valley, load_terrain
from tests.support.tables import Table as Spec

FOLDER = Path(__file__).parents[2] / "scenes" / "library"


def test_regenerating_gives_the_shipped_files(tmp_path):
    generate_valley.write(tmp_path)
    for name in ("valley.asc", "valley_release.geojson"):
        assert (tmp_path / name).read_text() == (FOLDER / name).read_text()


def test_it_is_an_avalanche_path():
    surface = load_terrain(Spec(kind="dem", file=str(FOLDER / "valley.asc")))
    corner = np.array(generate_valley.CORNER)
    plan = corner + np.array([[180.0, 260.0], [400.0, 260.0], [850.0, 260.0]])
    dip = np.degrees(np.arccos(surface.smooth_normal(plan, 60.0)[:, 2]))
    assert 32.0 < dip[0] < 40.0 and 22.0 < dip[1] < 34.0 and dip[2] < 6.0
    assert np.isnan(surface.height((corner + 8.0)[None])).all()  # no-data
