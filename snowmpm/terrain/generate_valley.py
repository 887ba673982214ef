"""The elevation raster and release area of the scene library: `python -m snowmpm.terrain.generate_valley FOLDER`."""

import json
import sys
from pathlib import Path

import numpy as np

from snowmpm.terrain.generate import smooth_step

CELL = 10.0  # m
COLUMNS, ROWS = 96, 52  # along x (down the valley) and y
CORNER = (600_000.0, 200_000.0)  # m: map coordinates of the lower left corner
NO_DATA = -9999.0
THICKNESS = 1.5  # m, normal to the slope
RELEASE = [(110.0, 190.0), (150.0, 170.0), (230.0, 185.0), (260.0, 240.0), (235.0, 330.0), (150.0, 345.0),
           (115.0, 300.0)]
"""Corners of the release area [m], relative to CORNER."""


def valley():
    """Heights [m] (ROWS, COLUMNS), first row in the south: a bowl of 35 degrees, a channel of 28, a fan of 8 to 3.

    The corners of the map are no-data, as those of real rasters are.
    """
    x = (np.arange(COLUMNS) + 0.5) * CELL
    y = (np.arange(ROWS) + 0.5) * CELL
    fine = np.linspace(0.0, COLUMNS * CELL, 4801)
    dip = 37.0 - 9.0 * smooth_step((fine - 250.0) / 150.0) - 20.0 * smooth_step((fine - 470.0) / 120.0)
    dip -= 5.0 * smooth_step((fine - 620.0) / 180.0)
    slope = np.tan(np.radians(dip))
    drop = np.r_[0.0, np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(fine))]
    middle = 1600.0 - np.interp(x, fine, drop)
    xx, yy = np.meshgrid(x, y)
    across = yy - 260.0 - 35.0 * np.sin(2.0 * np.pi * xx / 700.0) * smooth_step((xx - 150.0) / 150.0)
    inside = 1.0 - smooth_step((xx - 560.0) / 200.0)
    channel = 16.0 * smooth_step((xx - 180.0) / 150.0) * np.exp(-((across / 60.0) ** 2))
    trough = 0.0016 * across**2 * inside - inside * channel
    life = 1.5 * np.sin(xx / 37.0 + 0.6) * np.cos(yy / 29.0) + 0.8 * np.sin(xx / 17.0 - yy / 23.0)
    heights = middle[None, :] + trough + life * (0.3 + 0.7 * inside)
    far = np.hypot((xx - xx.mean()) / xx.mean(), (yy - yy.mean()) / yy.mean())
    return np.where(far > 1.32, NO_DATA, heights)


def write(folder):
    """Write valley.asc (ESRI ASCII grid) and valley_release.geojson into a folder."""
    header = (f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {CORNER[0]:.1f}\nyllcorner {CORNER[1]:.1f}\n"
              f"cellsize {CELL:.1f}\nNODATA_value {NO_DATA:.0f}\n")
    rows = "\n".join(" ".join("-9999" if h == NO_DATA else f"{h:.2f}" for h in row) for row in valley()[::-1])
    (Path(folder) / "valley.asc").write_text(header + rows + "\n", encoding="ascii")
    ring = [[CORNER[0] + x, CORNER[1] + y] for x, y in [*RELEASE, RELEASE[0]]]
    feature = {"type": "Feature", "properties": {"name": "bowl", "thickness": THICKNESS},
               "geometry": {"type": "Polygon", "coordinates": [ring]}}
    text = json.dumps({"type": "FeatureCollection", "features": [feature]}, indent=1)
    (Path(folder) / "valley_release.geojson").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    write(sys.argv[1])
