"""The free bar by Newton's implicit MPM, on its CPU device (one thread), 8 particles a cell.

Steps of `courant` cells of a wave: an implicit method may take long ones, and damps by them.
"""

import sys

import newton
import numpy as np
import warp as wp
from free_bar import CELLS, DENSITY, LENGTH, PERIOD, SPEED, YOUNGS_MODULUS, Clock, error, lattice, start, tell
from newton.solvers import SolverImplicitMPM

COURANT = (2.0, 0.5, 0.1)


def solve(cells, courant, velocity_basis="Q1"):
    dx = LENGTH / cells
    x = lattice(0.5 * dx, 3)
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    SolverImplicitMPM.register_custom_attributes(builder)
    material = {"young_modulus": YOUNGS_MODULUS, "poisson_ratio": 0.0, "yield_pressure": 1e15, "yield_stress": 1e15,
                "tensile_yield_ratio": 1.0, "friction": 0.0, "dilatancy": 0.0, "hardening": 0.0, "viscosity": 0.0,
                "damping": 0.0}
    for place, v in zip(x, start(x[:, 0]), strict=True):
        builder.add_particle(tuple(place), (float(v), 0.0, 0.0), DENSITY * (0.5 * dx) ** 3, radius=0.25 * dx,
                             custom_attributes={f"mpm:{name}": value for name, value in material.items()})
    model = builder.finalize(device="cpu")
    solver = SolverImplicitMPM(model, SolverImplicitMPM.Config(
        voxel_size=dx, grid_type="dense", grid_padding=2, velocity_basis=velocity_basis, strain_basis="P0",
        air_drag=0.0, critical_fraction=0.0, transfer_scheme="apic", tolerance=1e-6, max_iterations=200))
    now, after, clock = model.state(), model.state(), Clock()
    steps = int(np.ceil(PERIOD * SPEED / (courant * dx)))
    for _ in range(steps):
        clock.step(solver.step, now, after, None, None, PERIOD / steps)
        now, after = after, now
    found = error(x[:, 0], now.particle_qd.numpy()[:, 0])
    tell("Newton, implicit MPM", f"{courant:g} cells a step", 3, cells, len(x), steps, clock.seconds, found)



wp.config.quiet = True
for courant in COURANT:
    # Short steps on the finest grid would take ten minutes
    for cells in CELLS[: min(int(sys.argv[1]), 2)]:
        solve(cells, courant)
