"""A block that is drawn apart along one axis until a crack has parted it, then along the other.

0.1 m square, of the material of `drawn_bar`; a column and a row of cells through its middle are half as strong as the
rest, which the grips draw hardest where they begin. Each of its four quarters has a grip of its own along its outer
sides, too heavy to slow down, so that each crack opens as a whole and the quarters stay what they are. The work is what
the grips lose of their kinetic energy.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.materials.crack_planes import DAMAGE, PER_CRACK
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import AFLIP, free_solver, lattice
from tests.support.drawn_bar import BAR
from tests.support.one_a_cell import shared

SIDE, GRIP, GAP, PULL, SECONDS = 0.1, 3, 2, 1.3, 1.0
"""Of the block [m]; width of grips and half the gap between them [cells]; opening over that at which no cohesion is
left, and the time that each crack takes [s]."""
GRIDS = (11, 15, 19)


@dataclass(frozen=True)
class Crossed:
    """work: of both drawings over the fracture energy of a section; crossing: particles in which two cracks have lost
    all cohesion; astray: how many outside of the weak rows have damage."""

    work: np.ndarray
    crossing: int
    astray: int


@cache
def draw(cells):
    """`Crossed` block of so many cells along a side, an odd number."""
    dx = SIDE / cells
    law = BAR.model_copy(update={"cracks": 2}).on_grid(dx)
    stronger = law.model_copy(update={"strength": 2.0 * law.strength, "fracture_energy": 4.0 * law.fracture_energy})
    heavy = law.model_copy(update={"cracks": 1, "density": 1e12, "strength": 1e9, "fracture_energy": 1e12})
    low, high = -(cells // 2) * dx, (cells // 2 + 1) * dx
    x, volumes = lattice([low - GRIP * dx] * 2, [high + GRIP * dx] * 2, dx)
    outside = ((x < low) | (x > high)).any(axis=1)
    beside = ((x > -GAP * dx) & (x < (GAP + 1) * dx)).any(axis=1)
    x, volumes, grips = x[~(outside & beside)], volumes[~(outside & beside)], outside[~(outside & beside)]
    weak = ((x > 0.0) & (x < dx)).any(axis=1)
    material = np.where(grips, 2, np.where(weak, 1, 0))
    solver = free_solver(x, volumes, [stronger, law, heavy], AFLIP, dx, reach=SIDE, material=material,
                         adapters=shared("whole"))
    states, middle = ParticleStates(solver), 0.5 * dx
    half = 0.5 * (PULL * law.complete_opening + law.strength / law.youngs_modulus * SIDE) / SECONDS
    done = []
    for axis in (0, 1):
        velocity = np.zeros_like(x)
        velocity[:, axis] = half * np.clip((x[:, axis] - middle) / (0.5 * SIDE), -1.0, 1.0)
        velocity[grips, axis] = half * np.sign(x[grips, axis] - middle)
        gradient = np.zeros((len(x), 4))
        gradient[~grips, 3 * axis] = half / (0.5 * SIDE)
        states.set(velocity=velocity, affine=gradient)
        end = solver.time + SECONDS
        while solver.time < end - 1e-12:
            solver.step(min(solver.stable_dt()[0], end - solver.time))
        lost = velocity - states.column("velocity")
        done.append((states.mass[:, None] * velocity * lost)[grips].sum() / (law.fracture_energy * cells * dx))
    state = states.column("state")
    first, second = state[:, DAMAGE], state[:, PER_CRACK + DAMAGE]
    return Crossed(np.array(done), int(((first == 1.0) & (second == 1.0)).sum()),
                   int(((first > 0.0) & ~weak).sum()))
