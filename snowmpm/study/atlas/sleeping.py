"""Entry: snow that starts so slowly that it is taken for snow at rest (`mpm.sleep`)."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, lattice

G, DX, HEIGHT, PULL, DURATION = 9.81, 0.1, 0.3, 0.02, 0.5
"""Gravity [m/s2], grid spacing and thickness of the slab [m], its acceleration over G, time [s]."""
LAW = Elastic(density=300.0, youngs_modulus=3e6, poisson_ratio=0.3)
LATE = 0.5
"""Limit of the entry."""


def lost_speed(tolerance):
    """Error of the speed of a slab on smooth ground that begins to slide, with solver.sleeping = tolerance."""
    x, volumes = lattice([0.0, 0.0], [8 * DX, HEIGHT], DX)
    K, shear = LAW.bulk_modulus, LAW.shear_modulus
    upright = -LAW.density * G * (HEIGHT - x[:, 1]) / (K + 4.0 / 3.0 * shear)
    aside = (K - 2.0 / 3.0 * shear) * upright
    stress = np.stack([aside, (K + 4.0 / 3.0 * shear) * upright, aside, 0.0 * upright], axis=1)
    elastic = np.stack([0.0 * upright, np.expm1(2.0 * upright), 0.0 * upright, 0.0 * upright], axis=1)
    solver = APIC.solver(Population(x, volumes, 0, stress=stress, elastic=elastic), [LAW], dx=DX, origin=np.zeros(2),
                         lower=np.zeros(2), upper=np.array([8 * DX, 2 * HEIGHT]), gravity=np.array([PULL * G, -G]),
                         sides=[["periodic", "periodic"], ["slip", "open"]], sleeping=tolerance)
    while solver.time < DURATION:
        solver.step(solver.stable_dt()[0])
    return ParticleStates(solver).column("velocity")[:, 0].mean() / (PULL * G * solver.time) - 1.0


ENTRIES = (
    Entry(
        name="slow_start", title="Snow that starts slowly is put to sleep",
        scene="A slab on smooth ground, pulled along it by 2 % of gravity",
        seen="Its speed stays below what counts as calm for so long that it falls asleep, and never slides",
        cure="a smaller solver.sleeping, or 0: snow must be pulled by more than this share of gravity",
        parameter="solver.sleeping", unit="", values=(0.002, 0.005, 0.01, 0.02, 0.04, 0.1),
        settings={"pulled by 0.02 g": {}},
        symptom="error of the speed", limit=LATE, measure=lost_speed, shown="pulled by 0.02 g"),
)
