"""An initial state in balance, by steps at rest in place of damped steps in time.

It is for explicit MPM on the same grid, with its splines, gradient and lines of contact, so that the nodes of its first
step find forces that cancel. A solution holds on the nodes that moved with it; explicit MPM starts from nodes in their
places, where forces are off by the displacement over a cell. Each round solves again from there, until what is left is
small over the weight:

    |T^T R| <= e |T^T sum_p m g w|

Elasticity forgets the way to the balance; material that yields does not, and takes the straight one.
"""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.implicit.balance import Balance
from snowmpm.implicit.march import Grid, March, Rules
from snowmpm.implicit.matter import Matter
from snowmpm.implicit.surfaces import surfaces_of
from snowmpm.particles.coordinates import Frame
from snowmpm.particles.material_table import MaterialTable

ROUNDS = 8

SHARE = 0.1
"""Of the tolerance of damped steps: forces that are off by it move nothing that these would see."""

HELD = ("open", "slip", "symmetric", "stick")
"""Sides that a balance can be found with."""


@dataclass(frozen=True)
class Settled:
    """population: particles in balance; unbalanced: |R| over the weight; rounds: of them; iterations: of Newton."""

    population: object
    unbalanced: float
    rounds: int
    iterations: int


def settle(population, laws, chosen, *, tolerance, dx, origin, lower, upper, gravity, terrain=None,
           terrain_contact="stick", sides=None, obstacles=(), **others):
    """`Settled` of a `Population` for explicit MPM with the choices of a scene's solver table; None where no balance is
    found, or the surfaces are not only such that hold.

    The rest as `mpm.solver.MpmSolver` takes it.
    """
    dim = len(origin)
    sides = sides or [["open", "open"]] * dim
    if len(obstacles) or not np.any(gravity) or population.field.any() or any(
            name not in HELD for ends in sides for name in ends) or (
            terrain is not None and terrain_contact != "stick"):
        return None
    frame = Frame(dim, "f64", origin, dx, lower, upper)
    materials = MaterialTable(laws, "f64")
    surfaces = surfaces_of(frame, terrain, terrain_contact, sides)
    # All nodes of explicit MPM are free, faint ones too
    march = March(Grid(dx, frame.origin, chosen.kernel, chosen.gradient, surfaces, extended=False),
                  Rules("quasi_static", tolerance=1e-3 * tolerance, iterations=15), materials)
    matter = Matter.of_population(population, materials, frame.origin, dx)
    matter.velocity[:] = 0.0
    body = np.broadcast_to(np.asarray(gravity, float), matter.velocity.shape)
    iterations, left = 0, unbalanced(march, matter, body)
    for done in range(ROUNDS + 1):
        if left <= SHARE * tolerance:
            return Settled(_as_population(population, matter, frame), left, done, iterations)
        if done == ROUNDS:
            return None
        try:
            passed = march.to_balance(matter, body, 1.0)
        except SimulationError:
            return None
        iterations += passed.iterations
        left = unbalanced(march, matter, body)
    return None


def unbalanced(march, matter, body):
    """|T^T R| over |T^T sum_p m b w| of particles on nodes in their places. body (n, dim): b [m/s2]."""
    mesh, held = march.mesh(matter)
    balance = Balance(mesh, held, matter, march.materials, body, march.grid.dx, 1.0)
    trial = balance.at(np.zeros(held.T.shape[1]))
    return float(np.linalg.norm(trial.free) / np.linalg.norm(held.reduced(balance.external)))


def _as_population(population, matter, frame):
    return replace(population, positions=frame.origin + frame.dx * matter.cells, velocities=np.zeros_like(
        matter.velocity), elastic=matter.h, stress=matter.tau, volume_ratio=matter.ratio,
        state=matter.state, affine=np.zeros((len(matter.h), frame.dim**2)))
