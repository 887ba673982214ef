"""Depth and speed over map cells of a frame: sums by cell, wherever the particles are."""

from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.io.thalweg_time import _over_cells

CELL = 2.0


@pytest.mark.parametrize("away", [0.0, -1e4, 1e12], ids=["near", "beside", "far away"])
def test_cells_hold_what_lies_in_them(away):
    """One particle is `away`, which changes nothing of the others."""
    rng = np.random.default_rng(0)
    plan = np.concatenate([rng.uniform(-9.0, 11.0, (200, 2)), [[away, 3.0]]])
    speed, volume = rng.random(201), rng.random(201)
    fields = {"volume": volume, "J": np.ones(201)}
    run = SimpleNamespace(maps={"peak_depth": SimpleNamespace(cell=CELL)})
    middles, depth, mean = _over_cells(run, SimpleNamespace(fields=fields), plan, speed)
    cells = {}
    for place, v, u in zip(np.floor(plan / CELL), volume, speed, strict=True):
        held = cells.setdefault(tuple(place), [0.0, 0.0])
        held[0] += v
        held[1] += v * u
    assert [tuple(middle) for middle in middles] == [tuple((np.array(key) + 0.5) * CELL) for key in sorted(cells)]
    expected = np.array([cells[key] for key in sorted(cells)])
    np.testing.assert_allclose(depth, expected[:, 0] / CELL**2, rtol=1e-12)
    np.testing.assert_allclose(mean, expected[:, 1] / expected[:, 0], rtol=1e-12)
