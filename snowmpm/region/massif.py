"""A made-up massif of any size, as an elevation raster.

    python -m snowmpm.region.massif FILE.tif --side 6000

Ridges and valleys of many sizes from gradient noise (Perlin, 1985, doi:10.1145/325165.325247) whose absolute value has
sharp crests (ridged noise; Musgrave et al., 1989, doi:10.1145/74334.74337), with flat valley floors. Heights are a
function of the place alone, so that parts of it fit together.
"""

import argparse
import math
from pathlib import Path

import numpy as np

from snowmpm.draft import draft
from snowmpm.io.geotiff import require_rasterio

CORNER = 600_000.0, 200_000.0
"""Map coordinates [m] of the lower left corner."""
SYSTEM = "EPSG:21781"
BLOCK = 512
"""Side of the blocks of the file [cells]."""
WAVES = ((9000.0, 700.0), (4200.0, 400.0), (1900.0, 150.0), (830.0, 48.0), (370.0, 15.0), (160.0, 4.0))
"""Wavelength and height [m] of each size of ridge."""
FLOOR, SOFT = 900.0, 60.0
"""Height [m] of the valley floors, and over how much of it slopes run out into them."""
RIDGED = 4
"""Sizes with crests; smaller ones are bumps."""


def heights(x, y, seed=1):
    """Heights [m] at map coordinates x, y [m], arrays of one shape."""
    total, rough = np.full(np.shape(x), 350.0), 1.0
    for k, (length, height) in enumerate(WAVES):
        noise = _noise(x / length + 17.3 * k, y / length - 11.9 * k, seed + k)
        if k < RIDGED:
            crest = (1.0 - np.abs(noise)) ** 2
            total += height * rough * crest
            rough = np.clip(0.25 + crest, 0.0, 1.0)  # small ridges where the large ones are high
        else:
            total += height * rough * noise
    return FLOOR + SOFT * np.logaddexp(0.0, (total - FLOOR) / SOFT) + 0.01 * np.hypot(x - CORNER[0], y - CORNER[1])


def _noise(x, y, seed):
    """Gradient noise of wavelength 1, about -1 to 1."""
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    u, v = x - i, y - j
    corners = [[_gradient(i + a, j + b, seed, u - a, v - b) for b in (0, 1)] for a in (0, 1)]
    u, v = (t**3 * (t * (6.0 * t - 15.0) + 10.0) for t in (u, v))
    low, high = (side[0] + v * (side[1] - side[0]) for side in corners)
    return 1.5 * (low + u * (high - low))


def _gradient(i, j, seed, u, v):
    """Product of the gradient at a corner of the lattice and the way from it."""
    i, j = i.astype(np.uint64), j.astype(np.uint64)
    mixed = (i * np.uint64(0x9E3779B97F4A7C15)) ^ (j * np.uint64(0xC2B2AE3D27D4EB4F))
    mixed ^= np.uint64((seed * 0x165667B19E3779F9) % 2**64)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    mixed ^= mixed >> np.uint64(32)
    angle = (mixed & np.uint64(0xFFFF)).astype(float) * (2.0 * math.pi / 65536.0)
    return np.cos(angle) * u + np.sin(angle) * v


def write(path, side=30_000.0, cell=5.0, seed=1):
    """Write a massif of `side` by `side` [m] in cells [m] as a GeoTIFF in blocks; -> its path. Raises InputError
    without rasterio."""
    rasterio = require_rasterio()
    n = round(side / cell)
    north = CORNER[1] + n * cell
    profile = {"driver": "GTiff", "width": n, "height": n, "count": 1, "dtype": "float32", "nodata": -9999.0,
               "transform": rasterio.transform.from_origin(CORNER[0], north, cell, cell), "crs": SYSTEM,
               "tiled": True, "blockxsize": BLOCK, "blockysize": BLOCK, "compress": "deflate", "predictor": 3}
    with draft(path) as part, rasterio.open(part, "w", **profile) as file:
        for _, window in file.block_windows(1):
            x = CORNER[0] + cell * (window.col_off + np.arange(window.width) + 0.5)
            y = north - cell * (window.row_off + np.arange(window.height) + 0.5)
            file.write(heights(*np.meshgrid(x, y), seed).astype(np.float32), 1, window=window)
    return path


def main():
    """Write a massif, as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--side", type=float, default=30_000.0, help="m")
    parser.add_argument("--cell", type=float, default=5.0, help="m")
    parser.add_argument("--seed", type=int, default=1)
    choice = parser.parse_args()
    write(choice.file, choice.side, choice.cell, choice.seed)


if __name__ == "__main__":
    main()
