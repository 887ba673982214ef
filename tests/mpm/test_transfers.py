"""What every basis, transfer and gradient must reproduce, to round-off."""

import itertools

import numpy as np
import pytest

from snowmpm.compiler import parallel, runtime
from snowmpm.materials import unpack
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.solver import MpmSolver
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.population import Population
from snowmpm.particles.store import Layout, ParticleStore
from snowmpm.schemes import TRANSFERS

from .conftest import ICE, SNOW, lattice

DX = 0.1
SECOND_MOMENT = {"quadratic": 0.25, "cubic": 1.0 / 3.0}  # in cells^2, by integrating the B-splines
# All of them in plane strain; in 3-D, whose kernels take longer to compile, each basis, gradient and transfer once.
PLANE = [(2, *case) for case in itertools.product(STENCILS, ("affine", "shape"), TRANSFERS)]
SPACE = [(3, "quadratic", "affine", "apic"), (3, "cubic", "affine", "flip"), (3, "quadratic", "shape", "aflip"),
         (3, "cubic", "shape", "pic")]
EVERY = pytest.mark.parametrize(("dim", "kernel", "gradient", "transfer"), PLANE + SPACE)


def scattered(dim, kernel, gradient, transfer, positions=None, **options):
    """Solver of a few particles at random with random masses."""
    rng = np.random.default_rng(7)
    if positions is None:
        positions = rng.uniform(-0.7, 0.7, (60, dim))
    volumes = rng.uniform(0.5, 1.5, len(positions)) * (DX / 2) ** dim
    return MpmSolver(Population(positions, volumes, 0, np.zeros_like(positions)), [ICE], dx=DX, precision="f64",
                     origin=np.full(dim, -2.0), lower=np.full(dim, -2.0), upper=np.full(dim, 2.0),
                     gravity=np.zeros(dim), kernel=kernel, gradient=gradient, transfer=transfer, **options)


def put(solver, **columns):
    """Overwrite columns of the particles."""
    table = solver.particles.table()
    for name, values in columns.items():
        table[:, solver.particles.layout.columns(name)] = values
    solver.particles.overwrite(table)


def node_places(solver):
    """Scene coordinates of every node of every tile, (n_tiles, nodes, dim)."""
    nodes = np.stack(np.meshgrid(*[np.arange(TILE[solver.dim]) - 1] * solver.dim, indexing="ij"), axis=-1)
    corner = EDGE[solver.dim] * solver.particles.blocks.coordinates
    return solver.frame.origin + DX * (corner[:, None, :] + nodes.reshape(-1, solver.dim))


def tiles_of(solver, name="tiles"):
    """Copy of the tiles in use, (n_tiles, nodes, 4)."""
    n = solver.grid.n_tiles * TILE[solver.dim] ** solver.dim
    return getattr(solver.grid, name).to_numpy()[:n].reshape(solver.grid.n_tiles, -1, 4)


def in_boxes(solver):
    """Which nodes of the tiles the particles reach; beyond them a tile holds anything."""
    box = solver.grid.active_nodes.to_numpy()[: solver.grid.n_tiles].reshape(-1, 1, 2, 3)[..., 3 - solver.dim :]
    nodes = np.array(list(np.ndindex(*[TILE[solver.dim]] * solver.dim)))
    return ((nodes >= box[:, :, 0]) & (nodes < box[:, :, 1])).all(axis=-1)


def tensors(packed, dim):
    """In-plane part of packed symmetric tensors, (n, dim, dim)."""
    return unpack(packed)[:, :dim, :dim]


