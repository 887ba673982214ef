"""A layer of clay between rigid walls that shear it until it slips on one band: what softening takes on a grid.

Plane strain, periodic along the slip; phi = 0. A strip is weaker by a tenth. Slip u on a band as thick as the length l
takes per area

    w(u) = c_r u + (c_p - c_r) sqrt(3) l kappa_c (1 - exp(-u / (sqrt(3) l kappa_c)))

by kappa = u / (sqrt(3) l). The second part is the work of softening.

The walls are heavy particles in MPM; in SPH, where particles must not differ in density, they are obstacles that move.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.components.nonlocal_averaging.average import FadingAverage
from snowmpm.materials import DruckerPrager, Elastic, SofteningCone
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import APIC, Scheme, lattice

STRIP, GRIP, ACROSS = 0.1, 3, 8  # m, cells, cells of a period
LENGTH, WEAK = 0.2, 0.9  # m, of the strength
CLAY = SofteningCone(density=1e3, youngs_modulus=2.6e6, poisson_ratio=0.3, friction_angle=0.0,
                     residual_friction_angle=0.0, cohesion=1e4, residual_cohesion=1e3, softening_strain=0.1,
                     cone="plane_strain")  # fmt: skip
SCALE = np.sqrt(3.0) * LENGTH * CLAY.softening_strain
"""Slip [m] after which 1/e of what softening takes is left."""
WAY = 3.0 * SCALE
"""Of the walls against each other [m]."""
HEAVY = 1e12
"""Density [kg/m3] and strength [Pa] of walls of particles."""


@dataclass(frozen=True)
class Sheared:
    """A layer at the end. softened: work of softening over that of a band as thick as LENGTH; band: thickness [m] over
    which strength is lost, integral of plastic strain over its largest value; slip [m]."""

    softened: float
    band: float
    slip: float


@dataclass(frozen=True)
class Layer:
    """A layer to be sheared.

    dx: cells, of SPH the spacing [m]; length: nonlocal_length [m] of the clay, or None; law: of the clay; height [m];
    middle: of the weak strip, over the middle of the layer [m]; walls: "elastic", or "clay", which is as strong as they
    are heavy and has a share in the average; seconds: in which the walls go their way.
    """

    dx: float
    length: float | None = LENGTH
    scheme: Scheme = APIC
    law: DruckerPrager = CLAY
    height: float = 1.2
    middle: float = 0.0
    walls: str = "elastic"
    seconds: float = 2.0

    @property
    def width(self):
        return ACROSS * self.dx

    def solver(self):
        """Its solver, and which particles are clay (n,)."""
        half, sph = 0.5 * self.height, self.scheme.method == "sph"
        grip = 0.0 if sph else self.dx * max(GRIP, np.ceil(1.5 * LENGTH / self.dx) * (self.walls == "clay"))
        x, volumes = lattice([0.0, -half - grip], [self.width, half + grip], self.dx, 1 if sph else 2)
        clay, weak = np.abs(x[:, 1]) < half, np.abs(x[:, 1] - self.middle) < 0.5 * STRIP + 1e-9
        law = self.law.model_copy(update={"nonlocal_length": self.length})
        weaker, strong = (law.model_copy(update=changes) for changes in (
            {name: WEAK * law[name] for name in ("cohesion", "residual_cohesion")},
            {"density": HEAVY, "cohesion": HEAVY, "residual_cohesion": HEAVY}))
        wall = strong if self.walls == "clay" else Elastic(
            density=HEAVY, youngs_modulus=law.youngs_modulus, poisson_ratio=law.poisson_ratio)
        laws = [law, weaker, wall]
        rate = WAY / self.seconds / self.height
        velocity = np.stack([rate * np.clip(x[:, 1], -half, half), 0.0 * x[:, 0]], axis=1)
        reach = half + grip + 5 * self.dx
        solver = self.scheme.solver(
            Population(x, volumes, np.where(clay, weak, 2), velocity), laws, dx=self.dx,
            gravity=np.zeros(2), origin=[0.0, -self.dx * np.ceil(reach / self.dx)], lower=[0.0, -reach],
            upper=[self.width, reach], sides=[["periodic", "periodic"], ["open", "open"]],
            obstacles=self._plates(rate * half) if sph else (),
            adapters=[FadingAverage(laws)] if self.length else ())
        if not sph:
            ParticleStates(solver).set(affine=np.where(clay[:, None], [[0.0, rate, 0.0, 0.0]], 0.0))
        return solver, clay

    def _plates(self, speed):
        """Walls of SPH, which go at this speed [m/s] against each other."""
        return [block([0.5 * self.width, -side * 0.5 * self.height], [0.0, side], 2.0 * self.width, "stick",
                      velocity=[-side * speed, 0.0], name=name) for side, name in ((1.0, "below"), (-1.0, "above"))]


@cache
def sheared(layer):
    """`Sheared` of a `Layer`."""
    solver, clay = layer.solver()
    while solver.time < layer.seconds - 1e-12:
        solver.step(min(solver.stable_dt()[0], layer.seconds - solver.time))
    states, law = ParticleStates(solver), layer.law
    stress, strain = states.column("stress")[clay, 3], states.column("state")[clay, 0]
    slip = WAY - layer.height * stress.mean() / law.shear_modulus
    left = solver.plastic_work / layer.width - WEAK * law.residual_cohesion * slip
    whole = WEAK * (law.cohesion - law.residual_cohesion) * SCALE * (1.0 - np.exp(-slip / SCALE))
    return Sheared(left / whole, layer.height * strain.mean() / strain.max(), slip)
