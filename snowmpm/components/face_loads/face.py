"""What presses, pulls or holds a part of a body's surface: the force on each of its points, and how it changes.

    traction            F = t A                      t over the area A at time zero, fixed in direction
    follower_pressure   F = -p a                     p over the area now, along its normal
    displacement        F = -k A P (u - u_0(X, t))   k = penalty M / dx

u is the way of a point and u_0 that which is prescribed. P is I where the surface sticks, n n^T where it slips, and the
same where it may separate as long as n . (u - u_0) > 0, else 0: snow is pressed, never pulled. n is the normal at time
zero, M = density c^2 the stiffness of the body's material against a plane wave. A stress sigma = F / A leaves a gap of
(sigma / M) dx / penalty: that of a layer of dx / penalty of the same material.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.prescribed.field import Field


@dataclass
class Given:
    """What a face gave the body: force of the last step [N], impulse [N s] and work [J] since time zero."""

    force: np.ndarray
    impulse: np.ndarray
    work: float = 0.0

    @classmethod
    def nothing(cls, dim):
        """At time zero."""
        return cls(np.zeros(dim), np.zeros(dim))


class Face(Field):
    """One of a scene's forces on a part of a surface. points: slice of it in the `FacePoints` of `Faces`."""

    stiffness = 0.0
    """k of its points [N/m3]"""

    def __init__(self, spec, dim, base_dir, key, formula_of, points):
        super().__init__(spec, dim, base_dir, key, formula_of)
        self.name, self.points = spec.name, points
        self.given = Given.nothing(dim)

    def acts(self, time):
        """Whether it acts at `time` [s]."""
        return self.spec.start <= time and (self.spec.stop is None or time <= self.spec.stop)

    def prescribed(self, points, time):
        """Its values (n, columns) on its `FacePoints`, at `time` [s]."""
        return self.values(points.place, np.zeros(points.rest.shape), time)

    def pressure(self, values):
        """p (n,) [Pa] of prescribed values, 0 where it does not follow."""
        return np.zeros(len(values))

    def springs(self, points, way, values):
        """-dF / du (n, dim, dim) [N/m] at ways (n, dim) [m]."""
        dim = way.shape[1]
        return np.zeros((len(way), dim, dim))


class Traction(Face):
    """A load of fixed direction on the area at time zero."""

    @staticmethod
    def columns(dim):
        return ("tx", "tz") if dim == 2 else ("tx", "ty", "tz")

    def forces(self, points, area, way, values):
        """F (n, dim) [N] at areas and ways (n, dim)."""
        return points.size[:, None] * values


class FollowerPressure(Face):
    """A pressure that stays normal to the surface."""

    @staticmethod
    def columns(dim):
        return ("pressure",)

    def pressure(self, values):
        """p (n,) [Pa]."""
        return values[:, 0]

    def forces(self, points, area, way, values):
        """F (n, dim) [N] at areas and ways (n, dim)."""
        return -values * area


class Displacement(Face):
    """A surface that sticks to, slips along or may leave one whose way is prescribed, by a penalty.

    stiffness: k [N/m3].
    """

    def __init__(self, *given, stiffness):
        super().__init__(*given)
        self.stiffness = stiffness

    @staticmethod
    def columns(dim):
        return ("ux", "uz") if dim == 2 else ("ux", "uy", "uz")

    def prescribed(self, points, time):
        """u_0 (n, dim) [m]."""
        return self.values(points.rest, np.zeros(points.rest.shape), time)

    def forces(self, points, area, way, values):
        """F (n, dim) [N] at areas and ways (n, dim)."""
        return -np.einsum("nij,nj->ni", self.springs(points, way, values), way - values)

    def springs(self, points, way, values):
        """k A P (n, dim, dim) [N/m] at ways (n, dim) [m]."""
        size, normal = self.stiffness * points.size, points.normal
        if self.spec.contact == "stick":
            return size[:, None, None] * np.eye(way.shape[1])
        if self.spec.contact == "separate":
            size = np.where(np.einsum("ni,ni->n", way - values, normal) > 0.0, size, 0.0)
        return np.einsum("n,ni,nj->nij", size, normal, normal)


FACES = {"traction": Traction, "follower_pressure": FollowerPressure, "displacement": Displacement}
"""Kinds of a scene's forces that act on a part of a surface."""
