"""Cook's membrane and a strip footing (I6): particles loaded by a row of weights on their surface.

Cook: corners (0, 0), (48, 44), (48, 60), (0, 44), held at its left, sheared by a load F on its right edge; plane
strain, nu = 0.4999, small deflection. The result is the mean way of that edge, times E / F: the work of the load.

Footing: weightless soil of Tresca's law in plane strain (von Mises with sqrt(3) c), E / c = 20,000, nu = 0.49, under an
even pressure q on a strip of half width 0.5 m on its surface; 2.5 m wide from the plane of symmetry to a smooth side,
1.5 m deep to ground that holds it. The result is the mean settlement of the strip at each q / c. It gives way at
q = (2 + pi) c (Prandtl).
"""

import csv
from pathlib import Path

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.materials import Elastic, VonMises
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.implicit_steps import implicit
from tests.support.one_a_cell import shared, volumes_shared

NEARLY = 0.4999
WIDTH, DEPTH, HALF_STRIP = 2.5, 1.5, 0.5  # m
STIFFNESS, NU = 2e4, 0.49  # E / c
PRANDTL = 2.0 + np.pi
TABLE = Path(__file__).parents[1] / "benchmarks" / "figures" / "mixed_elements.csv"
FAINT_VOLUME = 1e-9


def by_elements(case):
    """{load: result} of mixed finite elements on their finest mesh (`tests/benchmarks/mixed_elements.py`)."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["case"] == case]
    finest = max(int(row["elements"]) for row in rows)
    return {float(row["load"]): float(row["result"]) for row in rows if int(row["elements"]) == finest}


def weighted(x, volumes, edge, line_load, law, **options):
    """Solver of particles and of weights along `edge` (k, dim) [m], which hang along the last axis with a force of
    `line_load` [N/m] at g = 1; -> (solver, which particles are weights)."""
    weights = Elastic(density=line_load / (len(edge) * FAINT_VOLUME), youngs_modulus=law.youngs_modulus,
                      poisson_ratio=0.0)
    places, sizes = np.concatenate([x, edge]), np.concatenate([volumes, np.full(len(edge), FAINT_VOLUME)])
    heavy = np.arange(len(places)) >= len(x)
    return implicit(places, sizes, [law, weights], material=heavy.astype(int), time="quasi_static", **options), heavy


def membrane(dx):
    """Places (n, 2) [m] and volumes of Cook's membrane, and places of weights along its loaded edge."""
    n, m = round(96 / dx), round(88 / dx)
    X, eta = 48.0 * (np.arange(n) + 0.5) / n, (np.arange(m) + 0.5) / m
    height = 44.0 - 28.0 * X / 48.0
    x = np.stack([np.repeat(X, m), (44.0 * X[:, None] / 48.0 + eta * height[:, None]).ravel()], axis=1)
    edge = 44.0 + 16.0 * (np.arange(8 * round(16 / dx)) + 0.5) / (8 * round(16 / dx))
    edge, up = np.stack([np.full(len(edge), 48.0), edge], axis=1), np.array([0.0, 4.0 * dx])
    return x + up, np.repeat(48.0 / n * height / m, m), edge + up


def cook(dx, f_bar):
    """E / F times the mean way of the loaded edge [-]; dx [m]: divides 16."""
    x, volumes, edge = membrane(dx)
    law, load = Elastic(density=1e-12, youngs_modulus=1.0, poisson_ratio=NEARLY), 1e-4
    solver, heavy = weighted(x, volumes, edge, load, law, dx=dx,
                             upper=[64.0, 80.0], gravity=[0.0, 1.0], sides=[["stick", "open"], ["open", "open"]],
                             adapters=volumes_shared(f_bar))
    states = ParticleStates(solver)
    solver.step(1.0)
    return (states.positions() - states.reference)[heavy, 1].mean() / load


def cook_in_time(dx, f_bar):
    """The same by damped explicit steps: the difference between a membrane with weights as heavy as itself on its edge,
    and one with next to none. Its first mode takes 1200 s, and is damped about critically."""
    x, volumes, edge = membrane(dx)
    places, sizes = np.concatenate([x, edge]), np.concatenate([volumes, np.full(len(edge), FAINT_VOLUME)])
    heavy, load, ways = np.arange(len(places)) >= len(x), 1e-4, []
    for share, duration in ((1.0, 2000.0), (1e-9, 1000.0)):
        laws = [Elastic(density=1.0, youngs_modulus=1.0, poisson_ratio=NEARLY),
                Elastic(density=share * volumes.sum() / (len(edge) * FAINT_VOLUME), youngs_modulus=1.0,
                        poisson_ratio=0.0)]
        solver = MpmSolver(Population(places, sizes, heavy.astype(int)), laws, dx=dx, precision="f64",
                           origin=np.zeros(2), lower=np.zeros(2), upper=np.array([64.0, 80.0]), gradient="shape",
                           gravity=np.array([0.0, load / volumes.sum()]), sides=[["stick", "open"], ["open", "open"]],
                           adapters=shared(f_bar))
        while solver.time < duration:
            dt = solver.stable_dt()[0]
            solver.damping_factor = 1.0 - 0.0095 * dt
            solver.step(dt)
        ways.append((ParticleStates(solver).positions() - places)[heavy, 1].mean())
    return (ways[0] - ways[1]) / load


def footing(cells, f_bar, loads):
    """{q / c: mean settlement of the strip [m]} of those loads that it bears; cells: in half of the strip."""
    dx = HALF_STRIP / cells
    x, volumes = lattice([0.0, 0.0], [WIDTH, DEPTH], dx)
    places = HALF_STRIP * (np.arange(8 * cells) + 0.5) / (8 * cells)
    edge = np.stack([places, np.full(8 * cells, DEPTH)], axis=1)
    law = VonMises(density=1e-12, youngs_modulus=STIFFNESS, poisson_ratio=NU, yield_stress=np.sqrt(3.0))
    solver, heavy = weighted(x, volumes, edge, HALF_STRIP, law, dx=dx, upper=[WIDTH, DEPTH + 4.0 * dx],
                             sides=[["slip", "slip"], ["stick", "open"]], adapters=volumes_shared(f_bar),
                             tolerance=1e-7)
    states, found = ParticleStates(solver), {}
    for load in loads:
        solver.set_gravity([0.0, -load])
        try:
            solver.step(1.0)
        except SimulationError:
            break
        found[load] = (states.reference - states.positions())[heavy, 1].mean()
    return found
