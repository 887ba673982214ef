"""Columns of snow are drawn from the ground to their surface."""

import numpy as np

from snowmpm.render.view import piled


def test_piles_reach_from_the_ground_to_the_surface():
    points = np.array([[0.0, 0.0, 11.0], [5.0, 0.0, 20.5]])  # at half their depth
    depth, colours = np.array([2.0, 1.0]), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found, own, none = piled(points, depth, 0.75, colours, None)
    first = found[found[:, 0] == 0.0, 2]
    assert sorted(first)[0] == 10.0 and sorted(first)[-1] == 12.0 and np.diff(sorted(first)).max() <= 0.75
    assert (own[found[:, 0] == 5.0] == [0.0, 1.0, 0.0]).all() and len(own) == len(found) and none is None


def test_particles_without_a_depth_stay_as_they_are():
    points = np.zeros((3, 3))
    found, colours = piled(points, np.zeros(3), 1.0, None)
    assert found is points and colours is None
