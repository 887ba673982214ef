"""The thalweg of one run on real terrain, along which runs are compared."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Way:
    """points (n, 2) [m] in plan, map coordinates; s (n,): length along them from the release's top; z (n,): height of
    the ground there [m]."""

    points: np.ndarray
    s: np.ndarray
    z: np.ndarray

    @classmethod
    def of(cls, run):
        """The thalweg of a `snowmpm.io.Run`; None of a run that has none."""
        found = run.hazard.get("profile") or {}
        if not {"x", "y", "z", "s"} <= found.keys():
            return None
        x, y, z, s = (np.asarray(found[name], float) for name in ("x", "y", "z", "s"))
        known = np.isfinite(z)
        return cls(np.column_stack([x, y])[known], s[known], z[known]) if known.sum() > 1 else None

    def strip(self, positions, width):
        """Which of the positions (n, 3) [m] lie within `width` [m] of the way, beside it and not beyond its ends; of
        these, s and height above its ground (k,) [m]."""
        import shapely

        line, places = shapely.LineString(self.points), shapely.points(positions[:, :2])
        along = shapely.line_locate_point(line, places)
        near = (shapely.distance(line, places) < width) & (along > 0.0) & (along < line.length)
        s = self.s[0] + along[near] * (self.s[-1] - self.s[0]) / line.length
        return near, s, positions[near, 2] - np.interp(s, self.s, self.z)
