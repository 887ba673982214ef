"""The cell sort: nothing lost, nothing moved, the same for every thread count."""

import numpy as np
import pytest

from snowmpm.compiler import parallel, runtime
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import EDGE, LEAD, BlockMap, coordinates_of, keys_of
from tests.support.mpm_block import SNOW


def stirred(x):
    return 4.0 * np.sin(7.0 * x[::-1] + np.arange(len(x)))


def by_number(solver):
    return np.argsort(solver.particles.labels()[:, 1])


def test_keys_are_ordered_and_invertible():
    rng = np.random.default_rng(3)
    coordinates = rng.integers(-5000, 5000, (500, 3))
    np.testing.assert_array_equal(coordinates_of(keys_of(coordinates), 3), coordinates)
    order = np.lexsort(coordinates.T[::-1])
    assert (np.diff(keys_of(coordinates[order])) >= 0).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_node_blocks_are_all_around_the_occupied_ones(dim):
    cells = np.random.default_rng(4).uniform(-40.0, 40.0, (60, dim))
    blocks, _, _ = BlockMap.from_cells(cells, dim)
    keys, start, tiles = blocks.node_blocks()
    expected = {}
    for tile, block in enumerate(blocks.coordinates):
        for step in np.ndindex(*[3] * dim):
            node_block = block - (np.array(step) - 1)  # whose step to the occupied block this is
            code = sum(1 << digit + 3 * axis for axis, digit in enumerate(step))
            expected.setdefault(tuple(node_block), set()).add((tile, code))
    found = [tuple(c) for c in coordinates_of(keys, dim)]
    assert found == sorted(expected) and len(start) == len(keys) + 1
    for n, node_block in enumerate(found):
        rows = tiles[start[n] : start[n + 1]]
        assert {tuple(row) for row in rows} == expected[node_block] and len(rows) == len(expected[node_block])


@pytest.mark.parametrize("dim", [2, 3])
def test_sort_moves_no_particle_and_brings_all_home(make_solver, dim):
    solver = make_solver(dim, 0.1, np.zeros(dim), np.full(dim, 0.9), velocity=stirred)
    while solver.particles.drift < 0.6:
        solver.step(solver.stable_dt()[0])
    particles = solver.particles
    before, velocity = particles.positions()[by_number(solver)], particles.column("velocity")[by_number(solver)]
    with runtime.precision("f64"):
        solver.sort()
    np.testing.assert_allclose(particles.positions()[by_number(solver)], before, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(particles.column("velocity")[by_number(solver)], velocity)
    local = particles.column("position")
    # Home is where a particle will be, up to LEAD of the stencil's limit ahead along each axis, the fastest the most
    fastest = np.linalg.norm(velocity, axis=1).max()
    lead = LEAD * STENCILS["quadratic"].drift_limit * particles.column("velocity") / fastest
    ahead = local + lead
    assert (ahead >= 0.5 - 1e-12).all() and (ahead < EDGE[dim] + 0.5 + 1e-12).all()
    assert np.abs(lead).max() > 0.5 * LEAD
    assert (np.diff(solver.particles.blocks.keys) > 0).all() and solver.particles.blocks.start[-1] == len(local)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_same_bits_for_any_division_of_work(make_solver, monkeypatch, dim):
    tables = []
    for chunks in (1, 7):
        monkeypatch.setattr(parallel, "CHUNKS_PER_THREAD", chunks)
        solver = make_solver(dim, 0.1, np.zeros(dim), np.full(dim, 0.8), law=SNOW, velocity=stirred, precision="f32")
        for _ in range(60):
            solver.step(solver.stable_dt()[0])
        with runtime.precision("f32"):
            solver.sort()
        for _ in range(5):
            solver.step(solver.stable_dt()[0])
        tables.append(solver.particles.table())
    np.testing.assert_array_equal(tables[0], tables[1])


@pytest.mark.parametrize("dim", [2, 3])
def test_atomic_scatter_agrees_with_the_tiles(make_solver, dim):
    """The GPU's scatter, run on the CPU: the same sums in another order."""
    solvers = [make_solver(dim, 0.1, np.zeros(dim), np.full(dim, 0.8), law=SNOW, velocity=stirred, atomic=atomic)
               for atomic in (False, True)]
    for _ in range(60):
        dt = solvers[0].stable_dt()[0]
        for solver in solvers:
            solver.step(dt)
    a, b = (solver.particles.column("velocity")[by_number(solver)] for solver in solvers)
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-9)  # round-off of f64, grown over 60 plastic steps
    assert solvers[0].n_plastic == solvers[1].n_plastic > 0
