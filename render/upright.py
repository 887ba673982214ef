"""Saw tests on a slope as one sees them: computed in the frame of the slope, drawn with the vertical upright."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from snowmpm.io import Run
from snowmpm.render.floor import ground_of

VECTORS = ("velocity",)
"""Fields of a frame that turn with it."""


class UprightRun(Run):
    """A saw test turned about the y axis by its slope angle, so that x rises towards where the saw goes.

    In the frame of the slope gravity is g (-sin a, 0, -cos a) (`scenes.saw_test`); turned, it points down.
    """

    def __init__(self, path):
        super().__init__(path)
        angle = np.radians(float(self.saw_test.about["slope_angle"]))
        c, s = np.cos(angle), np.sin(angle)
        self.turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    def turned(self, vectors):
        """Vectors or places (n, 3) of the slope's frame in the upright one."""
        return np.einsum("ni,ji->nj", vectors, self.turn).astype(np.asarray(vectors).dtype)

    def frame(self, i, fields=None):
        frame = super().frame(i, fields)
        values = {name: self.turned(value) if name in VECTORS and value.shape[1:] == (3,) else value
                  for name, value in frame.fields.items()}
        return replace(frame, points=self.turned(frame.points), fields=values)

    @cached_property
    def terrain(self):
        ground = ground_of(Run(self.path))
        return None if ground is None else replace(ground, vertices=self.turned(ground.vertices))

    @cached_property
    def obstacles(self):
        return {name: replace(one, rotation=self.turn @ one.rotation, translation=one.translation @ self.turn.T)
                for name, one in Run.obstacles.func(self).items()}


def upright(run):
    """An `UprightRun` of a `Run` that is a saw test on a slope, other runs as they are."""
    if isinstance(run, UprightRun) or run.saw_test is None or not run.saw_test.about.get("slope_angle"):
        return run
    return UprightRun(run.path)


def turned(run, vectors):
    """Vectors or places (n, 3) of the frame that a run was computed in, in that of its pictures."""
    return run.turned(vectors) if isinstance(run, UprightRun) else vectors