@EVERY
def test_scatter_keeps_mass_its_moments_momentum_spin_and_virial(dim, kernel, gradient, transfer):
    solver = scattered(dim, kernel, gradient, transfer)
    rng = np.random.default_rng(11)
    n, d = solver.particles.count, dim * dim
    tau = rng.normal(0.0, 1e3, (n, solver.particles.layout.sym_size))
    put(solver, velocity=rng.normal(size=(n, dim)), affine=rng.normal(0.0, 3.0, (n, d)), stress=tau)
    dt = 1e-3
    with runtime.precision("f64"):
        solver.particles_to_grid(dt)
    nodes, places = tiles_of(solver), node_places(solver)
    impulse = tiles_of(solver, "impulses") if solver.flip else np.zeros_like(nodes)
    x, v, m = solver.particles.positions(), solver.particles.column("velocity"), solver.particles.masses()
    C = solver.particles.column("affine").reshape(n, dim, dim) * float(transfer in ("apic", "aflip"))
    mass, momentum = nodes[..., 3], nodes[..., :dim] + impulse[..., :dim]
    size = np.abs(m[:, None] * v).sum()
    assert mass.sum() == pytest.approx(m.sum(), rel=1e-13)
    np.testing.assert_allclose(np.einsum("bn,bna->a", mass, places), m @ x, rtol=0, atol=1e-13 * m.sum())
    np.testing.assert_allclose(momentum.sum(axis=(0, 1)), m @ v, rtol=0, atol=1e-12 * size)
    # Sum of m_i x_i x_i^T = sum over the particles of m (x x^T + D I)
    second = np.einsum("p,pa,pb->ab", m, x, x) + m.sum() * SECOND_MOMENT[kernel] * DX**2 * np.eye(dim)
    np.testing.assert_allclose(np.einsum("bn,bnk,bnl->kl", mass, places, places), second, rtol=0, atol=1e-13 * m.sum())
    # First moment of the momentum: with it both the angular momentum and the virial
    spread = np.einsum("p,pa,pb->ab", m, v, x) + SECOND_MOMENT[kernel] * DX**2 * np.einsum("p,pab->ab", m, C)
    volume = solver.particles.column("volume")[:, 0]
    virial = dt * np.einsum("p,pab->ab", volume, tensors(tau, dim))
    found = np.einsum("bna,bnk->ak", momentum, places)
    np.testing.assert_allclose(found, spread - virial, rtol=0, atol=1e-12 * size)
    assert np.abs(virial).max() > 1e-4 * size  # so that the forces are seen
    if solver.flip:
        np.testing.assert_allclose(np.einsum("bna,bnk->ak", impulse[..., :dim], places), -virial, rtol=0,
                                   atol=1e-12 * size)


