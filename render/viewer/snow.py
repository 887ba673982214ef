"""The snow of an interactive page: cells of it in every frame, as small as a page that travels allows."""

import numpy as np

from snowmpm.render.surface_points import SurfacePoints, surface_points
from snowmpm.render.view import particle_spacing, piled
from snowmpm.render.viewer.packing import Parts, in_box

COARSEST = 8.0  # particle spacings: side of the cells that stand for the snow, at most
FINEST = 1.15
SAMPLED = 4  # frames whose size tells that of all


class Snow:
    """The frames `chosen` of a `run_film` view as cells of a side `cell` [m], with the shares of `fields`."""

    def __init__(self, view, fields, chosen):
        self.view, self.fields, self.chosen = view, fields, chosen
        self.flat = view.run.dimension == 2
        self.cell = FINEST * view.spacing

    def frame(self, i):
        """`SurfacePoints` of frame `i`, values (n, fields); in space those within the snow too."""
        run = self.view.run
        names = dict.fromkeys(name for field in self.fields for name in field.needs)
        if "depth" in run.field_names:
            names["depth"] = None
        frame = run.frame(i, names)
        shares = np.stack([np.zeros(len(frame)), *(field.share(frame) for field in self.fields)], axis=-1)[:, 1:]
        points = frame.points
        if "depth" in frame.fields and not self.flat:
            points, shares = piled(points, frame.fields["depth"].ravel(), particle_spacing(run, frame.time), shares)
        return surface_points(points, shares, self.cell, self.flat, within=not self.flat)

    def fit(self, points, letters):
        """Choose cells with which all frames have at most so many points, and letters of a page."""
        sample = [int(i) for i in self.chosen[:: max(1, len(self.chosen) // SAMPLED)]]
        while self.cell < COARSEST * self.view.spacing:
            excess = 0.0
            for found in map(self.frame, sample):
                share = len(self.chosen) / len(sample)
                excess = excess + share * np.array([len(found.points) / points, _letters(found) / letters])
            if (excess <= 1.0).all():
                break
            # Between the square of the cell, of a surface, and its cube, of what lies within
            self.cell *= max(1.06, 0.98 * float(np.max(excess)) ** 0.4)


def clipped(found, low, high):
    """The cells of `SurfacePoints` in the box from `low` to `high`."""
    inside = ((found.points >= low) & (found.points <= high)).all(axis=1)
    seen = inside[: len(found.normals)]
    return SurfacePoints(found.points[inside], found.normals[seen], found.values[inside])


def add_snow(parts, k, found, low, span):
    """Add `SurfacePoints` as frame `k` to `Parts`; -> numbers of its surface points and of all."""
    parts.add(f"snow.{k}.place", in_box(found.points, low, span))
    parts.add(f"snow.{k}.normal", np.round(127 * found.normals).astype(np.int8))
    for j in range(found.values.shape[1]):
        parts.add(f"snow.{k}.value.{j}", np.round(255 * found.values[:, j]).astype(np.uint8))
    return [len(found.normals), len(found.points)]


def _letters(found):
    """Letters that a frame takes in a page."""
    if not len(found.points):
        return 0
    low, parts = found.points.min(axis=0), Parts()
    add_snow(parts, 0, found, low, np.maximum(np.ptp(found.points, axis=0), 1e-6))
    return len(parts.text())
