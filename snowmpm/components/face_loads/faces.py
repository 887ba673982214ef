"""All parts of surfaces on which a scene presses, pulls or holds its bodies."""

import numpy as np

from snowmpm.components.face_loads.face import Given
from snowmpm.components.face_loads.face_points import FacePoints
from snowmpm.stepping.component import Adapter

AXES = {2: "xz", 3: "xyz"}

CARRIED = ("arm", "area", "way")
"""What a checkpoint keeps of the points."""


class OfFaces(Adapter):
    """What the adapters of all methods have in common."""

    name = "face_loads"

    def __init__(self, faces):
        self.faces = faces

    def restart(self):
        """`Faces.restart`."""
        self.faces.restart()

    def to_come(self, time):
        """`Faces.to_come`."""
        return self.faces.to_come(time)

    def work(self):
        """Points, and the step."""
        return {"point": self.faces.count, "step": 1.0}

    def force_work(self):
        """Of all faces [J]."""
        return self.faces.work

    def impulses(self):
        """Of each face [N s]."""
        return [face.given.impulse for face in self.faces.faces]

    def row(self):
        """`Faces.row`."""
        return self.faces.row()

    def units(self):
        """`Faces.units`."""
        return self.faces.units()

    def state(self):
        """`Faces.state`."""
        return self.faces.state()

    def restore(self, state):
        """`Faces.restore`."""
        self.faces.restore(state)


class Faces:
    """faces: `face.Face`s; points: `FacePoints` of all of them."""

    def __init__(self, faces, points):
        self.faces, self.points = list(faces), points
        self._dim = points.rest.shape[1]
        self._before = np.zeros_like(points.rest)

    def restart(self):
        """Time zero is now: totals start again."""
        for face in self.faces:
            face.given = Given.nothing(self._dim)
        self._before = np.zeros_like(self._before)

    def to_come(self, time):
        """Whether one of them will change after `time` [s]."""
        return any(face.until > time for face in self.faces)

    @property
    def count(self):
        """Of points."""
        return len(self.points.size)

    @property
    def work(self):
        """That they have done on the snow [J]."""
        return sum(face.given.work for face in self.faces)

    @property
    def force(self):
        """Of all of them in the last step (dim,) [N]."""
        return sum((face.given.force for face in self.faces), np.zeros(self._dim))

    @property
    def stiffness(self):
        """k A of each point (n,) [N/m]."""
        found = np.zeros(len(self.points.size))
        for face in self.faces:
            found[face.points] = face.stiffness * self.points.size[face.points]
        return found

    def at(self, face):
        """The `FacePoints` of a face, as they are now."""
        points, own = self.points, face.points
        return FacePoints(points.number[own], points.arm[own], points.area[own], points.rest[own], points.way[own],
                          points.size[own], points.normal[own])

    def forces(self, time, dt, there):
        """F (n, dim) [N] now, each by the share of a step of dt [s] from `time` [s] in which it acts; there (n,):
        whether the particle that carries a point is."""
        found = np.zeros_like(self.points.way)
        for face in self.faces:
            share = face.share(time, dt)
            if share > 0.0:
                own = self.at(face)
                found[face.points] = share * face.forces(own, own.area, own.way, face.prescribed(own, time))
        return np.where(there[:, None], found, 0.0)

    def book(self, forces, dt, pushed, way):
        """Count forces (n, dim) [N] that acted for the time `pushed` [s] in a step of dt [s] over the ways (n, dim)
        [m]."""
        for face in self.faces:
            own, given = forces[face.points], face.given
            given.force = own.sum(axis=0)
            given.impulse = given.impulse + pushed * given.force
            given.work += pushed / dt * float((own * way[face.points]).sum())

    def close(self, forces, early, late, way):
        """The same of forces (n, dim) [N] that those of the last step grew to over the ways (n, dim) [m]: those before
        act for the time `early` [s], these for `late` [s]."""
        total = np.zeros(self._dim)
        for face in self.faces:
            own, given = face.points, face.given
            now = forces[own].sum(axis=0)
            impulse = early * given.force + late * now
            given.impulse, total = given.impulse + impulse, total + impulse
            given.work += float((0.5 * (self._before[own] + forces[own]) * way[own]).sum())
            given.force = now
        self._before = forces
        return total

    # ---- history and checkpoint -----------------------------------------------------------------------------------

    def row(self):
        """Force on the body in the last step and impulse since time zero of each, by "NAME_force_x" and so on."""
        return {f"{face.name}_{what}_{axis}": float(value) for face in self.faces
                for what in ("force", "impulse")
                for axis, value in zip(AXES[self._dim], vars(face.given)[what], strict=True)}

    def units(self):
        """Unit of each of these numbers."""
        per = "/m" if self._dim == 2 else ""
        return {name: ("N s" if "_impulse_" in name else "N") + per for name in self.row()}

    def state(self):
        """All that a bitwise continuation needs, by name, as copies."""
        given = np.array([[*face.given.force, *face.given.impulse, face.given.work] for face in self.faces])
        return {"given": given, "before": self._before.copy(),
                **{name: vars(self.points)[name].copy() for name in CARRIED}}

    def restore(self, state):
        """Take over what `state()` gave."""
        for name in CARRIED:
            setattr(self.points, name, np.array(state[name]))
        self._before = np.array(state["before"])
        for face, row in zip(self.faces, state["given"], strict=True):
            face.given.force, face.given.impulse = row[: self._dim].copy(), row[self._dim : -1].copy()
            face.given.work = float(row[-1])
