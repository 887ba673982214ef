"""The ground of a run on pictures: its terrain, or the floor of its domain."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.ground_maps import Terrain
from snowmpm.render.domain_box import DomainBox

FLOORS = ("stick", "slip", "separate")
"""Lower sides of a domain that snow stands on."""

AROUND = (1.0, 0.5)
"""Ground beyond the ends and the sides of a saw test's column, in m."""

WIDTH = 0.3
"""Of a column whose scene gives it none [m], as of `scenes.saw_test`."""


def ground_of(run):
    """`snowmpm.io.Terrain` of a `Run`; where it has none, the floor of its domain or of its saw test; or None."""
    if run.terrain is not None:
        return run.terrain
    box = _column(run) if run.saw_test is not None and "length" in run.saw_test.about else _domain(run)
    return None if box is None else _level(*box)


def _column(run):
    """(lower, upper) of the ground under the column of a saw test, x and y or, in a section, x; and its height [m]."""
    origin, length = run.origin, float(run.saw_test.about["length"])
    half = 0.5 * saw_test_width(run) + AROUND[1]
    low, high = np.array([-AROUND[0], -half]) - origin[:2], np.array([length + AROUND[0], half]) - origin[:2]
    axes = run.dimension - 1
    return low[:axes], high[:axes], -float(origin[2])


def saw_test_width(run):
    """Width [m] of the column of a saw test in 3-D."""
    try:
        return float(run.scene["saw_test"].get("width") or WIDTH)
    except (InputError, LookupError, TypeError, ValueError, AttributeError):
        return WIDTH


def _domain(run):
    """The same of the floor of the domain, or None."""
    try:
        box = DomainBox.of(run)
    except InputError:
        return None
    if box.sides.get("z_min") not in FLOORS or not box.lower:
        return None
    axes = "xy"[: run.dimension - 1]
    low, high = (np.array([corner[a] for a in axes]) for corner in (box.lower, box.upper))
    return low, high, box.lower["z"]


def _level(low, high, height):
    if len(low) == 1:
        return Terrain(np.array([[low[0], 0.0, height], [high[0], 0.0, height]]), np.array([[0, 1]]))
    corners = np.array([[x, y, height] for x, y in ((low[0], low[1]), (high[0], low[1]), high, (low[0], high[1]))])
    return Terrain(corners, np.array([[0, 1, 2], [0, 2, 3]]))
