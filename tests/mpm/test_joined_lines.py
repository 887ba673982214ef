"""Walls oblique to the grid that meet (`joined_lines`, `joined_contact`): their functions of motion and force."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.mpm.contact.lines import REACH
from snowmpm.particles.blocks import EDGE
from snowmpm.study.problems.schemes import APIC
from snowmpm.study.problems.self_weight_column import SNOW, column

FINE = 200
"""Points of quadrature a cell, along the wall."""


@pytest.fixture(scope="module")
def corner():
    """A column turned by 30 degrees, between walls that meet its base; nodes hold the masses of its particles."""
    solver, _, _ = column(SNOW, 3.75, replace(APIC, gradient="shape"), 0.0, np.pi / 6, cells=12)
    solver.step(solver.stable_dt()[0])
    walls = [surface for surface in solver.grid.surfaces if surface.geometry.stored]
    assert len(walls) == 3 and all(wall._joined for wall in walls)
    return solver, walls


def nodes_of(grid):
    """Coordinates [cells] of the nodes of the contact blocks, and their numbers in `grid.nodes`."""
    blocks, edge = grid.contact, EDGE[2]
    within = np.stack(np.meshgrid(np.arange(edge), np.arange(edge), indexing="ij"), axis=-1).reshape(-1, 2)
    places = (edge * blocks.coordinates.to_numpy()[: blocks.n, None] + within).reshape(-1, 2)
    return places, slice(grid.contact_offset, grid.contact_offset + len(places))


def spline(x):
    x = np.abs(x)
    return np.where(x < 0.5, 0.75 - x * x, 0.5 * np.maximum(1.5 - x, 0.0) ** 2)


def test_no_pressure_does_work_on_a_line(corner):
    """Of a uniform pressure on the part of the wall that no other wall hides, on each line's function of motion.
    Without the neighbours' part it is up to 0.09 at the corner [cells]."""
    solver, walls = corner
    places, _ = nodes_of(solver.grid)
    rows = 1 + REACH["quadratic"]
    for wall in walls:
        ints, numbers = wall._joined.ints.to_numpy(), wall._joined.numbers.to_numpy()
        n = numbers[0, :2]
        foot = places[ints[0, 0]] - numbers[0, 2] * n
        seen = foot + np.arange(-60.0, 60.0, 1.0 / FINE)[:, None] * np.array([n[1], -n[0]])
        for other in walls:
            if other is not wall:
                seen = seen[other.geometry.distance(seen) > 0.0]

        def area(place, seen=seen):
            return (spline(seen - places[place]).prod(axis=1)).sum() / FINE if place >= 0 else 0.0

        areas = np.array([[area(place) for place in line[: rows + 1]] for line in ints])
        g = np.eye(len(ints))  # one line moves
        d_above, kappa, share = numbers[:, 2 + rows], numbers[:, 3 + rows], numbers[:, 4 + rows]
        e = -(share * d_above)[:, None] * g
        for i, other in enumerate(ints[:, rows + 1]):
            if other >= 0:
                pair = kappa[i] * (g[other] - g[i])
                e[i] += pair
                e[other] += pair
        alone = np.einsum("ij,ij->i", areas[:, :rows], numbers[:, 2 : 2 + rows])
        work = np.diag(alone) @ g - areas[:, :rows].sum(axis=1)[:, None] * e
        ends = np.flatnonzero((ints[:, rows + 1] < 0) | (ints[:, rows + 2] < 0))  # where the table of lines ends
        free = np.setdiff1d(np.arange(len(ints)), ends)
        assert np.abs(alone).max() > 0.05
        assert np.abs(work.sum(axis=0)[free]).max() < 2e-3
        above = areas[:, rows] - areas[:, :rows].sum(axis=1) * share
        assert np.abs(above[ints[:, rows] >= 0]).max() < 2e-3


def test_keeps_what_the_wall_lets_move(corner):
    """A normal velocity linear in the distance, and any tangential one that is linear, pass unchanged."""
    solver, walls = corner
    grid = solver.grid
    places, here = nodes_of(grid)
    for wall in walls:
        nodes, d = grid.nodes.to_numpy(), wall.geometry.distance(places.astype(float))
        n = wall._joined.numbers.to_numpy()[0, :2]
        v = 0.3 * d[:, None] * n + (0.7 * d + 0.2 * (places @ [n[1], -n[0]]))[:, None] * [n[1], -n[0]]
        nodes[here, :2] = v
        grid.nodes.from_numpy(nodes)
        wall.apply_contact(grid, solver.dx)
        held = np.unique(wall._joined.ints.to_numpy()[:, : 1 + REACH["quadratic"]])
        held = held[(held >= 0)]
        held = held[nodes[here][held, 3] > 0.0]
        off = grid.nodes.to_numpy()[here][held, :2] - v[held]
        assert np.abs(off).max() < 2e-3 * 0.3


def test_never_adds_energy(corner):
    solver, walls = corner
    grid, rng = solver.grid, np.random.default_rng(3)
    places, here = nodes_of(grid)
    for wall in walls:
        nodes = grid.nodes.to_numpy()
        nodes[here, :2] = rng.standard_normal((len(places), 2))
        grid.nodes.from_numpy(nodes)
        before = (nodes[here, 3:] * nodes[here, :2] ** 2).sum()
        total = wall.total.copy()
        wall.apply_contact(grid, solver.dx)
        after = grid.nodes.to_numpy()[here]
        assert (after[:, 3:] * after[:, :2] ** 2).sum() < before
        gained = (after[:, 3:] * after[:, :2]).sum(axis=0) - (nodes[here, 3:] * nodes[here, :2]).sum(axis=0)
        assert wall.total[:2] - total[:2] == pytest.approx(gained, rel=1e-9)
