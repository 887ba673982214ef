"""Whether a step is stable: bodies stirred a little, and what becomes of their motion."""

import math

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.materials import pack
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population

DX = 0.1
STIR = 1e-6
"""Strain of the stirring; velocities are this share of c. So small that places and geometry stay."""
GROWTH = 100.0
"""Kinetic energy over all energy at the start that no stable motion reaches: one at a share q of the critical frequency
exchanges it up to 1 / (1 - q^2) times, which reads as unstable from 0.995 on."""


def spread(per_axis, cells, dim, offset, dx=DX):
    """Regular particles of a cube of `cells` cells whose corner is `offset` cells off a node: positions, volumes."""
    axis = (np.arange(per_axis * cells) + 0.5) / per_axis + offset
    positions = np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    return dx * positions, np.full(len(positions), (dx / per_axis) ** dim)


def lone_grain(dim, offset, dx=DX):
    """One particle `offset` cells off a node along each axis: position, volume."""
    return np.full((1, dim), offset * dx), np.full(1, (0.5 * dx) ** dim)


def stirred(grains, law, *, dx=DX, drift=0.0, strain=None, state=None, reach=8.0, **options):
    """-> (solver, energy of the stirring [J]) of grains (positions, volumes) with random velocities and strains.

    drift: velocity of all along the first axis [m/s]; strain (dim,): Hencky strain that is there already, without any
    stirring of it; state: of the law.
    """
    positions, volumes = grains
    (n, dim), rng = positions.shape, np.random.default_rng(7)
    K, G = law.bulk_modulus, law.shear_modulus
    velocities = STIR * law.wave_speed() * rng.standard_normal((n, dim))
    hencky = np.zeros((n, 3, 3))
    if strain is None:
        shaken = STIR * rng.standard_normal((n, dim, dim))
        hencky[:, :dim, :dim] = 0.5 * (shaken + shaken.swapaxes(1, 2)) + STIR * np.eye(dim)
    else:
        hencky[:, range(dim), range(dim)] = strain
    trace = np.trace(hencky, axis1=1, axis2=2)
    stress = (K - 2.0 / 3.0 * G) * trace[:, None, None] * np.eye(3) + 2.0 * G * hencky
    energy = 0.5 * float(volumes @ (law.density * (velocities**2).sum(axis=1)))
    energy += 0.5 * float(volumes @ (stress * hencky).sum(axis=(1, 2))) if strain is None else 0.0
    # Principal axes are not needed: exp(2 e) - I is 2 e where it is not diagonal
    elastic = np.where(np.eye(3, dtype=bool), np.expm1(2.0 * hencky), 2.0 * hencky)
    velocities[:, 0] += drift
    population = Population(positions, volumes, 0, velocities,
                            elastic=pack(elastic, dim), stress=pack(stress, dim))
    box = {"origin": np.full(dim, -reach * dx), "lower": np.full(dim, -reach * dx), "upper": np.full(dim, reach * dx)}
    solver = MpmSolver(population, [law], **{"dx": dx, "precision": "f64", "gravity": np.zeros(dim), **box, **options})
    if state is not None:
        table = solver.particles.table()
        table[:, solver.particles.layout.columns("state")] = state
        solver.particles.overwrite(table)
    return solver, energy


def motion(solver, drift=0.0):
    """Kinetic energy [J] about the drift, that of the velocity gradients within a quarter cell included."""
    velocities = solver.particles.column("velocity")
    velocities[:, 0] -= drift
    square = (velocities**2).sum(axis=1) + 0.25 * solver.dx**2 * (solver.particles.column("affine") ** 2).sum(axis=1)
    return 0.5 * float(solver.particles.masses() @ square)


def growth(solver, energy, dt, steps, drift=0.0, every=25):
    """Largest motion over the energy of its stirring within so many steps of dt [s]; infinite when a step fails. Ends
    where it is beyond GROWTH."""
    largest = 0.0
    for k in range(steps):
        try:
            solver.step(dt)
        except SimulationError:
            return math.inf
        if k % every == every - 1:
            ratio = motion(solver, drift) / energy
            largest = max(largest, ratio if math.isfinite(ratio) else math.inf)
            if largest >= GROWTH:
                break
    return largest


def blows_up(solver, energy, dt, steps, drift=0.0, every=25):
    """Whether the motion grows out of the energy of its stirring within so many steps of dt [s]."""
    return growth(solver, energy, dt, steps, drift, every) >= GROWTH
