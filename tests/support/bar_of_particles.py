"""The bar of `drawn_bar` by SPH: as long and of the same material, endless across, between grips that keep their speed.

In its middle two rows of particles are 2 % weaker, since no single row can open. After each step the grips get back
what forces took of their speed in it, before the next takes as much again: their mean speed is what they are asked for,
and what they were given is the force.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.methods import METHODS
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sph
from snowmpm.sph.solver import SphSolver
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.drawn_bar import BAR, LENGTH, PULL

GRIP, WIDE, SAMPLES = 4, 8, 200
MATERIAL = BAR.model_copy(update={"fracture_energy": 0.25})
SECONDS = {20: 0.6, 40: 0.4}
"""That a test takes, by rows of particles."""


@dataclass(frozen=True)
class Parted:
    """opened: of the grips [m]; force: over the section [Pa]; damage (particles,); row: of the particles, from the
    middle, in spacings; work of the grips, and energy of the cohesion that was lost, both over the fracture energy of
    the section."""

    opened: np.ndarray
    force: np.ndarray
    damage: np.ndarray
    row: np.ndarray
    work: float
    lost: float


@cache
def draw(rows):
    """`Parted` bar of so many rows of particles."""
    dx, seconds = LENGTH / rows, SECONDS[rows]
    law = MATERIAL.on_grid(dx, METHODS["sph"].capabilities.rows_of_jump)
    x, volumes = lattice([-LENGTH / 2 - GRIP * dx, 0.0], [LENGTH / 2 + GRIP * dx, WIDE * dx], dx, 1)
    grips, weak = np.flatnonzero(np.abs(x[:, 0]) > LENGTH / 2), np.abs(x[:, 0]) < dx
    material = np.where(np.abs(x[:, 0]) > LENGTH / 4, 2, np.where(weak, 1, 0))
    material[grips] = 3
    laws = [law, *(law.model_copy(update={"strength": strength * law.strength,
                                          "fracture_energy": energy * law.fracture_energy})
                   for strength, energy in ((0.98, 1.0), (1.5, 4.0), (1e6, 1e12)))]
    rate = (PULL * law.complete_opening + law.strength / law.youngs_modulus * LENGTH) / LENGTH / seconds
    velocity = np.stack([rate * np.clip(x[:, 0], -LENGTH / 2, LENGTH / 2), 0.0 * x[:, 0]], axis=1)
    lower, upper = np.array([-LENGTH, 0.0]), np.array([LENGTH, WIDE * dx])
    solver = SphSolver(Population(x, volumes, material, velocity), laws, dx=dx, precision="f64", origin=lower,
                       lower=lower, upper=upper, gravity=np.zeros(2), scheme=Sph(),
                       sides=[["open", "open"], ["periodic", "periodic"]])
    states, outward = ParticleStates(solver), np.sign(x[grips, 0])
    wanted = velocity[grips]
    given, opened, force, then = wanted, [0.0], [0.0], 0.0
    for time in np.linspace(0.0, seconds, SAMPLES + 1)[1:]:
        impulse = 0.0
        while solver.time < time - 1e-12:
            solver.step(min(solver.stable_dt()[0], time - solver.time))
            gained = states.column("velocity")[grips] - given
            impulse -= 0.5 * (states.mass[grips] * gained[:, 0] * outward).sum() / (WIDE * dx)
            given = wanted - gained
            states.set(grips, velocity=given)
        opened.append(rate * LENGTH * 0.5 * (solver.time + then))
        force.append(impulse / (solver.time - then))
        then = solver.time
    opened, force, damage = np.array(opened), np.array(force), states.column("state")[:, 0]
    lost = (2.0 * damage - damage**2).sum() * dx / law.length / WIDE
    return Parted(opened, force, damage, np.round(x[:, 0] / dx, 2),
                  np.trapezoid(force, opened) / law.fracture_energy, lost)
