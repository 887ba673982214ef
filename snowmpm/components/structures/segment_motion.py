"""Motion of a piece of a rod or framework as a rigid obstacle."""

import numpy as np

from snowmpm.solids.motion import Pose, RigidMotion
from snowmpm.solids.rotation import cross_matrix, no_turn, spin


class SegmentMotion(RigidMotion):
    """Middle and direction of segment s of a `Rod` or `Framework`, without turn about itself. From its node a to b,

        centre = (x_a + x_b) / 2,   v = (v_a + v_b) / 2,   omega = d x (v_b - v_a) / |e|

    The rotation is the smallest one that carries the direction of the start to that of now.
    """

    def __init__(self, rod, s, dim):
        self._axes = [0, 2] if dim == 2 else [0, 1, 2]
        self._a, self._b = rod.ends[s]
        super().__init__(0.5 * (rod.x[self._a] + rod.x[self._b])[self._axes])
        self._rod, self._s, self._dim, self.still = rod, s, dim, False

    def pose(self, time):
        """`Pose` now; before time zero [s], while the snow settles, that of the start."""
        rod, a, b, dim = self._rod, self._a, self._b, self._dim
        if time < 0.0:
            return Pose(self.start_centre, np.eye(dim), np.zeros(dim), no_turn(dim))
        v = rod.v if rod.met is None else rod.met
        edge = rod.x[b] - rod.x[a]
        length = np.linalg.norm(edge)
        direction = edge / length
        rotation = _carrying(rod.along[self._s], direction)[np.ix_(self._axes, self._axes)]
        omega = spin(direction, (v[b] - v[a])[None])[0] / length
        return Pose(0.5 * (rod.x[a] + rod.x[b])[self._axes], rotation,
                    0.5 * (v[a] + v[b])[self._axes], -float(omega[1]) if dim == 2 else omega)


def _carrying(a, b):
    """Smallest rotation (3, 3) of a unit vector to another, not its opposite."""
    w = np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    W = cross_matrix(w)
    return np.eye(3) + W + W @ W / max(1.0 + a @ b, 1e-9)
