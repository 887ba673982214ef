"""An initial state in balance, by steps at rest in place of damped steps in time.

It is for explicit MPM on the same grid, with its splines, gradient and lines of contact, so that the nodes of its first
step find forces that cancel. A solution holds on the nodes that moved with it; explicit MPM starts from nodes in their
places, where forces are off by the displacement over a cell. Each round solves again from there, until what is left is
small over the weight:

    |T^T R| <= e |T^T sum_p m g w|

Elasticity forgets the way to the balance; material that yields does not, and takes the straight one.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.implicit.balance import Balance
from snowmpm.implicit.material_points import MaterialPoints
from snowmpm.implicit.step_solver import Grid, Rules, StepSolver
from snowmpm.implicit.surfaces import surfaces_of
from snowmpm.particles.material_table import MaterialTable
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.setting import Setting

ROUNDS = 8

SHARE = 0.02
"""Of the tolerance of damped steps: forces that are off by it move nothing that these would see."""

HELD = ("open", "slip", "symmetric", "stick")
"""Sides that a balance can be found with."""


@dataclass(frozen=True)
class Settled:
    """population: particles in balance; unbalanced: |R| over the weight; rounds: of them; iterations: of Newton."""

    population: Any
    unbalanced: float
    rounds: int
    iterations: int


def settle(population, laws, chosen, *, tolerance, adapters=lambda method: (), **setting):
    """`Settled` of a `Population` for explicit MPM with the choices of a scene's solver table; None where no balance is
    found, or the surfaces are not only such that hold.

    adapters: method -> those of the components at work; setting: fields of `Setting`.
    """
    given = replace(Setting(**setting), precision="f64", terrain_friction=0.0)
    if len(given.obstacles) or not np.any(given.gravity) or population.field.any() or any(
            name not in HELD for ends in given.walls for name in ends) or (
            given.terrain is not None and given.terrain_contact != "stick"):
        return None
    frame, dx, weight = given.frame(), given.dx, np.asarray(given.gravity, float)
    materials = MaterialTable(laws, "f64")
    surfaces = surfaces_of(frame, given)
    acting = Adapters(adapters("implicit"))
    rules = Rules("quasi_static", tolerance=1e-3 * tolerance, iterations=15)
    # All nodes of explicit MPM are free, faint ones too; where these have no balance, they follow
    for extended in (False, True):
        grid = Grid(dx, frame.origin, chosen.kernel, chosen.gradient, surfaces, extended)
        matter = MaterialPoints.of_population(population, materials, frame.origin, dx)
        matter.velocity[:] = 0.0
        matter.strain = next(iter(acting.strain), None)
        found = _balanced(StepSolver(grid, rules, materials), matter, weight, SHARE * tolerance)
        if found:
            return Settled(_as_population(population, matter, frame), *found)
    return None


def _balanced(step_solver, matter, gravity, enough):
    """What is left of the weight, rounds and iterations, once it is `enough`; None where it does not get there."""
    body = np.broadcast_to(gravity, matter.velocity.shape)
    iterations, left, done = 0, unbalanced(step_solver, matter, body), 0
    while left > enough:
        if done == ROUNDS:
            return None
        try:
            passed = step_solver.to_balance(matter, body, 1.0)
        except SimulationError:
            return None
        iterations, done = iterations + passed.iterations, done + 1
        left = unbalanced(step_solver, matter, body)
    return left, done, iterations


def unbalanced(step_solver, matter, body):
    """|T^T R| over |T^T sum_p m b w| of particles on nodes in their places. body (n, dim): b [m/s2]."""
    mesh, held = step_solver.mesh(matter)
    balance = Balance(mesh, held, matter, step_solver.materials, body, step_solver.grid.dx, 1.0)
    trial = balance.at(np.zeros(held.T.shape[1]))
    return float(np.linalg.norm(trial.free) / np.linalg.norm(held.reduced(balance.external)))


def _as_population(population, matter, frame):
    return replace(population, positions=frame.origin + frame.dx * matter.cells, velocities=np.zeros_like(
        matter.velocity), elastic=matter.h, stress=matter.tau, volume_ratio=matter.ratio,
        state=matter.state, affine=np.zeros((len(matter.h), frame.dim**2)))
