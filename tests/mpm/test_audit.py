"""The audit: energies that close, motion that the grid does not see, cells that a body was stretched out of."""

import os
import subprocess
import sys

import numpy as np
import pytest

from snowmpm.compiler import runtime
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.fields import ParticleFields
from snowmpm.particles.population import Population
from snowmpm.running.audit import Audit, occupied_and_emptied
from snowmpm.study.problems.schemes import lattice
from tests.support.audited import audit_of
from tests.support.mpm_block import ICE


def spline(x):
    x = np.abs(x)
    return np.where(x < 0.5, 0.75 - x**2, np.where(x < 1.5, 0.5 * (1.5 - x) ** 2, 0.0))


@pytest.mark.parametrize(("dim", "atomic"), [(2, False), (3, False), (2, True)])
def test_kinetic_energy_of_the_grid_is_that_of_all_its_nodes(make_solver, dim, atomic):
    """Against a sum over a dense array of nodes; blocks of 8 or 4 cells, so that nodes lie in up to 2^dim tiles."""
    solver = make_solver(dim, 0.1, np.full(dim, -0.45), np.full(dim, 0.45), velocity=lambda x: np.sin(9 * x + 1),
                         atomic=atomic)
    for _ in range(30):
        solver.step(solver.stable_dt()[0])
    found = solver.grid_kinetic_energy()
    x, v = (solver.particles.positions() - solver.frame.origin) / solver.dx, solver.particles.column("velocity")
    c, m = solver.particles.column("affine").reshape(-1, dim, dim), solver.particles.masses()
    low = np.floor(x.min(axis=0)).astype(int) - 2
    nodes = np.stack(np.meshgrid(*[np.arange(14)] * dim, indexing="ij"), axis=-1).reshape(-1, dim) + low
    arm = nodes[:, None] - x
    share = m * spline(arm).prod(axis=-1)
    momentum = np.einsum("ip,pa->ia", share, v) + solver.dx * np.einsum("ip,pab,ipb->ia", share, c, arm)
    mass = share.sum(axis=1)
    filled = mass > 0.0
    assert mass.sum() == pytest.approx(m.sum(), rel=1e-12)
    assert found == pytest.approx(0.5 * ((momentum[filled] ** 2).sum(axis=1) / mass[filled]).sum(), rel=1e-11)


@pytest.mark.parametrize("transfer", ["apic", "flip"])
def test_no_noise_in_a_motion_that_the_transfer_carries(make_solver, transfer):
    """A uniform motion for all, a linear one for APIC."""
    linear = transfer == "apic"
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.9, 0.9], velocity=lambda x: [1.0 - 3.0 * linear * x[1], 2.0],
                         transfer=transfer)
    if linear:
        table = solver.particles.table()
        table[:, solver.particles.layout.columns("affine")] = [0.0, -3.0, 0.0, 0.0]
        solver.particles.overwrite(table)
    row = audit_of(solver).values(ParticleFields(solver.particles))
    assert abs(row["null_space_noise"]) < 1e-13


@pytest.mark.parametrize(("transfer", "kept"), [("pic", 0.0), ("apic", 0.0), ("flip", 0.9), ("aflip", 0.9)])
def test_motion_that_no_node_sees(make_solver, transfer, kept):
    """Particles of a cell against each other: APIC forgets it in a step, FLIP keeps its share each step."""
    checkers = lambda x: [0.5 * (-1.0) ** np.floor(x[0] / 0.05 + 0.01), 0.0]  # noqa: E731
    solver = make_solver(2, 0.1, [-2.0, -0.2], [2.0, 0.2], velocity=checkers, transfer=transfer, flip_ratio=0.9,
                         law=ICE)
    audit = audit_of(solver)
    # The ends are seen: it takes three steps to cross ten cells
    inner = np.abs(solver.particles.positions()[:, 0]) < 1.0
    noise = [audit.values(ParticleFields(solver.particles))["null_space_noise"]]
    for n in range(1, 4):
        solver.step(1e-9)
        row = audit.values(ParticleFields(solver.particles))
        noise.append(row["null_space_noise"])
        speed = np.abs(solver.particles.column("velocity")[inner, 0])
        np.testing.assert_allclose(speed, 0.5 * kept**n, rtol=1e-9, atol=1e-9)
    assert noise[0] > 0.97 and (noise[-1] > 0.97 if kept else noise[-1] < 0.3)  # what the ends gave is seen


@pytest.mark.parametrize(("transfer", "cfl"), [
    ("apic", 0.4), ("flip", 0.4), ("flip", None),
    pytest.param("apic", None, marks=pytest.mark.xfail(strict=True, reason="2.1 % comes and goes with C = 0.75"))])
def test_energies_close(make_solver, transfer, cfl):
    """A block swings on a wall under its weight: what the scheme itself takes is small, and it never gives."""
    solver = make_solver(2, 0.05, [0.0, -0.8], [0.4, -0.4], velocity=lambda x: [0.0, -3.0 * (x[1] + 0.8)],
                         gravity=9.81, sides=[["open", "open"], ["stick", "open"]], reach=0.8, transfer=transfer,
                         flip_ratio=0.99, cfl=cfl)
    audit = audit_of(solver)
    start = audit.values(ParticleFields(solver.particles))
    rows = []
    for _ in range(120):
        solver.step(0.5 * solver.stable_dt()[0])
        rows.append(audit.values(ParticleFields(solver.particles)))
    taken = np.array([row["energy_remainder"] for row in rows]) / start["kinetic_energy"]
    # v is half a step behind x: force times dt v / 2, a share omega dt / 4 = 1 % of what swings, comes and goes
    assert taken.min() > -0.016 and taken[-1] < 0.1
    elastic = np.array([row["elastic_energy"] for row in rows])
    assert elastic.max() > 0.8 * start["kinetic_energy"] and abs(rows[-1]["contact_work"]) < 1e-12


