"""Entry: cells of a depth-averaged flow by finite volumes that are wide against its depth."""

from types import SimpleNamespace

import numpy as np

from snowmpm.depth.volumes.cells import FlowCells
from snowmpm.depth.volumes.solver import VolumeSolver
from snowmpm.ground import Coulomb
from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.atlas.columns_in_plan import START, TIME, G, Level
from snowmpm.study.atlas.entry import Entry

THIN = 1e-4
"""Depth [m] from which on snow belongs to the front: a film of 1e-5 m goes on by whole cells, ahead of it."""


def late_tip(width):
    """Share of its way by which the tip of Ritter's dam break, 1 m deep, falls behind 2 c t; width: of a cell [m]."""
    along = round(START / width)
    dx = START / along
    x = dx * (np.arange(along) + 0.5)
    plan = np.stack(np.meshgrid(x, dx * (np.arange(4) + 0.5), indexing="ij"), axis=-1).reshape(-1, 2)
    population = Population(np.column_stack([plan, np.zeros(len(plan))]), np.full(len(plan), dx**2), 0)
    solver = VolumeSolver(population, [Elastic(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3)],
                          SimpleNamespace(centrifugal=True), dx=dx, precision="f64", lower=np.array([0.0, 0.0, -10.0]),
                          upper=np.array([3.0 * START, 4.0 * dx, 10.0]), gravity=[0.0, 0.0, -G], cfl=None,
                          terrain=Level(), friction=Coulomb(mu=0.0),
                          sides=[["slip", "open"], ["slip", "slip"], ["open", "open"]])
    while solver.time < TIME - 1e-12:
        solver.step(min(solver.stable_dt()[0], TIME - solver.time))
    depth = FlowCells.inner(solver.particles.state_array)[:, 1, 0]
    reached = dx * (np.flatnonzero(depth > THIN)[-1] + 1.0) - START
    return 1.0 - float(reached / (2.0 * np.sqrt(G) * TIME))


ENTRIES = (
    Entry(
        name="late_tip", title="Cells of a depth-averaged flow that are wide against its depth",
        scene="A dam, 1 m deep, breaks over level ground (Ritter), by finite volumes",
        seen="The tip of the front, which thins out towards nothing, falls behind; the place of a tenth of the depth"
             " does not",
        cure="a smaller solver.dx, or to read the front where it has a depth",
        parameter="width of a cell over the depth", unit="",
        values=(0.0125, 0.025, 0.05, 0.1, 0.2), settings={"usual": {}}, symptom="way that the tip is short",
        limit=0.08, measure=late_tip, shown="usual", fails="above", resolution=0.1),
)
