"""Quasi-static relaxation of an initial state: damped steps under gravity until everything rests.

Each step keeps the share 1 - dt c / (10 dx) of the node velocities, which damps waves within tens of steps. Over a
window of steps the state counts as settled, to a tolerance e, when

    largest particle speed <= e sqrt(g D)               D the depth of the snow, one cell at least
    |J + W| <= e |W|                                    J impulse of ground, sides and obstacles, W that of the weight

The second one sees what the first does not: snow so strongly damped that it creeps without being carried.
"""

import math
from dataclasses import dataclass

import numpy as np

from snowmpm.stages import stage

WINDOW = 50
"""Steps over which both must hold."""

MOST_STEPS = 20_000

DAMPING = 0.1


@dataclass(frozen=True)
class Rest:
    """What relaxation came to. speed: largest over sqrt(g D) in the last window; imbalance: |J + W| / |W| of it."""

    settled: bool
    speed: float
    imbalance: float
    steps: int


def settle(solver, tolerance, depth):
    """Relax a `stepping.contract.Method` to rest, set its clock to zero; -> `Rest`. depth: D [m]."""
    scale = math.sqrt(max(float(np.linalg.norm(solver.gravity)) * depth, 1e-30))
    rest = Rest(False, math.inf, math.inf, 0)
    with stage("settling to rest", unit="steps") as now:
        while not rest.settled and rest.steps < MOST_STEPS:
            speed, imbalance = _window(solver)
            rest = Rest(speed <= tolerance * scale and imbalance <= tolerance, speed / scale, imbalance,
                        rest.steps + WINDOW)
            now.done = rest.steps
            now.detail = (f"speed {rest.speed / tolerance:.2g} and imbalance {rest.imbalance / tolerance:.2g} of what"
                          " is allowed")
    solver.damp(1.0)
    solver.restart_clock()
    return rest


def _window(solver):
    """Largest speed [m/s] and imbalance [-] of the next steps."""
    frame, particles = solver.frame, solver.particles
    speed, carried, weight = 0.0, np.zeros(frame.dim), np.zeros(frame.dim)
    before = solver.totals.impulse
    for _ in range(WINDOW):
        dt, _ = solver.stable_dt()
        left = solver.damp(1.0 - min(0.5, DAMPING * dt * particles.materials.wave_speed / frame.dx))
        solver.step(dt)
        after = solver.totals.impulse
        # Damping takes its share of weight and stress alike; the ground of MPM carries what is left
        carried += (after - before) / left
        before = after
        weight += dt * particles.mass * solver.gravity
        speed = max(speed, float(solver.extremes.speed))
    size = np.linalg.norm(weight)
    return speed, float(np.linalg.norm(carried + weight) / size) if size > 0.0 else 0.0