def test_energy_that_leaves_the_domain_is_counted(make_solver):
    """Half of a block that flies through an open side; its weight gives it what it loses in height."""
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.8, 0.4], velocity=lambda x: np.array([6.0, 0.0]), gravity=9.81,
                         reach=1.0)
    audit = audit_of(solver)
    for _ in range(600):
        solver.step(1e-4)
    with runtime.precision("f64"):
        solver.sort()
    row = audit.values(ParticleFields(solver.particles))
    assert 0 < row["removed_particles"] < 128
    # Free fall in symplectic Euler gains m g^2 dt t / 2 less than it falls
    lag = 0.5 * 300.0 * 0.32 * 9.81**2 * 1e-4 * 0.06
    assert abs(row["energy_remainder"]) < 2.0 * lag < 1e-3 * row["removed_energy"]


def test_emptied_cells():
    cells = np.array([[0.5, 0.5], [1.2, 0.1], [3.9, 0.9], [6.5, 0.5], [0.1, 2.5], [0.9, 2.2]])
    occupied, emptied, parted = occupied_and_emptied(cells)
    assert parted.tolist() == [True, True, True, False, True, True]
    assert (occupied, emptied) == (5, 2)  # (2, 0) between (1, 0) and (3, 0); (0, 1); two cells in a row do not
    assert occupied_and_emptied(np.zeros((0, 3)))[:2] == (0, 0)


@pytest.mark.parametrize("dim", [2, 3])
def test_gravity_along_a_periodic_axis_works_however_often_the_snow_goes_round(dim):
    """A block that falls freely along x, five times around: its energy is the work m g s of the weight, and the scheme
    took nothing. Part of the block leaves through the open top meanwhile, and is booked as removed."""
    dx = 0.1
    length, g = (1.6 if dim == 2 else 0.8), 40.0
    lower, upper = np.zeros(dim), np.full(dim, length)
    x, volumes = lattice([0.2] + [0.2] * (dim - 1), [0.5] + [0.5] * (dim - 1), dx)
    velocities = np.zeros_like(x)
    velocities[:, 0] = 1.0
    sides = [["periodic", "periodic"]] + [["open", "open"]] * (dim - 1)
    solver = MpmSolver(Population(x, volumes, 0, velocities), [ICE], dx=dx, precision="f64", origin=lower, lower=lower,
                       upper=upper, gravity=np.eye(dim)[0] * g, sides=sides)
    audit, start = audit_of(solver), solver.particles.mass
    while solver.time < 0.6:
        solver.step(solver.stable_dt()[0])
    gone = solver.particles.positions()[:, -1] > 0.4
    solver.remove(gone)
    row = audit.values(ParticleFields(solver.particles))
    way = solver.time + 0.5 * g * solver.time**2
    assert way > 4.0 * length
    work = start * g * way
    assert abs(row["energy_remainder"]) < 0.03 * work  # of the first order in the step: g dt of a speed
    assert row["potential_energy"] == pytest.approx(-work, rel=0.01)
    assert row["removed_energy"] == pytest.approx(row["kinetic_energy"] * row["removed_mass"] / row["mass"], rel=1e-6)
    assert row["taken_mass"] == row["removed_mass"] > 0.2 * start
    assert "front" not in row and "front_distance" not in row


def test_front_is_not_that_of_a_few_grains(make_solver):
    """Snow that lets go behind the first centre has no front yet; a grain or two never have."""
    solver = make_solver(2, 0.1, [0.0, 0.0], [4.0, 0.4])
    fields = ParticleFields(solver.particles)
    start = np.empty_like(fields["position"])
    start[fields["id"]] = fields["position"]

    def front(moved, way):
        """Front, from either place, where `moved` of the particles were that much further back at the start."""
        places = start.copy()
        places[moved, 0] -= way
        row = Audit(solver, fields, np.array([1.0]), places).values(fields)
        return [row["front"], row["front_distance"]]

    assert front(start[:, 0] > 9.0, 1.0) == [0.0, 0.0]  # nothing
    assert front(np.arange(len(start)) < 2, 1.0) == [0.0, 0.0]  # 2 of 640 particles
    behind = front(start[:, 0] < 0.5, 0.5)
    assert behind[0] == 0.0 and behind[1] == pytest.approx(0.95, abs=0.1)
    assert front(start[:, 0] > 3.0, 1.0)[0] == pytest.approx(2.0, abs=0.1)


AUDITED = """
import hashlib, snowmpm
scene = snowmpm.load_scene("column_collapse_2d", {"solver.dx": 0.0008, "bodies.0.velocity": [1.3, 0.7]})
row = snowmpm.Simulation(scene).audit()
assert row["particles"] > 200_000 and row["kinetic_energy"] > 0.0
print(hashlib.sha256(repr({name: value for name, value in row.items() if name != "dt"}).encode()).hexdigest())
"""


@pytest.mark.slow
def test_its_digits_do_not_hang_on_the_threads_of_numpy():
    """OpenBLAS shares sums of more than 10 000 products among threads, and a vector times a matrix of half a million
    numbers; each thread then rounds its own part."""
    found = {subprocess.run([sys.executable, "-c", AUDITED], check=True, capture_output=True, text=True,
                            env={**os.environ, "OPENBLAS_NUM_THREADS": threads}).stdout for threads in ("1", "2")}
    assert len(found) == 1
