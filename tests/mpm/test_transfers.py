"""Stencils, packs and the store: what does not depend on the transfer. What does is in `test_every_transfer`."""

import itertools

import numpy as np
import pytest

from snowmpm.compiler import parallel, runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.mpm.solver import MpmSolver
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles import store as particle_store
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.population import Population
from snowmpm.particles.store import Layout, ParticleStore, accessors
from snowmpm.schemes import BASES
from snowmpm.study.problems.schemes import lattice
from tests.support.mpm_block import ICE, SNOW
from tests.support.tiles import in_boxes, node_places, put, tiles_of

DX = 0.1


@pytest.mark.parametrize("atomic", [False, True])
@pytest.mark.parametrize("kernel", STENCILS)
@pytest.mark.parametrize("dim", [2, 3])
def test_stencils_at_the_limit_of_drift_stay_in_their_tile(dim, kernel, atomic):
    edge, limit = EDGE[dim], STENCILS[kernel].drift_limit
    # One particle in each of 2^dim blocks along a row, then driven to the corners of what the limit allows
    homes = np.full((2**dim, dim), edge / 2 + 0.5)
    homes[:, 0] += edge * np.arange(2**dim)
    positions = -1.6 + DX * homes
    volumes = np.random.default_rng(7).uniform(0.5, 1.5, len(positions)) * (DX / 2) ** dim
    solver = MpmSolver(Population(positions, volumes, 0, np.zeros_like(positions)), [ICE], dx=DX, precision="f64",
                       origin=np.full(dim, -2.0), lower=np.full(dim, -2.0), upper=np.full(dim, 2.0),
                       gravity=np.zeros(dim), kernel=kernel, atomic=atomic,
                       **({"gradient": "shape", "transfer": "pic"} if BASES[kernel].box else {}))
    assert len(solver.particles.blocks) == 2**dim
    corners = np.array(list(itertools.product((0.5 - limit, edge + 0.5 + limit - 1e-9), repeat=dim)))
    put(solver, position=corners)
    with runtime.precision("f64"):
        for _ in range(2):  # the second time with the boxes that the gather left
            solver.particles_to_grid(1e-6)
            nodes = np.where(in_boxes(solver)[..., None], tiles_of(solver), 0.0)
            np.testing.assert_allclose(nodes[..., 3].sum(axis=1), solver.particles.masses(), rtol=1e-13)
            centre = np.einsum("bn,bna->ba", nodes[..., 3], node_places(solver)) / solver.particles.masses()[:, None]
            np.testing.assert_allclose(centre, solver.particles.positions(), rtol=0, atol=1e-13)
            solver.update_grid(1e-6, 1e-6)
            solver.grid_to_particles(1e-6)
    np.testing.assert_array_equal(solver.particles.column("position"), corners)  # at rest
    assert solver.particles.drift == pytest.approx(limit, abs=1e-12)


def two_snows(**options):
    """Solver in motion, one part of one material, packs of which go through its law together, the other part of two."""
    positions, volumes = lattice([0.0, 0.0], [1.2, 0.6], DX)
    rng = np.random.default_rng(17)
    material = np.where(positions[:, 0] < 0.7, 0, rng.integers(0, 2, len(positions)))
    velocities = 4.0 * np.sin(7.0 * positions[:, ::-1] + [0.0, 1.0])
    return MpmSolver(Population(positions, volumes, material, velocities), [SNOW, ICE], dx=DX, origin=np.full(2, -10.0),
                     lower=np.full(2, -10.0), upper=np.full(2, 10.0), gravity=np.zeros(2), kernel="cubic",
                     gradient="shape", transfer="aflip", **options)


def by_number(solver, name):
    return solver.particles.column(name)[np.argsort(solver.particles.labels()[:, 1])]


def test_packs_agree_with_one_particle_at_a_time():
    packs, alone = (two_snows(precision="f64", atomic=atomic) for atomic in (False, True))
    for _ in range(60):
        dt = 0.68 * packs.stable_dt()[0]  # C = 0.4: what yields together is what is compared
        packs.step(dt)
        alone.step(dt)
        assert packs.n_plastic == alone.n_plastic
    for name in ("velocity", "affine", "state", "volume_ratio"):
        a, b = by_number(packs, name), by_number(alone, name)
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9 * np.abs(b).max())  # round-off, grown over plastic steps
    np.testing.assert_allclose(by_number(packs, "stress"), by_number(alone, "stress"), rtol=0, atol=1e-8 * 1e6)
    for name in ("speed", "gradient", "elastic_deviation"):
        assert getattr(packs.extremes, name) == pytest.approx(getattr(alone.extremes, name), rel=1e-7)
    assert packs.plastic_work == pytest.approx(alone.plastic_work, rel=1e-7) and packs.plastic_work > 0.0
    assert packs.particles.sorts == alone.particles.sorts >= 1 and packs.n_plastic > 20


