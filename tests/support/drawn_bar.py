"""A bar that grips draw apart, or press together before, until one row of its cells has cracked.

0.2 m long, three cells wide, E = 1 MPa, rho = 1000 kg/m3, f_t = 1 kPa; the row of cells in its middle is 2 % weaker.
The grips are too heavy to slow down. Waves cross the bar a hundred times in a test. Its force is what the grips lose in
momentum, so neither the stress nor the damage of a particle enters the work.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.materials import CohesiveCrack
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, lattice
from tests.support.one_a_cell import shared

LENGTH, GRIP, WIDE = 0.2, 3, 3  # m, cells
BAR = CohesiveCrack(density=1e3, youngs_modulus=1e6, poisson_ratio=0.0, strength=1e3, fracture_energy=0.5)
PULL, SECONDS, SAMPLES = 1.3, 1.2, 400
"""Opening at the end over that at which no cohesion is left, time it takes, and how often the force is read."""


@dataclass(frozen=True)
class Drawn:
    """opened: of the grips [m], since the force was last zero; force: over the section [Pa]; state: of the law at the
    end (particles, n); column: of the particles, in cells; law: of all but the weak row; pressed: largest pressure on
    the grips before [Pa]."""

    opened: np.ndarray
    force: np.ndarray
    state: np.ndarray
    column: np.ndarray
    law: CohesiveCrack
    pressed: float

    @property
    def work(self):
        """Of the grips since the force was last zero, over the fracture energy of the section."""
        return np.trapezoid(self.force, self.opened) / self.law.fracture_energy

    @property
    def stored(self):
        """Elastic energy of the bar at the end, over the same."""
        E = self.law.youngs_modulus
        return 0.5 * self.force[-10:].mean() ** 2 / E * LENGTH / self.law.fracture_energy


@cache
def draw(cells, f_bar="whole", scheme=APIC, per_axis=2, law=BAR, press=0.0, pull=PULL):
    """`Drawn` bar of so many cells. press: strain by which it is pressed together before, between walls without
    friction on both sides; pull: opening at the end over that at which a crack has no cohesion left."""
    dx = LENGTH / cells
    law = law.on_grid(dx)
    x, volumes = lattice([-LENGTH / 2 - GRIP * dx, 0.0], [LENGTH / 2 + GRIP * dx, WIDE * dx], dx, per_axis)
    grips, weak = np.abs(x[:, 0]) > LENGTH / 2, (x[:, 0] > 0.0) & (x[:, 0] < dx)
    material = np.where(grips, 3, np.where(np.abs(x[:, 0]) > LENGTH / 4, 2, np.where(weak, 1, 0)))
    alike = [law, law.model_copy(update={"strength": 0.98 * law.strength}),
             law.model_copy(update={"strength": 1.5 * law.strength, "fracture_energy": 4.0 * law.fracture_energy})]
    plain = law.model_copy(update={"bulk": None, "cracks": 1, "reset": False})
    heavy = plain.model_copy(update={"density": 1e12, "strength": 1e9, "fracture_energy": 1e12})
    end = pull * law.complete_opening + law.strength / law.youngs_modulus * LENGTH
    rate = (PULL * BAR.complete_opening + BAR.strength / BAR.youngs_modulus * LENGTH) / LENGTH / SECONDS
    upwards, reach = [-2.0 * LENGTH, 0.0 if press else -2.0 * LENGTH], 2.0 * LENGTH
    top = WIDE * dx if press else WIDE * dx + reach
    sides = [["open", "open"], ["slip", "slip"] if press else ["open", "open"]]
    solver = scheme.solver(Population(x, volumes, material, None), [*alike, heavy], dx=dx,
                           origin=dx * np.floor(np.array(upwards) / dx), lower=np.array(upwards),
                           upper=np.array([reach, top]), gravity=np.zeros(2), adapters=shared(f_bar), sides=sides)
    states = ParticleStates(solver)

    def moving(speed):
        along = speed * np.clip(x[:, 0], -LENGTH / 2, LENGTH / 2)
        states.set(velocity=np.stack([along, 0.0 * along], axis=1),
                   affine=np.where(grips[:, None], 0.0, [[speed, 0.0, 0.0, 0.0]]))

    def momentum():
        """Of a grip, mean of both, over the section."""
        along = states.column("velocity")[:, 0] * np.sign(x[:, 0])
        return 0.5 * (states.mass * along)[grips].sum() / (WIDE * dx)

    opened, force, at = [0.0], [0.0], 0.0
    for speed, way in ((-rate, press * LENGTH), (rate, press * LENGTH + end)):
        if not way:
            continue
        moving(speed)
        before, then, begin = momentum(), solver.time, solver.time
        seconds = way / (rate * LENGTH)
        for time in begin + np.linspace(0.0, seconds, max(20, round(SAMPLES * seconds / SECONDS)) + 1)[1:]:
            while solver.time < time - 1e-12:
                solver.step(min(solver.stable_dt()[0], time - solver.time))
            now = momentum()
            opened.append(at + speed * LENGTH * (0.5 * (solver.time + then) - begin))
            force.append((before - now) / (solver.time - then))
            before, then = now, solver.time
        at += speed * LENGTH * (solver.time - begin)
    opened, force = np.array(opened), np.array(force)
    pressed = -force.min()
    if press:
        drawn = 1 + np.flatnonzero(force[: np.argmax(force)] < 0.0)[-1]
        opened, force = opened[drawn:], force[drawn:]
    return Drawn(opened, force, states.column("state"), np.round(x[:, 0] / dx, 2), law, pressed)
