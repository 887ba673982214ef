"""Entry: columns of a depth-averaged flow that stand too far apart."""

from types import SimpleNamespace

import numpy as np

from snowmpm.depth.solver import DepthSolver
from snowmpm.ground import Coulomb
from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.atlas.entry import Entry

G, DX, TIME, START = 9.81, 0.125, 1.0, 5.0
"""Gravity [m/s2], cell and time of the dam break [m], [s], and the place of its dam [m]."""


class Level:
    """Ground at z = 0."""

    def height(self, plan):
        return np.zeros(len(plan))


def dam_break_error(along, damping=1.0, mixing=12.0):
    """L1 error of the depth of Ritter's dam break, 1 m deep, over that of its rarefaction; along: columns in a cell
    along the flow.

    h = (2 c - x/t)² / (9 g) between x = -c t and 2 c t, c = sqrt(g)
    """
    count = round(START / DX * along)
    x = START * (np.arange(count) + 0.5) / count
    plan = np.stack(np.meshgrid(x, DX * (np.arange(8) + 0.5) / 2.0, indexing="ij"), axis=-1).reshape(-1, 2)
    volume = START / count * DX / 2.0
    population = Population(np.column_stack([plan, np.zeros(len(plan))]), np.full(len(plan), volume), 0)
    solver = DepthSolver(population, [Elastic(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3)],
                         SimpleNamespace(damping=damping, mixing=mixing, centrifugal=True), dx=DX, precision="f64",
                         lower=np.array([0.0, 0.0, -10.0]), upper=np.array([3.0 * START, 4.0 * DX, 10.0]),
                         gravity=[0.0, 0.0, -G], cfl=None, terrain=Level(), friction=Coulomb(mu=0.0),
                         sides=[["slip", "open"], ["slip", "slip"], ["open", "open"]])
    while solver.time < TIME - 1e-12:
        solver.step(min(solver.stable_dt()[0], TIME - solver.time))
    window, sums = solver.particles.sums_in_plan(np.zeros(2), DX, tuple(solver.grid.shape.tolist()))
    depth = np.zeros(solver.grid.shape)
    depth[window] = sums[..., 0] / DX**2
    c, at = np.sqrt(G), (DX * (np.arange(solver.grid.shape[0]) + 0.5) - START) / TIME
    exact = np.where(at < -c, 1.0, np.where(at < 2.0 * c, (2.0 * c - at) ** 2 / (9.0 * G), 0.0))
    return float(np.abs(depth.mean(axis=1) - exact).sum() * DX / (c * TIME))


ENTRIES = (
    Entry(
        name="columns_apart", title="Columns of a depth-averaged flow that stand too far apart",
        scene="A dam, 1 m deep on cells of 0.125 m, breaks over level ground (Ritter)",
        seen="Where the flow stretches until its columns are further apart than a cell, they no longer push each other:"
             " the depth falls apart into single columns, and the tip is left behind",
        cure="a larger solver.particles_per_cell", parameter="columns in a cell along the flow", unit="",
        values=(0.25, 0.5, 1.0, 2.0, 4.0), settings={"usual": {}, "undamped": {"damping": 0.0, "mixing": 0.0}},
        symptom="error of the depth", limit=0.25, measure=dam_break_error, shown="usual", fails="below",
        resolution=0.2),
)
