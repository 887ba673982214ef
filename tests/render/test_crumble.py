"""Loose snow is drawn as crumbs: near their particle, the same in every frame, smaller than it."""

import numpy as np

from snowmpm.render.crumble import APART, CRUMBS, LOOSE, SIZE, crumbled, few_around

SPACING = 0.2


def heap():
    """A block of 8 cells each way, and forty grains far around it."""
    block = np.stack(np.meshgrid(*[SPACING * np.arange(16)] * 3), axis=-1).reshape(-1, 3)
    return np.concatenate([block, np.random.default_rng(1).uniform(5.0, 30.0, (40, 3))])


def test_grains_on_their_own_are_loose_and_the_inside_of_a_block_is_not():
    points = heap()
    loose = few_around(points, SPACING)
    assert loose[-40:].all()
    at_corner = (np.minimum(points, 3.0 - points) < 0.5).all(axis=1)[:-40]
    assert not loose[:-40][~at_corner].any()
    assert len(few_around(np.zeros((0, 3)), SPACING)) == 0


def test_who_is_loose_is_counted_cell_by_cell():
    """Against a count of all pairs of particles in neighbouring cells."""
    points = np.random.default_rng(5).random((1500, 3)) * [9.0, 9.0, 3.0]
    cell = np.floor((points - points.min(axis=0)) / 1.0).astype(int)
    near = (np.abs(cell[:, None] - cell[None]) <= 1).all(axis=2).sum(axis=1)
    loose = few_around(points, 0.5)
    assert (loose == (near < LOOSE)).all() and loose.any() and not loose.all()


def test_crumbs_lie_around_their_particle_and_are_smaller():
    points, identity = heap(), np.arange(16**3 + 40)
    loose = few_around(points, SPACING)
    found, size, own = crumbled(points, SPACING, loose, identity)
    assert len(found) == (~loose).sum() + CRUMBS * loose.sum()
    away = np.abs(found - points[own])
    crumbs = loose[own]
    assert away[~crumbs].max() == 0.0 and 0.0 < away[crumbs].max() <= APART * SPACING
    assert (size[~crumbs] == SPACING).all()
    assert size[crumbs].min() >= 0.5 * SIZE * SPACING and size[crumbs].max() <= 1.5 * SIZE * SPACING
    assert abs(found[crumbs].mean() - points[own[crumbs]].mean()) < 0.05 * SPACING


def test_crumbs_move_with_their_particle_and_rest_with_it():
    points, identity = heap(), np.arange(16**3 + 40)
    loose = np.zeros(len(points), bool)
    loose[-40:] = True
    first = crumbled(points, SPACING, loose, identity)[0][-40 * CRUMBS:]
    turn = np.random.default_rng(2).permutation(len(points))
    moved = crumbled(points[turn] + 1.0, SPACING, loose[turn], identity[turn])
    last, own = moved[0], moved[2]
    order = np.lexsort((np.arange(len(own)), own))[-40 * CRUMBS:]
    assert np.allclose(last[order], first + 1.0)
    # Without identity, whatever the rows, as long as they rest
    first, last = (np.sort(crumbled(points[rows], SPACING, loose[rows], None)[0], axis=0)
                   for rows in (np.arange(len(points)), turn))
    assert np.allclose(first, last)
