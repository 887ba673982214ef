"""Cells that hold material: faces between them and to the outside, sums and means over their particles."""

import numpy as np
import pytest

from snowmpm.water.cells import MaterialCells


def box(*sizes):
    """Cell of one particle in each cell of a box."""
    return np.stack(np.meshgrid(*map(np.arange, sizes), indexing="ij"), axis=-1).reshape(-1, len(sizes))


@pytest.mark.parametrize("sizes", [(4, 3), (3, 4, 2)])
def test_faces_of_a_box(sizes):
    cells = MaterialCells(box(*sizes) + 7)
    n, dim = int(np.prod(sizes)), len(sizes)
    inner = sum(n // size * (size - 1) for size in sizes)
    outer = sum(2 * n // size for size in sizes)
    assert len(cells) == n and len(cells.first) == inner and len(cells.border) == outer
    step = cells.coordinates[cells.second] - cells.coordinates[cells.first]
    np.testing.assert_array_equal(step, np.eye(dim, dtype=int)[cells.axis])
    # Behind each border face lies no cell of the box
    beyond = np.floor(cells.beyond).astype(int) - 7
    assert ((beyond < 0) | (beyond >= np.array(sizes))).any(axis=1).all()


def test_cells_apart_do_not_touch():
    cells = MaterialCells(np.array([[0, 0], [2, 0], [1, 1], [0, 5]]))
    assert len(cells.first) == 0 and len(cells.border) == 4 * 4


def test_around_a_period():
    cells = MaterialCells(box(4, 1), period=np.array([4, 0]))
    assert len(cells.first) == 4 and sorted(cells.border_axis) == [1] * 8
    pairs = {frozenset(pair) for pair in zip(cells.first.tolist(), cells.second.tolist(), strict=True)}
    assert pairs == {frozenset(pair) for pair in ((0, 1), (1, 2), (2, 3), (3, 0))}
    shifted = MaterialCells(box(4, 1) + np.array([9, 0]), period=np.array([4, 0]))
    np.testing.assert_array_equal(shifted.coordinates, cells.coordinates)


def test_a_constant_stays_as_particles_cross():
    """The mean by volume of a constant is the constant, whichever cells a moving, turning body is in."""
    rng = np.random.default_rng(3)
    x, volume = rng.uniform(-4.0, 4.0, (500, 2)), rng.uniform(0.5, 2.0, 500)
    for turn in np.linspace(0.0, 2.0, 7):
        c, s = np.cos(turn), np.sin(turn)
        cells = MaterialCells(np.floor(x @ np.array([[c, -s], [s, c]]) + turn))
        np.testing.assert_allclose(cells.mean(np.full(500, 3.7), volume), 3.7, rtol=1e-14)
        assert cells.sums(volume).sum() == pytest.approx(volume.sum(), rel=1e-14)


def test_no_particles():
    cells = MaterialCells(np.zeros((0, 2), int))
    assert len(cells) == 0 and len(cells.border) == 0
