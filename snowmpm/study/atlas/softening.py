"""Entry: a softening layer whose fracture energy goes with the grid."""

import functools

import numpy as np

from snowmpm.materials import AnticrackCamClay
from snowmpm.particles.population import Population
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import Scheme, lattice

THICKNESS, REFERENCE = 0.05, 0.025
"""Of the weak layer, and the grid spacing that its softening is meant for [m]."""
SPEED = 0.02
"""Of the piston [m/s]."""
OFF = 0.25
"""Limit of the entry."""
LAYER = {"density": 150.0, "youngs_modulus": 5e5, "poisson_ratio": 0.3, "critical_slope": 1.0, "cohesion": 0.3,
         "hardening": 0.5, "p0": 1.8e3, "softening": 0.5}


def energy_of_a_row(ratio, drawn):
    """Plastic work per area of a weak layer under a piston until its first row of cells has collapsed, over that at
    the spacing REFERENCE, less 1; ratio: of the spacing to it; drawn: two cells thick on any grid (`Law.drawn`)."""
    return _work(ratio, drawn) / _work(1.0, drawn) - 1.0


@functools.cache
def _work(ratio, drawn):
    cells = max(2, round(THICKNESS / (ratio * REFERENCE)))
    dx = THICKNESS / cells
    law, height = AnticrackCamClay(**LAYER), THICKNESS
    if drawn:
        height = 2 * dx
        law = law.thickened_to(THICKNESS, height).on_grid(dx)
    piston = block([dx, height], [0.0, -1.0], 2.0, "separate", velocity=[0.0, -SPEED], ramp=0.002)
    x, volumes = lattice([0.0, 0.0], [2 * dx, height], dx)
    solver = Scheme("apic").solver(Population(x, volumes, 0), [law], dx=dx, origin=np.zeros(2), lower=np.zeros(2),
                                   upper=np.array([2 * dx, 1.5 * height]), gravity=np.zeros(2),
                                   sides=[["slip", "slip"], ["stick", "open"]], obstacles=[piston])
    states, row = ParticleStates(solver), 8  # two cells across, four particles in each
    while (states.column("state")[:, 1] > 0.0).sum() < row and solver.time < 0.2 * height / SPEED:
        solver.step(solver.stable_dt()[0])
    return solver.plastic_work / (2 * dx)


ENTRIES = (
    Entry(
        name="softening_on_grid", title="Fracture energy that goes with the grid",
        scene="A weak layer of 5 cm under a slow piston, until its first row of cells has collapsed",
        seen="Softening gathers in one row of cells, so that half of the spacing takes half of the energy to break:"
             " cracks begin sooner on a finer grid",
        cure="reference_thickness of the weak layer's material, with two cells through it (in a saw test,"
             " weak_layer.cells)",
        parameter="spacing over that of the tuning", unit="", values=(0.25, 0.5, 2 / 3, 1.0), fails="below",
        settings={"as given": {"drawn": False}, "drawn two cells thick": {"drawn": True}},
        symptom="energy over that of the tuning, less 1", limit=OFF, measure=energy_of_a_row, shown="as given",
        cured="drawn two cells thick"),
)
