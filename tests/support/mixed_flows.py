"""Depth-averaged flows of grains and water with columns of their own, made by hand."""

import numpy as np

from snowmpm.components.flow_water.depth import wet_columns
from snowmpm.components.flow_water.two_phase import TwoPhaseWater
from snowmpm.depth.snapshot import depth_at_nodes
from snowmpm.depth.solver import DepthSolver
from snowmpm.materials import LAWS
from snowmpm.particles.population import Population
from snowmpm.water.drag import Anderson
from tests.support.depth_flows import OPEN, USUAL, G

WATER = 1000.0


def anderson(grains, terminal=1e-3, power=1.0):
    """Anderson's drag of grains of a density [kg/m3]."""
    return Anderson((grains - WATER) * G, terminal, power)


def mixed_flow(plan, volumes, ground, dx, *, grains, drag, porosity=0.5, consolidation=0.0, excess=0.0, drained=True,
               velocities=None, options=USUAL):
    """`DepthSolver` of columns at plan positions (n, 2): volumes (2, n) of grains and water; velocities (2, n, 2)."""
    n = len(plan)
    upright = np.zeros((2 * n, 1))
    moving = np.zeros((2 * n, 2)) if velocities is None else np.reshape(velocities, (2 * n, 2))
    population = Population(np.hstack([np.tile(plan, (2, 1)), upright]), np.concatenate(volumes),
                            np.repeat([0, 1], n), np.hstack([moving, upright]), starts=0.0)
    laws = [LAWS["elastic"](density=grains, youngs_modulus=1e6, poisson_ratio=0.3)] * 2
    water = TwoPhaseWater.of(np.array([porosity]), grains, drag, density=WATER, consolidation=consolidation,
                             excess=excess, layers=10, drained=lambda plan: np.full(len(plan), drained), gravity=G)
    return DepthSolver(population, laws, options, dx=dx, precision=options.precision,
                       lower=np.array([*ground.lower, -1e3]), upper=np.array([*ground.upper, 1e3]),
                       gravity=[0.0, 0.0, -G], cfl=options.cfl, terrain=ground, friction=ground.friction,
                       sides=[*ground.sides, OPEN], adapters=[wet_columns(water)])


def phase(solver, k):
    """Which columns are of grains (0) or of water (1)."""
    store = solver.particles
    return store.material.to_numpy()[: store.count] == k


def depths_of_phases(solver):
    """x (nx,) and depths of grains and water (2, nx) [m] at the nodes, averaged over y."""
    store, found = solver.particles, []
    cells, reals = (array.to_numpy()[: store.count] for array in (store.cells, store.reals))
    for k in (0, 1):
        own, depth = phase(solver, k), np.zeros(solver.grid.shape)
        (i, j), part = depth_at_nodes(solver.grid, cells[own].astype(int), reals[own].astype(float))
        depth[i : i + part.shape[0], j : j + part.shape[1]] = part
        found.append(depth.mean(axis=1))
    return solver.grid.places()[:, 0, 0], np.array(found)
