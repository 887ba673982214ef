"""What is exported of a run: its snow in each chosen frame, its ground, its obstacles."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render.export.snow_surface import require_splashsurf, snow_surface
from snowmpm.render.view import particle_spacing, piled

IDENTITY = "id"
"""Field with the number of each particle."""
RIBBON = 20.0
"""Width of a section in plane strain, in particle spacings: lines of its ground become strips."""


@dataclass(frozen=True)
class Shape:
    """points (n, 3) [m] float32; faces (m, 3) of a mesh, or None of particles; fields (n,) or (n, k) by name; radius
    [m] of a particle; numbers (n,) of the particles, ascending, or None where they have none."""

    points: np.ndarray
    faces: np.ndarray | None
    fields: dict[str, Any]
    radius: float = 0.0
    numbers: np.ndarray | None = None


class Sequence:
    """Frames of a run.

    name, origin (3,) [m] in map coordinates, indices of the frames, times [s], seconds of film; identified: whether
    its particles keep their numbers and their order from frame to frame.
    """

    def __init__(self, run, *, surface=False, fields=None, every=1, speed=1.0, fps=25.0):
        if not len(run):
            raise InputError(f"{run.path}: no frames yet")
        if surface:
            require_splashsurf()
        for name in fields or ():
            if name not in run.field_names:
                raise InputError.not_in("--fields", name, run.field_names, file=run.path)
        self.run, self.name, self.origin = run, run.name, run.origin
        self.fps, self.speed = fps, speed
        self._surface = surface
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
        extra = [*(["depth"] if in_plan else []), *([IDENTITY] if self.identified else [])]
        frame = self.run.frame(i, dict.fromkeys([*self._names, *extra]))
        spacing = particle_spacing(self.run, frame.time)
        good = np.flatnonzero(np.isfinite(frame.points).all(axis=1))
        # A run file holds particles in the order of its blocks, which changes as they move
        kept = good[np.argsort(frame.fields[IDENTITY][good], kind="stable")] if self.identified else good
        points, fields = frame.points[kept], {name: frame.fields[name][kept] for name in self._names}
        if in_plan:
            points, *values = piled(points, frame.fields["depth"][good], spacing, *fields.values())
            fields = dict(zip(fields, values, strict=True))
        points = np.ascontiguousarray(points, np.float32)
        if not self._surface:
            numbers = frame.fields[IDENTITY][kept] if self.identified else None
            return Shape(points, None, fields, 0.5 * spacing, numbers)
        return Shape(*snow_surface(points, spacing, fields, flat=self.run.dimension == 2))

    def ground(self):
        """`Shape` of the ground, None without."""
        terrain = self.run.terrain
        return None if terrain is None else self._mesh(terrain.vertices, terrain.facets)

    def obstacles(self, i):
        """`Shape`s of the obstacles in frame `i`, by name."""
        return {name: self._mesh(one.placed(i), one.facets) for name, one in self.run.obstacles.items()}

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
