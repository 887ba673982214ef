"""An elastic block in PySPH, by its own scheme for elastic solids: prints seconds per step and particles.

    PYTHON_WITH_PYSPH pysph_block.py DIMENSION PARTICLES STEPS
"""

import json
import sys
import time

import numpy as np
from pysph.solver.application import Application
from pysph.sph.solid_mech.basic import ElasticSolidsScheme, get_particle_array_elastic_dynamics

DX, DENSITY, E, NU = 0.01, 1500.0, 1e6, 0.3
SPEED = float(np.sqrt(E * (1 - NU) / ((1 + NU) * (1 - 2 * NU)) / DENSITY))
WARM = 5


class Block(Application):
    """A block at rest with a small random velocity."""

    dim, count, steps = 2, 10000, 50
    began = ended = None

    def create_particles(self):
        n = round(self.count ** (1.0 / self.dim))
        axis = DX * (np.arange(n) + 0.5)
        x = np.stack(np.meshgrid(*[axis] * self.dim, indexing="ij"), axis=-1).reshape(-1, self.dim)
        velocity = np.random.default_rng(1).normal(0.0, 1e-3, x.shape)
        columns = {name: x[:, k] for k, name in enumerate("xyz"[: self.dim])}
        columns |= {name: velocity[:, k] for k, name in enumerate("uvw"[: self.dim])}
        solid = get_particle_array_elastic_dynamics(
            name="solid", m=np.full(len(x), DENSITY * DX**self.dim), rho=np.full(len(x), DENSITY),
            h=np.full(len(x), 1.3 * DX), constants={"E": E, "nu": NU, "rho_ref": DENSITY}, **columns)
        return [solid]

    def create_scheme(self):
        scheme = ElasticSolidsScheme(elastic_solids=["solid"], solids=[], dim=self.dim)
        dt = 0.2 * DX / SPEED
        scheme.configure_solver(dt=dt, tf=self.steps * dt, pfreq=10**9)
        return scheme

    def post_step(self, solver):
        if solver.count == WARM:
            self.began = time.perf_counter()
        self.ended = time.perf_counter()
        self.last = solver.count


def main(dim, count, steps):
    """Run it without output files."""
    Block.dim, Block.count, Block.steps = dim, count, steps
    app = Block(output_dir=sys.argv[4] if len(sys.argv) > 4 else None)
    app.run(["--max-steps", str(steps)])
    n = len(app.particles[0].x)
    print(json.dumps({"particles": n, "seconds_per_step": (app.ended - app.began) / (app.last - WARM)}))


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:4]))
