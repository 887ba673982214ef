"""A piston drives a compaction wave into snow (M10): what stands behind the front, whose exact state is
`compaction_wave`'s.

The column is long enough that the elastic precursor does not come back from its free end. The state behind the front is
that from 5 cells off the piston, where the start leaves its mark, to 10 cells behind the front; the stress that on the
piston while the front runs from 0.15 to 0.5 m.
"""

import numpy as np

from snowmpm.materials import CohesiveCamClay
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import lattice

WIDTH, WAY = 4, 0.5
"""Cells across, and how far the front is followed [m]."""
DX = 0.01
FIRM = CohesiveCamClay(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=1.5, cohesion=0.3,
                       hardening=1.0, p0=30e3)
FRESH = CohesiveCamClay(density=200.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=0.7, cohesion=0.2,
                        hardening=0.002, p0=3e3)
FRONTS = {("firm", 4.3): (83.83, 101973.0, 262.3), ("fresh", 1.0): (7.05, 4345.0, 228.0),
          ("fresh", 4.3): (9.47, 11005.0, 357.5)}
"""By kind of snow and speed of the piston [m/s]: D [m/s], P1 [Pa], rho1 [kg/m3], worked out apart from this code."""


def drive(law, scheme, speed, expected, length, dx=DX, per_axis=2):
    """-> Lagrangian speed of the front [m/s], stress on the piston [Pa], density behind the front [kg/m3], plastic
    work [J]."""
    D, _, density = expected
    width = WIDTH * dx
    piston = block([0.0, width / 2], [1.0, 0.0], 2.0, "slip", velocity=[speed, 0.0])
    positions, volumes = lattice([0.0, 0.0], [length, width], dx, per_axis)
    lower = np.array([-10 * dx, 0.0])
    solver = scheme.solver(Population(positions, volumes, 0), [law], dx=dx, origin=lower, lower=lower,
                           upper=np.array([1.5 * length, width]), gravity=np.zeros(2),
                           sides=[["open", "open"], ["slip", "slip"]], obstacles=[piston])
    states, rows, middle = ParticleStates(solver), [], 0.5 * (1.0 + law.density / density)
    while not rows or (rows[-1][1] < WAY and solver.time < 1.5 * WAY / D):
        for _ in range(4):
            solver.step(solver.stable_dt()[0])
        crushed = solver.particles.column("volume_ratio")[:, 0] < middle
        rows.append((solver.time, crushed.mean() * length, -solver.obstacle_totals[0, 0] / width))
    time, place, impulse = np.array([row for row in rows if row[1] > 0.3 * WAY]).T
    behind = (states.reference[:, 0] > 5 * dx) & (states.reference[:, 0] < WAY - 10 * dx)
    ratio = states.column("volume_ratio")[behind, 0]
    return (np.polyfit(time, place, 1)[0], np.polyfit(time, impulse, 1)[0], (law.density / ratio).mean(),
            solver.plastic_work)
