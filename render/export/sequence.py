"""What is exported of a run: its snow in each chosen frame, its ground, its obstacles, the camera of its film."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render.cinema.solids import edged
from snowmpm.render.floor import ground_of
from snowmpm.render.run_film import view_of
from snowmpm.render.snow_surface import snow_surface
from snowmpm.render.upright import UprightRun, turned
from snowmpm.render.view import particle_spacing, piled

IDENTITY = "id"
"""Field with the number of each particle."""
VELOCITY = "velocity"
RIBBON = 20.0
"""Width of a section in plane strain, in particle spacings: lines of its ground become strips."""


@dataclass(frozen=True)
class Shape:
    """points (n, 3) [m] float32; faces (m, 3) of a mesh, or None of particles; fields (n,) or (n, k) by name; radius
    [m] of a particle; numbers (n,) of the particles, ascending, or None where they have none; velocity (n, 3) [m/s] of
    the snow, or None where the run did not record it; st (n, 2) and picture: as of `Skin`, None of others."""

    points: np.ndarray
    faces: np.ndarray | None
    fields: dict[str, Any]
    radius: float = 0.0
    numbers: np.ndarray | None = None
    velocity: np.ndarray | None = None
    st: np.ndarray | None = None
    picture: np.ndarray | None = None


class Sequence:
    """Frames of a run.

    name, origin (3,) [m] in map coordinates, indices of the frames, times [s], seconds of film; identified: whether
    its particles keep their numbers and their order from frame to frame. film: size, camera and camera_path of its
    film, as of `render_run`.
    """

    def __init__(self, run, *, surface=False, fields=None, every=1, speed=1.0, fps=25.0, film=None):
        if not len(run):
            raise InputError(f"{run.path}: no frames yet")
        for name in fields or ():
            if name not in run.field_names:
                raise InputError.not_in("--fields", name, run.field_names, file=run.path)
        self.run, self.name, self.origin = run, run.name, run.origin
        self.fps, self.speed = fps, speed
        self._surface, self._film = surface, film or {}
        self.identified = not surface and IDENTITY in run.field_names and "depth" not in run.field_names
        self._names = list(run.field_names if fields is None else fields)
        self.indices = range(0, len(run), every)

    @property
    def times(self):
        """Simulated seconds of the frames (k,)."""
        return self.run.times[self.indices.start : self.indices.stop : self.indices.step]

    @property
    def units(self):
        """Unit of each field by name."""
        return {name: self.run.units.get(name, "") for name in self._names}

    def snow(self, i):
        """`Shape` of the snow in frame `i`."""
        in_plan = "depth" in self.run.field_names
        moving = VELOCITY in self.run.field_names
        extra = [*(["depth"] if in_plan else []), *([IDENTITY] if self.identified else []),
                 *([VELOCITY] if moving else [])]
        frame = self.run.frame(i, dict.fromkeys([*self._names, *extra]))
        spacing = particle_spacing(self.run, frame.time)
        good = np.flatnonzero(np.isfinite(frame.points).all(axis=1))
        # A run file holds particles in the order of its blocks, which changes as they move
        kept = good[np.argsort(frame.fields[IDENTITY][good], kind="stable")] if self.identified else good
        points = frame.points[kept]
        # The velocity last, for the blur of what moves, whether or not it is wished for as a field
        names = [*self._names, *([VELOCITY] if moving and VELOCITY not in self._names else [])]
        fields = {name: frame.fields[name][kept] for name in names}
        if in_plan:
            points, *values = piled(points, frame.fields["depth"][good], spacing, *fields.values())
            fields = dict(zip(fields, values, strict=True))
        points = np.ascontiguousarray(points, np.float32)
        faces = None
        if self._surface:
            points, faces, fields = snow_surface(points, spacing, fields, flat=self.run.dimension == 2)
        velocity = fields.get(VELOCITY)
        fields = {name: fields[name] for name in self._names}
        if self._surface:
            return Shape(points, faces, fields, velocity=velocity)
        numbers = frame.fields[IDENTITY][kept] if self.identified else None
        return Shape(points, None, fields, 0.5 * spacing, numbers, velocity)

    def ground(self):
        """`Shape` of the ground that the film shows, None without."""
        terrain = ground_of(self.run)
        return None if terrain is None else self._mesh(terrain.vertices, terrain.facets)

    def obstacles(self, i):
        """`Shape`s of the obstacles in frame `i`, by name."""
        return {name: self._mesh(one.placed(i), one.facets) for name, one in self.run.obstacles.items()}

    def solids(self):
        """By name of each obstacle, or of each part with a material: its `Shape` where the scene draws it, with
        vertices of their own on each side of a sharp edge, and its poses in the frames, (rotation (k, 3, 3),
        translation (k, 3)), None where it stays."""
        found = {}
        for name, one in self.run.obstacles.items():
            rotation, translation = (part[self.indices.start : self.indices.stop : self.indices.step]
                                     for part in (one.rotation, one.translation))
            moves = np.any(rotation != np.eye(3)) or np.any(translation != 0.0)
            plain = self._mesh(one.vertices, one.facets)
            parts = {f"{name}_{k}": (skin.vertices, skin.facets, skin.st, skin.picture)
                     for k, skin in enumerate(one.skins)} or {name: (plain.points, plain.faces, None, None)}
            for part, (points, faces, st, picture) in parts.items():
                points, faces, *places = edged(np.asarray(points), np.asarray(faces), *([] if st is None else [st]))
                shape = Shape(points.astype(np.float32), faces.astype(np.int32), {}, st=next(iter(places), None),
                              picture=picture)
                found[part] = shape, (rotation, translation) if moves else None
        return found

    @cached_property
    def view(self):
        """The view of the film, of which nothing is drawn."""
        film = {"size": (1280, 720), "camera": None, "camera_path": None} | self._film
        return view_of(self.run, film["size"], "snow", film["camera"], camera_path=film["camera_path"], drawn=False)

    @property
    def turn(self):
        """(3, 3) from the frame of the run to that of its film, z up; None where they are the same."""
        return self.view.run.turn if isinstance(self.view.run, UprightRun) else None

    def upright(self, points):
        """Places (n, 3) of the run in the frame of its film."""
        return turned(self.view.run, np.asarray(points, float))

    def _mesh(self, vertices, facets):
        vertices, facets = np.asarray(vertices, np.float32), np.asarray(facets, np.int32)
        if facets.shape[1] == 3:
            return Shape(vertices, facets, {})
        half = 0.5 * RIBBON * particle_spacing(self.run)
        n, sides = len(vertices), np.repeat(vertices[None], 2, axis=0)
        sides[0, :, 1], sides[1, :, 1] = -half, half
        a, b = facets.T
        faces = np.concatenate([np.column_stack([a, b, b + n]), np.column_stack([a, b + n, a + n])])
        return Shape(sides.reshape(-1, 3), faces.astype(np.int32), {})
