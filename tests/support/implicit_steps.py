"""Solvers of implicit MPM outside any scene."""

import numpy as np

from snowmpm.implicit.solver import ImplicitSolver
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Solver

OPEN = [["open", "open"], ["open", "open"]]


def implicit(positions, volumes, laws, dx, *, upper, gravity=None, sides=None, material=0, velocities=None, solver=None,
             surfaces=None, adapters=(), **options):
    """`ImplicitSolver` of particles in the box from 0 to `upper` [m]. solver: keys of a scene's solver table; surfaces:
    terrain and obstacles, as `ImplicitSolver` takes them; adapters: of components; options: of its table implicit."""
    dim = positions.shape[1]
    chosen = Solver.model_validate({"method": "implicit", "dx": dx, "gradient": "shape", "implicit": options,
                                    **(solver or {})})
    population = Population(positions, volumes, material, velocities)
    return ImplicitSolver(population, laws if isinstance(laws, list) else [laws], chosen, chosen.implicit, dx=dx,
                          precision="f64", origin=np.zeros(dim), lower=np.zeros(dim), upper=np.asarray(upper, float),
                          gravity=np.zeros(dim) if gravity is None else np.asarray(gravity, float),
                          sides=sides or [["open", "open"]] * dim, adapters=adapters, **(surfaces or {}))
