"""Merging of parts of ground: what faces one way becomes one, in whatever order it is numbered."""

import numpy as np
import pytest

from snowmpm.region import merging
from snowmpm.region.merging import ROUND, SIZE, Parts


def vectors(angle):
    angle = np.radians(angle)
    return np.stack([np.sin(angle), np.cos(angle)])


def merged(angle, scale, largest=np.inf, cell=5.0):
    mask = np.ones(angle.shape, bool)
    parts, number = merging.cells_as_parts(mask, vectors(angle))
    found, label = merging.merge(parts, cell, scale, largest)
    return found, label[number]


def test_a_plane_is_one_part_with_its_perimeter():
    found, label = merged(np.full((30, 40), 17.0), 1e3)
    assert label.max() == 0
    assert found.sums[0, SIZE] == 1200 and found.sums[0, ROUND] == 140


@pytest.mark.parametrize(("angle", "kept"), [(8.0, 1), (60.0, 2)])
def test_two_faces_merge_by_the_angle_between_them(angle, kept):
    """Of two squares of n cells the loss is 2 n (1 - cos(angle / 2)), which grows over a ridge."""
    left = np.where(np.arange(40) < 20, 0.0, angle) + np.zeros((20, 1))
    found, label = merged(left, 400.0)
    assert label.max() + 1 == kept
    assert found.sums[:, SIZE].sum() == 800
    if kept == 2:
        assert len(np.unique(label[:, :20])) == 1 and label[0, 0] != label[0, -1]


def test_the_cost_is_that_of_the_formula():
    mask = np.ones((1, 2), bool)
    parts, _ = merging.cells_as_parts(mask, vectors(np.array([[-30.0, 30.0]])))
    loss = 2.0 - 2.0 * np.cos(np.radians(30.0))
    divides = 2.0 * np.sin(np.radians(30.0))
    shape = 6.0 * np.sqrt(2.0) - 8.0
    expected = 25.0 * (loss * (1.0 + merging.RIDGE * divides) + merging.SHAPE * shape)
    assert merging.costs(parts, 5.0)[0] == pytest.approx(expected, rel=1e-12)
    hollow, _ = merging.cells_as_parts(mask, vectors(np.array([[30.0, -30.0]])))
    assert merging.costs(hollow, 5.0)[0] == pytest.approx(25.0 * (loss + merging.SHAPE * shape), rel=1e-12)


def test_the_order_of_parts_does_not_matter():
    """Other numbers, the same areas. Equal costs are decided by number: these have none."""
    random = np.random.default_rng(5)
    angle = np.cumsum(random.normal(0.0, 8.0, (25, 25)), axis=1)
    parts, number = merging.cells_as_parts(np.ones((25, 25), bool), vectors(angle))
    first = merging.merge(parts, 5.0, 40.0)[1][number]
    order = random.permutation(len(parts.sums))
    place = np.argsort(order)
    moved = Parts(parts.sums[order], *merging.edges_of(*place[parts.edges].T, parts.borders))
    other = merging.merge(moved, 5.0, 40.0)[1][place[number]]
    assert len(np.unique(first)) > 5
    pairs = np.unique(np.stack([first.ravel(), other.ravel()], axis=1), axis=0)
    assert len(pairs) == len(np.unique(first)) == len(np.unique(other))


def test_no_part_is_larger_than_asked_for():
    found, label = merged(np.full((40, 40), 3.0), 1e9, largest=25.0 * 100)
    assert found.sums[:, SIZE].max() <= 100
    assert found.sums[:, SIZE].sum() == 1600 and label.max() + 1 == len(found.sums)
