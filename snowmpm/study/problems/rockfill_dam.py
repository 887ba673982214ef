"""Water through a dam of rockfill (P9), by SPH of water over grains at rest (`sph.seepage`).

A dam 1 m high, 0.2 m wide at its crest and 3.2 m at its foot, both sides 1.5 : 1 (Larese 2012, PhD thesis, UPC; Bui &
Nguyen 2017, Int. J. Solids Struct. 125, 244-264); 24.46 L/s come in on the upper side. Chosen, since the source at hand
leaves it out: a flume 2.46 m wide, stones of 35 mm with a porosity of 0.405. Drag is Ergun's, K = d² n³ / (150 (1 -
n)²).

`dupuit` is the reference: q = const, hydrostatic over the depth, and the same drag along the flow,

    -dh/dx = a u + b u²,   u = q / h,   from the height of seepage on the lower side
"""

import numpy as np
from scipy.integrate import solve_ivp

from snowmpm.sph.seepage import Seepage
from snowmpm.water.drag import Forchheimer

FLOW, WIDTH = 24.46e-3, 2.46
STONE, POROSITY, VISCOSITY = 0.03504, 0.4052, 1.0e-3
TOE, CREST, HEIGHT, SLOPE = 3.2, 0.2, 1.0, 1.5
Q = FLOW / WIDTH
"""[m2/s]"""
PERMEABILITY = STONE**2 * POROSITY**3 / (150.0 * (1.0 - POROSITY) ** 2)
DRAG = Forchheimer(PERMEABILITY / VISCOSITY, STONE)
WALL, END = -0.4, 3.5


def resistance(u):
    """Fall of the head along the flow [-] at a discharge u [m/s] per area."""
    w = u / POROSITY
    return DRAG.coefficient(POROSITY, w) * w / (POROSITY * 1000.0 * 9.81)


def inside(x, z):
    """Whether places lie in the dam."""
    return (z < HEIGHT) & (z >= 0.0) & (x > SLOPE * z) & (x < TOE - SLOPE * z)


def dupuit(x, q=Q):
    """Depth of the water [m] at x (k,) [m], from the lower side down to where water leaves at its own gradient, 1 / 1.5
    of the slope, and up to where the upper side begins."""
    trial = np.linspace(0.005, 0.5, 5000)
    exit_depth = trial[np.argmin(np.abs(resistance(q / trial) - 1.0 / SLOPE))]
    start = TOE - SLOPE * exit_depth
    found = solve_ivp(lambda s, h: resistance(q / h), (0.0, start), [exit_depth], dense_output=True, rtol=1e-8)
    return found.sol(np.clip(start - np.asarray(x), 0.0, start))[0]


def rockfill_dam(spacing=0.05):
    """`Seepage` of it, filled to the depth of `dupuit`, level before the upper side."""
    fine = 0.5 * spacing
    grid = np.stack(np.meshgrid(np.arange(0.0, TOE, fine), np.arange(0.0, HEIGHT, fine), indexing="ij"), -1)
    grains = grid.reshape(-1, 2) + 0.5 * fine
    grains = grains[inside(*grains.T)]
    volume = POROSITY * spacing**2
    before = spacing * np.sqrt(POROSITY)

    def lattice(step, left, right):
        places = np.stack(np.meshgrid(np.arange(left, right, step), np.arange(0.0, HEIGHT, step), indexing="ij"), -1)
        return places.reshape(-1, 2) + 0.5 * step

    soaked, free = lattice(spacing, 0.0, TOE), lattice(before, WALL, TOE)
    soaked = soaked[inside(*soaked.T) & (soaked[:, 1] < dupuit(soaked[:, 0]))]
    top = _level()
    free = free[~inside(*free.T) & (free[:, 1] < top) & (free[:, 0] < SLOPE * free[:, 1])]
    return Seepage(np.vstack([soaked, free]), volume, grains, (1.0 - POROSITY) * fine**2, DRAG, spacing=spacing,
                   wall=WALL, end=END)


def _level():
    """Depth before the dam: of the flow where it enters through the upper side."""
    depth = 0.3
    for _ in range(50):
        depth = float(dupuit(SLOPE * depth))
    return depth


def feed(seepage, rng, dt, q=Q):
    """Let in what comes in a step of dt [s], onto the surface before the dam."""
    while q * seepage.time - seepage.added >= seepage.volume:
        x = WALL + 0.3 * rng.random()
        near = seepage.x[np.abs(seepage.x[:, 0] - x) < seepage.spacing, 1]
        seepage.add(np.array([x, near.max(initial=0.0) + 0.6 * seepage.spacing]))


def depth_at(seepage, x):
    """Depth of the water from the pressure at the floor around x [m]."""
    near = (np.abs(seepage.x[:, 0] - x) < 1.5 * seepage.spacing) & (seepage.x[:, 1] < 1.5 * seepage.spacing)
    if not near.any():
        return 0.0
    return float((seepage.p[near] / (seepage.density * seepage.gravity) + seepage.x[near, 1]).mean())