def test_the_same_bits_for_any_division_of_packs(monkeypatch):
    tables = []
    for chunks in (1, 5):
        monkeypatch.setattr(parallel, "CHUNKS_PER_THREAD", chunks)
        solver = two_snows(precision="f32")
        for _ in range(60):
            solver.step(solver.stable_dt()[0])
        tables.append((solver.particles.table(), solver.particles.labels(), solver.plastic_work, solver.stable_dt()[0]))
    for first, second in zip(*tables, strict=True):
        np.testing.assert_array_equal(first, second)
    assert solver.particles.sorts >= 1


@pytest.mark.parametrize(("by_row", "precision", "paired"), [
    (True, "f32", False), (True, "f64", False), (False, "f32", False), (False, "f64", False), (False, "f32", True)])
def test_a_store_moves_every_number_and_label(by_row, precision, paired):
    rng = np.random.default_rng(19)
    store = ParticleStore(Layout(3, 1, by_row, paired=paired), 1000, precision)
    table = rng.normal(size=(1000, store.layout.width)).astype(store.numpy_dtype)
    labels = np.stack([rng.integers(0, 256, 1000), rng.integers(0, 2**31 - 1, 1000)], axis=1)
    store.replace(table, labels)
    if precision == "f32":
        assert store.bytes_per_particle <= 160
    for alive in (1000, 900, 900, 700, 700, 700, 650):  # more often than there are slots
        kept = np.sort(rng.permutation(len(table))[:alive])
        order = rng.permutation(alive)
        target = np.full(1000, -1, np.int32)
        target[kept] = order
        store.target.from_numpy(target)
        with runtime.precision(precision):
            store.move(alive)
        moved, moved_labels = np.empty_like(table[:alive]), np.empty_like(labels[:alive])
        moved[order], moved_labels[order] = table[kept], labels[kept]
        table, labels = moved, moved_labels
        np.testing.assert_array_equal(store.table(), table)
        np.testing.assert_array_equal(store.labels(), labels)
    arrays = store.reals, store.material, store.identity, store.target
    assert sum(array.to_numpy().nbytes for array in arrays) == 1000 * store.bytes_per_particle


@pytest.mark.parametrize("by_row", [True, False])
def test_a_table_longer_than_an_index_is_written_in_pieces(by_row, monkeypatch):
    store = ParticleStore(Layout(3, 1, by_row), 100, "f32")
    monkeypatch.setattr(particle_store, "LARGEST_INDEX", 7 * store.layout.width + 3)
    table = np.random.default_rng(5).normal(size=(100, store.layout.width)).astype(np.float32)
    store.replace(table, np.zeros((100, 2), int))
    np.testing.assert_array_equal(store.table(), table)


def test_numbers_share_entries_where_they_cannot_be_told_apart_otherwise():
    single = Layout(3, 1, by_row=False)
    most = single.most_particles
    assert single.fitting(most, "f32") is single and single.fitting(most + 1, "f64") is single
    paired = single.fitting(most + 1, "f32")
    assert paired.paired and paired.most_particles > 1.99 * most and paired.tables[1] % 2 == 0
    by_row = Layout(3, 1)
    assert by_row.fitting(2 * most, "f32") is by_row


@pytest.mark.parametrize(("offset", "n"), [(0, 3), (3, 3), (4, 2), (5, 1), (6, 9), (11, 12)])
def test_parts_of_a_paired_row(offset, n):
    """Whatever columns are stored, those beside them stay, in tables that part in the middle of them."""
    layout = Layout(3, 1, by_row=False, paired=True)
    access, store = accessors(layout), ParticleStore(layout, 20, "f32")
    rng = np.random.default_rng(offset)
    table = rng.normal(size=(20, layout.width)).astype(np.float32)
    store.replace(table, np.zeros((20, 2), int))
    new, seen = (rng.normal(size=(20, n)).astype(np.float32) for _ in range(2))

    @taichi_kernel
    def exchange(reals: ti.types.ndarray(), slot_offset: int, new: ti.types.ndarray(), seen: ti.types.ndarray()):
        for p in range(20):
            places = access.places(reals, slot_offset)
            values = access.load(reals, places, p, offset, n)
            access.store(reals, places, p, offset, ti.Vector([new[p, c] for c in ti.static(range(n))]))
            for c in ti.static(range(n)):
                seen[p, c] = values[c]

    with runtime.precision("f32"):
        exchange(store.reals, store.slot_offset, new, seen)
    np.testing.assert_array_equal(seen, table[:, offset : offset + n])
    table[:, offset : offset + n] = new
    np.testing.assert_array_equal(store.table(), table)
