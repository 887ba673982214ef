"""A run with what lies beyond its symmetric sides: half and quarter bodies drawn whole."""

import sys
from dataclasses import replace
from functools import cached_property

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io import Run

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


class MirroredRun(Run):
    """A run whose frames and terrain come with their images behind each `symmetric` side, two of them or four or eight
    times as many. Sides that only `slip` are walls, and have none; obstacles have none either.

    Raises InputError where the run has no symmetric side.
    """

    def __init__(self, path):
        super().__init__(path)
        self._planes = _planes(self)
        if not self._planes:
            raise InputError(f'{self.path}: nothing to mirror: no side of its domain is "symmetric"')

    def n_points(self, i):
        return 2 ** len(self._planes) * super().n_points(i)

    def frame(self, i, fields=None):
        frame = super().frame(i, fields)
        points, values = frame.points, dict(frame.fields)
        for axis, level in self._planes:
            points = np.concatenate([points, _image(points, axis, level)])
            values = {name: np.concatenate([value, _turned(value, axis) if name == "velocity" else value])
                      for name, value in values.items()}
        return replace(frame, points=points, fields=values)

    @cached_property
    def terrain(self):
        terrain = Run.terrain.func(self)
        for axis, level in self._planes if terrain is not None else ():
            n = len(terrain.vertices)
            terrain = replace(
                terrain, vertices=np.concatenate([terrain.vertices, _image(terrain.vertices, axis, level)]),
                facets=np.concatenate([terrain.facets, terrain.facets[:, ::-1] + n]))
        return terrain


def _planes(run):
    """(axis of space, place along it [m, to the run's origin]) of the symmetric sides of a run's scene."""
    try:
        scene = tomllib.loads(run.provenance.get("scene", ""))
        domain = scene.get("domain", {})
        lower, upper, sides = domain.get("min"), domain.get("max"), domain.get("boundary", {})
        axes = "xz" if scene["dimension"] == 2 else "xyz"
        sides = sides if isinstance(sides, dict) else {f"{a}_{end}": sides for a in axes for end in ("min", "max")}
        return [("xyz".index(a), float(ends[k]) - float(run.origin["xyz".index(a)]))
                for k, a in enumerate(axes) for end, ends in (("min", lower), ("max", upper))
                if sides.get(f"{a}_{end}") == "symmetric" and ends is not None]
    except (tomllib.TOMLDecodeError, KeyError, TypeError, ValueError, IndexError, AttributeError):
        raise InputError(f"{run.path}: says nothing readable of the sides of its domain") from None


def _image(points, axis, level):
    image = points.copy()
    image[:, axis] = 2.0 * level - image[:, axis]
    return image


def _turned(velocity, axis):
    turned = velocity.copy()
    turned[:, axis] *= -1.0
    return turned
