"""What lies behind the faces of material cells where no material is: air, ground, obstacle or a side of the domain."""

import numpy as np

SURFACE, GROUND, OBSTACLES = range(3)
"""Codes of what lies behind a face; a side of the domain is FIRST_SIDE + 2 axis + (0 lower, 1 upper)."""

FIRST_SIDE = 3


def names(dim):
    """Name of each code."""
    axes = "xz" if dim == 2 else "xyz"
    return ("surface", "ground", "obstacles", *(f"{axis}_{end}" for axis in axes for end in ("min", "max")))


class Outlets:
    """Which of them let water out.

    ground, obstacles: functions points (k, dim) [m], time [s] -> (k,) bool, whether they are inside; None without any.
    drained: {name: bool} of `names`, which events may change; moving: whether obstacles move. gaping: names of the
    sides that hold nothing back, so that snow there may give way as at the free surface.
    """

    def __init__(self, dim, drained, ground=None, obstacles=None, moving=False, gaping=()):
        self.names = names(dim)
        self.drained = {name: bool(drained.get(name, name == "surface")) for name in self.names}
        self.moving = moving
        self._free = np.array([name == "surface" or name in gaping for name in self.names])
        self._solids = [(GROUND, ground), (OBSTACLES, obstacles)]

    def codes(self, cells, frame, time):
        """Code of each border face of `MaterialCells`; frame: `particles.coordinates.Frame`."""
        beyond = cells.beyond
        found = np.full(len(beyond), SURFACE)
        points = frame.origin + frame.dx * beyond
        for code, inside in self._solids:
            if inside is not None and len(points):
                found[inside(points, time)] = code
        axis, upper = cells.border_axis, cells.border_sign > 0
        place = beyond[np.arange(len(beyond)), axis]
        out = np.where(upper, place > frame.upper[axis], place < frame.lower[axis])
        found[out] = FIRST_SIDE + 2 * axis[out] + upper[out]
        return found

    def free(self, codes):
        """Where nothing holds the snow."""
        return self._free[codes]

    def open(self, codes):
        """Which faces of these codes let water out."""
        return np.array([self.drained[name] for name in self.names])[codes]
