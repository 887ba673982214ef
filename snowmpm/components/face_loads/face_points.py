"""Points with area on the surface of a body, which move with it.

Each is carried by the particle that was nearest to it at time zero, at an arm r from it. With f the deformation of a
step there, w_I and g_I the weight and the gradient of node I at the particle,

    x = x_p + r,    r <- f r,    a <- det f  f^-T a,    delta x = sum_I (w_I + g_I . r) delta u_I

(a: area times the outward normal; Nanson's formula). A force F at the point gives F (w_I + g_I . r) to the nodes, which
has the resultant F and its moment about every point. It reaches the nodes of the particle alone, and none of them with
more than a share of its mass: nodes beyond the surface, which hardly any snow reaches, are not thrown off, as they are
by the weights of the point itself.
"""

from dataclasses import dataclass, fields

import numpy as np


@dataclass
class FacePoints:
    """number (n,): of the particle that carries each point; arm (n, dim): r [m]; area (n, dim): a [m2], in 2-D per
    metre of width [m]; rest (n, dim): places at time zero [m]; way (n, dim): from there [m]; size (n,): area at time
    zero; normal (n, dim): outward, at time zero."""

    number: np.ndarray
    arm: np.ndarray
    area: np.ndarray
    rest: np.ndarray
    way: np.ndarray
    size: np.ndarray
    normal: np.ndarray

    @classmethod
    def of(cls, number, arm, area, rest):
        """Those of time zero."""
        size = np.linalg.norm(area, axis=1)
        return cls(number, arm, area, rest, np.zeros_like(rest), size, area / size[:, None])

    @classmethod
    def joined(cls, parts):
        """All points of some `FacePoints`, one after the other."""
        return cls(*(np.concatenate([vars(part)[field.name] for part in parts]) for field in fields(cls)))

    @property
    def place(self):
        """Where they are now (n, dim) [m], on the far side of a periodic axis too."""
        return self.rest + self.way

    def areas_after(self, A):
        """a (n, dim) after a deformation by f = I + A, A (n, dim, dim)."""
        return np.einsum("nij,nj->ni", cofactors(A), self.area)

    def move_with(self, A, way):
        """Move with f = I + A, A (n, dim, dim), by `way` (n, dim) [m]."""
        self.arm = self.arm + np.einsum("nij,nj->ni", A, self.arm)
        self.area = self.areas_after(A)
        self.way = self.way + way


def cofactors(A):
    """det f  f^-T (n, dim, dim) of f = I + A."""
    f = A + np.eye(A.shape[1])
    if A.shape[1] == 2:
        return np.stack([np.stack([f[:, 1, 1], -f[:, 1, 0]], 1), np.stack([-f[:, 0, 1], f[:, 0, 0]], 1)], 1)
    return np.stack([np.cross(f[:, 1], f[:, 2]), np.cross(f[:, 2], f[:, 0]), np.cross(f[:, 0], f[:, 1])], 1)
