"""A run with what lies beyond its symmetric sides: half and quarter bodies drawn whole."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.domain_box import DomainBox


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
    box = DomainBox.of(run)
    return [("xyz".index(axis), corner[axis]) for axis in box.lower
            for end, corner in (("min", box.lower), ("max", box.upper))
            if box.sides.get(f"{axis}_{end}") == "symmetric"]


def _image(points, axis, level):
    image = points.copy()
    image[:, axis] = 2.0 * level - image[:, axis]
    return image


def _turned(velocity, axis):
    turned = velocity.copy()
    turned[:, axis] *= -1.0
    return turned