@EVERY
def test_gather_gives_back_linear_fields(dim, kernel, gradient, transfer):
    solver = scattered(dim, kernel, gradient, transfer, flip_ratio=0.9)
    rng = np.random.default_rng(13)
    start, before = solver.particles.positions(), rng.normal(size=(solver.particles.count, dim))
    put(solver, velocity=before)
    (v0, dv0), (slope, dslope) = rng.normal(size=(2, dim)), rng.normal(size=(2, dim, dim))
    places, dt = node_places(solver), 1e-3
    for name, constant, linear in (("tiles", v0, slope), ("impulses", dv0, dslope)):
        array = getattr(solver.grid, name)
        values = np.zeros((*places.shape[:2], 4))
        values[..., :dim] = constant + places @ linear.T
        whole = array.to_numpy()
        if name == "tiles" or solver.flip:
            whole[: values.shape[0] * values.shape[1]] = values.reshape(-1, 4)
            array.from_numpy(whole)
    with runtime.precision("f64"):
        solver.grid_to_particles(dt)
    grid_velocity = v0 + start @ slope.T
    expected = grid_velocity
    if solver.flip:
        expected = grid_velocity + 0.9 * (before + dv0 + start @ dslope.T - grid_velocity)
    np.testing.assert_allclose(solver.particles.column("velocity"), expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(solver.particles.positions(), start + dt * grid_velocity, rtol=0, atol=1e-14)
    gradients = solver.particles.column("affine").reshape(-1, dim, dim)
    np.testing.assert_allclose(gradients, np.broadcast_to(slope, gradients.shape), rtol=0, atol=1e-12)
    A = dt * slope
    growth = np.linalg.det(np.eye(dim) + A)
    np.testing.assert_allclose(solver.particles.column("volume_ratio"), growth, rtol=0, atol=1e-14)
    assert np.abs(solver.particles.column("stress")).max() > 1e2  # Pa: 1e6 Pa times strains of 1e-3


@pytest.mark.parametrize("atomic", [False, True])
@pytest.mark.parametrize("kernel", STENCILS)
@pytest.mark.parametrize("dim", [2, 3])
def test_stencils_at_the_limit_of_drift_stay_in_their_tile(dim, kernel, atomic):
    edge, limit = EDGE[dim], STENCILS[kernel].drift_limit
    # One particle in each of 2^dim blocks along a row, then driven to the corners of what the limit allows
    homes = np.full((2**dim, dim), edge / 2 + 0.5)
    homes[:, 0] += edge * np.arange(2**dim)
    solver = scattered(dim, kernel, "affine", "apic", positions=-1.6 + DX * homes, atomic=atomic)
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


@pytest.mark.parametrize(("dim", "kernel", "gradient", "transfer"), PLANE)
def test_null_space_dies_at_once_or_as_the_flip_ratio_says(make_solver, dim, kernel, gradient, transfer):
    """Velocities that alternate from particle to particle are nothing on the grid (validation, M21)."""
    solver = make_solver(dim, DX, [0.0, 0.0], [2.4, 0.3], velocity=lambda x: [1.0 - 2.0 * (int(x[0] / 0.05) % 2), 0.0],
                         kernel=kernel, gradient=gradient, transfer=transfer, flip_ratio=0.9)
    inside = np.abs(solver.particles.positions()[:, 0] - 1.2) < 0.4  # two steps of four cells from the ends
    start = solver.particles.positions()
    for n in (1, 2):
        solver.step(1e-5)
        left = 0.9**n if solver.flip else 0.0
        np.testing.assert_allclose(np.abs(solver.particles.column("velocity")[inside, 0]), left, rtol=0, atol=1e-13)
    np.testing.assert_allclose(solver.particles.positions()[inside], start[inside], rtol=0, atol=1e-15)


@pytest.mark.parametrize(("kernel", "gradient", "transfer"), [("cubic", "shape", "aflip"), ("cubic", "affine", "apic")])
def test_momentum_of_a_spinning_block(make_solver, kernel, gradient, transfer):
    solver = make_solver(2, DX, [-0.4, -0.3], [0.4, 0.3], kernel=kernel, gradient=gradient, transfer=transfer,
                         velocity=lambda x: np.array([-8.0 * x[1] + 0.5, 8.0 * x[0] + 2.0 * np.sin(9 * x[0])]))

    def momenta():
        x, m = solver.particles.positions(), solver.particles.masses()
        v, C = (solver.particles.column(name) for name in ("velocity", "affine"))
        spin = SECOND_MOMENT[kernel] * DX**2 * (C[:, 2] - C[:, 1])
        return np.array([*(m @ v), m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0] + spin)])

    before = momenta()
    if transfer == "apic":  # the first step takes up the affine part, which the particles start without
        solver.step(solver.stable_dt()[0])
        before = momenta()
    for _ in range(200):
        solver.step(solver.stable_dt()[0])
    kept = slice(0, 3 if transfer == "apic" else 2)  # only APIC keeps the angular momentum
    np.testing.assert_allclose(momenta()[kept], before[kept], rtol=0, atol=1e-11 * np.abs(before).max())
    assert solver.particles.sorts >= 2


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


@pytest.mark.parametrize("by_row", [True, False])
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_store_moves_every_number_and_label(by_row, precision):
    rng = np.random.default_rng(19)
    store = ParticleStore(Layout(3, 1, by_row), 1000, precision)
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
