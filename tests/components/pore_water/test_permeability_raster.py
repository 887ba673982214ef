"""Permeability from a raster in plan."""

import numpy as np
import pytest

from snowmpm.components.pore_water.mpm import adapter
from snowmpm.errors import InputError
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build
from tests.support.soaked_column import column

HEADER = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0.2\nNODATA_value -9999\n"


def written(folder, left, right):
    """Scene of a column over a raster whose left and right halves hold these values."""
    (folder / "k.asc").write_text(HEADER + f"{left} {right}\n" * 2)
    scene = column(0.1, dimension=3, water={"permeability": 1e-10})
    text = scene.to_toml().replace("permeability = 1e-10", 'permeability = { file = "k.asc" }')
    assert "k.asc" in text
    (folder / "raster.toml").write_text(text)
    return load_scene(folder / "raster.toml")


def test_each_place_has_its_value(tmp_path):
    model = build(written(tmp_path, 1e-9, 3e-11))
    found = adapter(model).permeability(np.array([[0.05, 0.1, 0.5], [0.35, 0.3, 0.2]]), None)
    np.testing.assert_allclose(found, [1e-9, 3e-11], rtol=1e-6)


def test_values_must_be_above_zero(tmp_path):
    with pytest.raises(InputError, match=r"water.permeability.file.*must be above 0") as refusal:
        build(written(tmp_path, 1e-9, 0.0)).solver()
    assert len(str(refusal.value).splitlines()) <= 2
