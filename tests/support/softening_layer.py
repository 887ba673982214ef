"""A layer of clay between rigid grips that shear it until it slips on one band: what softening takes on a grid.

Plane strain, periodic along the slip, 1.2 m high; phi = 0. A strip in the middle is weaker by a tenth. Slip u
on a band as thick as the length l takes per area

    w(u) = c_r u + (c_p - c_r) sqrt(3) l kappa_c (1 - exp(-u / (sqrt(3) l kappa_c)))

by kappa = u / (sqrt(3) l). The second part is the work of softening.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.materials import Elastic, SofteningCone
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, lattice

HEIGHT, STRIP, GRIP, CELLS = 1.2, 0.1, 3, 8  # m, m, cells, cells of a period
LENGTH, WEAK = 0.2, 0.9  # m, of the strength
CLAY = SofteningCone(density=1e3, youngs_modulus=2.6e6, poisson_ratio=0.3, friction_angle=0.0,
                     residual_friction_angle=0.0, cohesion=1e4, residual_cohesion=1e3, softening_strain=0.1,
                     cone="plane_strain")  # fmt: skip
SCALE = np.sqrt(3.0) * LENGTH * CLAY.softening_strain
"""Slip [m] after which 1/e of what softening takes is left."""
WAY, SECONDS = 3.0 * SCALE, 2.0
"""Of the grips against each other [m, s]."""


@dataclass(frozen=True)
class Sheared:
    """A layer at the end. softened: work of softening over that of a band as thick as LENGTH; band: thickness [m] over
    which strength is lost, integral of plastic strain over its largest value; slip [m]."""

    softened: float
    band: float
    slip: float


def layer(dx, length=LENGTH, scheme=APIC, cells=None):
    """Solver of a layer on cells of dx [m], and which particles are grips (n,); length: nonlocal_length [m] of the
    clay, or None; cells: over its height, those of HEIGHT without."""
    half = 0.5 * (cells * dx if cells else HEIGHT)
    x, volumes = lattice([0.0, -half - GRIP * dx], [CELLS * dx, half + GRIP * dx], dx)
    grips, weak = np.abs(x[:, 1]) > half, np.abs(x[:, 1]) < 0.5 * STRIP + 1e-9
    clay = CLAY.model_copy(update={"nonlocal_length": length})
    weaker = clay.model_copy(update={name: WEAK * getattr(CLAY, name) for name in ("cohesion", "residual_cohesion")})
    heavy = Elastic(density=1e12, youngs_modulus=CLAY.youngs_modulus, poisson_ratio=0.3)
    shear = WAY / SECONDS / HEIGHT
    velocity = np.stack([shear * np.clip(x[:, 1], -half, half), 0.0 * x[:, 0]], axis=1)
    reach = half + (GRIP + 5) * dx
    solver = scheme.solver(
        Population(x, volumes, np.where(grips, 2, weak), velocity), [clay, weaker, heavy], dx=dx, gravity=np.zeros(2),
        origin=[0.0, -dx * np.ceil(reach / dx)], lower=[0.0, -reach], upper=[CELLS * dx, reach],
        sides=[["periodic", "periodic"], ["open", "open"]])
    ParticleStates(solver).set(affine=np.where(grips[:, None], 0.0, [[0.0, shear, 0.0, 0.0]]))
    return solver, grips


@cache
def sheared(dx, length=LENGTH, scheme=APIC):
    """`Sheared` layer on cells of dx [m]; length: nonlocal_length [m] of the clay, or None."""
    solver, grips = layer(dx, length, scheme)
    while solver.time < SECONDS - 1e-12:
        solver.step(min(solver.stable_dt()[0], SECONDS - solver.time))
    states, width = ParticleStates(solver), CELLS * dx
    clay, volume = ~grips, (0.5 * dx) ** 2
    stress, strain = states.column("stress")[clay, 3], states.column("state")[clay, 0]
    slip = WAY - HEIGHT * stress.mean() / CLAY.shear_modulus
    left = solver.plastic_work / width - WEAK * CLAY.residual_cohesion * slip
    whole = WEAK * (CLAY.cohesion - CLAY.residual_cohesion) * SCALE * (1.0 - np.exp(-slip / SCALE))
    return Sheared(left / whole, volume * strain.sum() / (width * strain.max()), slip)
