"""Round columns of sand that have come to rest, and what is published of their heaps."""

import numpy as np

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers.column import round_height, round_runout
from snowmpm.comparison.profile import profile
from snowmpm.io import Run
from snowmpm.scenes import load_scene

RADIUS = 0.2
SPACING = {"mpm": 0.2 / 29.0, "sph": 0.2 / 16.0}
"""Of particles [m]: 29 and 16 of them over the radius."""
OPTIONS = {"mpm": {},
           "sph": {"solver.sph.smoothing": 1.2, "solver.sph.viscosity": 0.05, "solver.sph.disorder_damping": 0.25}}
"""Of SPH, whose reach has to be small beside the heap (`test_columns.py`)."""


def collapsed(a, method, folder):
    """`Case` of a column of height `a` radii, 0.7 s after it was let go: the run in the folder, or a new one."""
    if (folder / "summary.json").exists() and Run(folder).complete:
        return Case(method, Run(folder))
    dx = SPACING[method] * (1.0 if method == "sph" else 2.0)
    shape = {"kind": "cylinder", "base": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "radius": RADIUS,
             "height": RADIUS * a}
    changes = {"bodies.0.shape": shape, "end_time": 0.7, "materials.sand.youngs_modulus": 5.04e5,
               "output.interval": 0.1, "solver.method": method, "solver.dx": dx, **OPTIONS[method]}
    return Case(method, snowmpm.run(load_scene("column_collapse_3d", changes), folder))


def heap(case):
    """Its `Profile` over the distance from the middle, all around, at the end."""
    return profile(case, case.run.frame(-1), (0.0, 0.0))


def published(a):
    """Run-out and height of the middle [m], after Lube et al. (2004)."""
    return RADIUS * (1.0 + round_runout(a)), RADIUS * round_height(a)[0]


def disc(found, case):
    """Radius [m] of the top that has kept its height to a spacing."""
    height = case.body["shape"]["height"]
    lowered = found.s[found.top < height - case.spacing]
    return float(lowered.min() - case.spacing) if len(lowered) else RADIUS


def depths(case, width=0.025):
    """Middles of rings [m] of this width, and the depth [m] of the sand in each at its density at the start: all of
    it, also where grains lie singly."""
    frame = case.run.frame(-1)
    r = np.hypot(*case.positions(frame)[:, :2].T)
    edges = width * np.arange(int(r.max() / width) + 2)
    held, _ = np.histogram(r, edges, weights=case.volumes(frame))
    return 0.5 * (edges[1:] + edges[:-1]), held / (np.pi * np.diff(edges**2))
