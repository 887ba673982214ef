"""The free bar by PySPH's scheme for elastic solids (Gray, Monaghan and Swift 2001) in plane strain, one thread.

With the scheme's own artificial viscosity (alpha = 1), stress and XSPH, and with a tenth of the viscosity.
"""

import sys
import tempfile

import numpy as np
from free_bar import CELLS, DENSITY, LENGTH, PERIOD, SPEED, YOUNGS_MODULUS, Clock, error, lattice, start, tell
from pysph.base.kernels import CubicSpline
from pysph.solver.application import Application
from pysph.sph.solid_mech.basic import ElasticSolidsScheme, get_particle_array_elastic_dynamics

SMOOTHING = 1.3
"""h over the spacing of the particles, as in PySPH's examples."""


class Bar(Application):
    """spacing [m]; alpha: artificial viscosity."""

    def __init__(self, spacing, alpha, **options):
        self.spacing, self.alpha = spacing, alpha
        super().__init__(**options)

    def create_particles(self):
        x = lattice(self.spacing, 2)
        h = SMOOTHING * self.spacing
        self.bar = get_particle_array_elastic_dynamics(
            x=x[:, 0], y=x[:, 1], m=DENSITY * self.spacing**2, h=h, rho=DENSITY, name="bar", u=start(x[:, 0]),
            constants={"wdeltap": CubicSpline(dim=2).kernel(rij=self.spacing, h=h), "n": 4, "rho_ref": DENSITY,
                       "E": YOUNGS_MODULUS, "nu": 0.0})
        self.x0 = x[:, 0]
        return [self.bar]

    def create_scheme(self):
        scheme = ElasticSolidsScheme(elastic_solids=["bar"], solids=[], dim=2, alpha=self.alpha, beta=self.alpha)
        self.steps = int(np.ceil(PERIOD * SPEED / (0.25 * SMOOTHING * self.spacing)))
        scheme.configure_solver(dt=PERIOD / self.steps, tf=PERIOD, pfreq=10**9)
        return scheme


def solve(cells, alpha):
    with tempfile.TemporaryDirectory() as folder:
        bar = Bar(0.5 * LENGTH / cells, alpha, fname="bar", output_dir=folder)
        bar.setup(["--quiet", "--disable-output", "-d", folder])
        clock, step = Clock(), bar.solver.integrator.step
        bar.solver.integrator.step = lambda *arguments: clock.step(step, *arguments)
        bar.solve()
        tell("PySPH", f"alpha {alpha:g}", 2, cells, len(bar.x0), len(clock.steps), clock.seconds,
             error(bar.x0, np.asarray(bar.bar.u)))


for alpha in (1.0, 0.1):
    for cells in CELLS[: int(sys.argv[1])]:
        solve(cells, alpha)
