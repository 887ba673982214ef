"""A made-up avalanche path as files in map coordinates, whose volumes and run-outs can be computed beside the program.

Along x a parabola that is level beyond the foot, across y a shallow gully:

    z = FLOOR + STEEPNESS max(0, FOOT - x)^2 + HOLLOW y^2        x, y from the corner and from the middle line

A path of another size has all lengths in plan and its heights in proportion.

The raster has no data beyond a slanted strip, as a survey of one path has. The release is an ellipse with its thickness
as an attribute.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from scipy.integrate import solve_ivp

CORNER = np.array([247_600.0, 351_850.0])
"""Of the raster, in map coordinates [m]."""
CELL, COLUMNS, ROWS = 5.0, 200, 100
FLOOR, STEEPNESS, FOOT = 900.0, 0.0008, 500.0
MIDDLE = 0.5 * CELL * ROWS
THICKNESS = 1.2
G = 9.81


@dataclass(frozen=True)
class MadePath:
    """Files of a path in a folder. hollow: HOLLOW [1/m], 0 for a straight chute; size: of all lengths."""

    dem: Path
    release: Path
    hollow: float
    size: float

    def release_area(self):
        """Area of the release along the ground [m2], by midpoints of squares of half a metre."""
        outline = release_outline(self.size)
        x0, y0, x1, y1 = outline.bounds
        x, y = np.meshgrid(np.arange(x0, x1, 0.5) + 0.25, np.arange(y0, y1, 0.5) + 0.25)
        inside = shapely.contains_xy(outline, x, y)
        x, y = x[inside], y[inside]
        along = -2.0 * STEEPNESS * np.maximum(0.0, FOOT - (x - CORNER[0]) / self.size)
        across = 2.0 * self.hollow * ((y - CORNER[1]) / self.size - MIDDLE)
        return 0.25 * np.sqrt(1.0 + along**2 + across**2).sum()


def release_outline(size=1.0):
    """An ellipse of 90 by 60 m below the top of the path, in map coordinates."""
    angle = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
    x, y = 110.0 + 45.0 * np.cos(angle), MIDDLE + 30.0 * np.sin(angle)
    return shapely.Polygon(CORNER + size * np.stack([x, y], axis=-1))


def write_path(folder, hollow=0.001, size=1.0):
    """Write path.asc and release.shp; -> `MadePath`. Needs the extra `gis`."""
    import shapefile

    x, y = CELL * (np.arange(COLUMNS) + 0.5), CELL * (np.arange(ROWS) + 0.5)
    z = FLOOR + size * (STEEPNESS * np.maximum(0.0, FOOT - x) ** 2 + hollow * (y[:, None] - MIDDLE) ** 2)
    z[np.abs(y[:, None] - MIDDLE - 0.04 * (x - 500.0)) > 0.59 * MIDDLE] = -9999.0
    folder.mkdir(parents=True, exist_ok=True)
    dem, release = folder / "path.asc", folder / "release.shp"
    head = (f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {CORNER[0]}\nyllcorner {CORNER[1]}\ncellsize {size * CELL}\n"
            "NODATA_value -9999\n")
    dem.write_text(head + "\n".join(" ".join(f"{value:.6f}" for value in row) for row in z[::-1]) + "\n")
    with shapefile.Writer(str(release)) as writer:
        writer.field("thickness", "N", size=11, decimal=3)
        writer.poly([[list(point) for point in release_outline(size).exterior.coords[::-1]]])
        writer.record(THICKNESS)
    return MadePath(dem, release, hollow, size)


def block_runout(start, friction, centrifugal=True):
    """x at which a block stops that is let go at x = start, from the corner [m]: dv/dt = g sin - mu (g cos + kappa
    v^2) along the parabola, kappa its curvature, 0 without the centrifugal term."""
    def rates(_, state):
        fall = 2.0 * STEEPNESS * max(0.0, FOOT - state[0])
        cosine = 1.0 / np.sqrt(1.0 + fall**2)
        curvature = 2.0 * STEEPNESS * cosine**3 if centrifugal and state[0] < FOOT else 0.0
        return [state[1] * cosine, G * fall * cosine - friction * (G * cosine + curvature * state[1] ** 2)]

    def stopped(_, state):
        return state[1]

    stopped.terminal, stopped.direction = True, -1
    way = solve_ivp(rates, (0.0, 300.0), [start, 1e-9], rtol=1e-9, atol=1e-9, max_step=0.1, events=stopped)
    return float(way.y[0, -1])
