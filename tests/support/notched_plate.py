"""A plate with a notch in either edge, drawn or bent by grips until a crack has joined the notches.

240 x 120 mm, notches 30 mm and one cell wide, plane strain; E = 1 MPa, nu = 0.2, rho = 1000 kg/m3, f_t = 1 kPa,
G_f = 0.2 J/m2. Only the middle half may crack. The grips are so heavy that they keep their speed; what they do is what
they lose of their kinetic energy.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from snowmpm.materials import CohesiveCrack
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import AFLIP, free_solver, lattice
from tests.support.one_a_cell import shared

LENGTH, WIDTH, NOTCH, GRIP = 0.24, 0.12, 0.03, 3  # m, m, m, cells
PLATE = CohesiveCrack(density=1e3, youngs_modulus=1e6, poisson_ratio=0.2, strength=1e3, fracture_energy=0.2,
                      friction_angle=30.0)  # fmt: skip
TOUGH = PLATE.model_copy(update={"strength": 1e9, "fracture_energy": 1e12})
PIVOT = 1.3 * WIDTH
"""Of bending: where the halves turn about, above the plate, so that all of it is drawn at the end."""
SECONDS = {"drawn": 1.2, "bent": 2.4}
LEAST = 1.4
"""Opening at the far edge at the end, over that at which no cohesion is left."""
SAMPLES = 400


@dataclass(frozen=True)
class Broken:
    """opened: at the near edge [m]; force: work per that opening and thickness [N/m]; work: over G_f times the area;
    x: (n, 2) [m], damage (n,); cracked: columns of particles with damage, in cells from the notch's left side."""

    dx: float
    opened: np.ndarray
    force: np.ndarray
    work: float
    x: np.ndarray
    damage: np.ndarray
    cracked: np.ndarray


@cache
def broken(dx, case, f_bar="whole", length=None, scheme=AFLIP):
    """`Broken` plate on cells of dx [m]; case: "drawn" or "bent"; length: of the law [m], that of the cells without."""
    x, volumes = lattice([-LENGTH / 2 - GRIP * dx, 0.0], [LENGTH / 2 + GRIP * dx, WIDTH], dx)
    notch = (x[:, 0] > 0.0) & (x[:, 0] < dx) & (np.abs(x[:, 1] - WIDTH / 2) > WIDTH / 2 - NOTCH)
    x, volumes = x[~notch], volumes[~notch]
    half, per_pivot = LENGTH / 2, 0.0 if case == "drawn" else 1.0 / PIVOT
    grips = np.abs(x[:, 0]) > half
    material = np.where(grips, 2, np.where(np.abs(x[:, 0]) > half / 2, 1, 0))
    speed = LEAST * PLATE.complete_opening / (1.0 - WIDTH * per_pivot) / SECONDS[case]
    along = np.clip(x[:, 0], -half, half)
    lift = np.where(grips, half * (np.abs(x[:, 0]) - half / 2), 0.5 * x[:, 0] ** 2)
    velocity = speed / LENGTH * np.stack([along * (1.0 - x[:, 1] * per_pivot), lift * per_pivot], axis=1)
    law = PLATE.model_copy(update={"length": length or dx})
    heavy = TOUGH.model_copy(update={"density": 1e12})
    solver = free_solver(x, volumes, [law, TOUGH.on_grid(dx), heavy.on_grid(dx)], scheme, dx, reach=2 * LENGTH,
                         material=material, velocities=velocity, adapters=shared(f_bar))
    states = ParticleStates(solver)
    gradient = np.zeros((len(x), 4))
    gradient[:, 0] = np.where(grips, 0.0, 1.0 - x[:, 1] * per_pivot)
    gradient[:, 1] = -along * per_pivot
    gradient[:, 2] = -gradient[:, 1]
    states.set(affine=speed / LENGTH * gradient)

    def spent():
        """What the grips have done per thickness [J/m]: m v_0 . (v_0 - v)."""
        lost = velocity - states.column("velocity")
        return (states.mass[:, None] * velocity * lost)[grips].sum()

    opened, done = [0.0], [0.0]
    for time in np.linspace(0.0, SECONDS[case], SAMPLES + 1)[1:]:
        while solver.time < time - 1e-12:
            solver.step(min(solver.stable_dt()[0], time - solver.time))
        opened.append(speed * solver.time)
        done.append(spent())
    opened, done = np.array(opened), np.array(done)
    damage = states.column("state")[:, 0]
    columns = np.unique(np.round(x[damage > 0.0, 0] / dx, 2))
    return Broken(dx, 0.5 * (opened[1:] + opened[:-1]), np.diff(done) / np.diff(opened),
                  done[-1] / (PLATE.fracture_energy * (WIDTH - 2 * NOTCH)), x, damage, columns)
