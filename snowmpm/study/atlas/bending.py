"""Entry: a slender body that bends by more than its thickness."""

import numpy as np
from scipy.integrate import solve_bvp

from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.cantilever import LENGTH, hang
from snowmpm.study.problems.schemes import Scheme

THICKNESS, CELLS = 0.1, 3


def elastica(load):
    """Way down of the end of a beam over its length, under its weight q L^3 / EI = `load`; to first order load / 8.

    theta'' = -load (1 - s) cos theta, theta(0) = 0, theta'(1) = 0, s along the beam; down = int sin theta ds.
    """
    s = np.linspace(0.0, 1.0, 101)
    found = solve_bvp(lambda s, y: np.stack([y[1], -load * (1.0 - s) * np.cos(y[0]), np.sin(y[0])]),
                      lambda a, b: np.array([a[0], b[1], a[2]]), s, np.zeros((3, s.size)))
    return float(found.y[2, -1])


def bent_too_far(deflection, **scheme):
    """Error of the way that the end of a clamped beam hangs down; deflection: that of small strains over the
    thickness."""
    load = 8.0 * deflection * THICKNESS / LENGTH
    return -hang(load, THICKNESS, Scheme(**{"transfer": "apic", **scheme}), CELLS)[1] / elastica(load) - 1.0


ENTRIES = (
    Entry(
        name="bent_beam", title="A slender body that bends too far",
        scene="A clamped elastic beam, ten times as long as thick, 3 cells through it, hangs under its own weight",
        seen="It hangs too low by some 4 % for each thickness that its end moves, on any grid: the affine gradient is"
             " not quite that of the motion, and the outermost particles drift apart",
        cure='solver.gradient = "shape" with solver.kernel = "cubic"', parameter="deflection of the end",
        unit="thicknesses", values=(0.5, 1.0, 2.0, 4.0),
        settings={"quadratic": {}, "cubic shape": {"kernel": "cubic", "gradient": "shape"}},
        symptom="error of the deflection", limit=0.05, measure=bent_too_far, shown="quadratic", cured="cubic shape",
        resolution=0.2),
)
