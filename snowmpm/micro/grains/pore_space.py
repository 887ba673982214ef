"""The pores between the grains of a periodic cell as voxels, and their permeability as the cell is now."""

import numpy as np
from scipy.spatial import cKDTree

from snowmpm.micro.permeability import permeability


def voxels(cell, count):
    """Pores (nx, ny, nz) of an `Assembly`, True outside the grains, `count` voxels along x; side of a voxel [m]; slide
    (2,): shift of the image above, in voxels along x and y.

    Sides and slide are those of the cell to half a voxel.
    """
    side = cell.box[0] / count
    shape = np.maximum(1, np.round(cell.box / side)).astype(int)
    axes = [(np.arange(n) + 0.5) * length / n for n, length in zip(shape, cell.box, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    pores = np.ones(len(points), bool)
    tree = cKDTree(points)
    for middle, radius in zip(*_with_images(cell), strict=True):
        pores[tree.query_ball_point(middle, radius)] = False
    return pores.reshape(shape), float(side), np.round(cell.slide / side).astype(int)


def cell_permeability(cell, count, axes=(2, 0), tolerance=1e-3):
    """Permeabilities [m2] of an `Assembly` from its voxels, along axes: (2, 0) is along and across a layer's normal.

    Spheres of R voxels: 10 % too small or large for R = 3, 3 % for R = 13 (docs/micro.md).
    """
    pores, side, slide = voxels(cell, count)
    return np.diag(permeability(pores, side, axes, tolerance=tolerance, slide=slide).tensor)[list(axes)]


def _with_images(cell):
    """Middles (k, 3) and radii (k,) of the grains and of their images that reach into the cell."""
    at = np.array(cell.positions)
    over = np.floor(at[:, 2] / cell.box[2])
    at -= over[:, None] * np.array([*cell.slide, cell.box[2]])
    at[:, :2] -= np.floor(at[:, :2] / cell.box[:2]) * cell.box[:2]
    middles, radii = [], []
    for k in (-1, 0, 1):
        row = at + k * np.array([*cell.slide, cell.box[2]])
        row[:, :2] -= np.floor(row[:, :2] / cell.box[:2]) * cell.box[:2]
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                there = row + np.array([i * cell.box[0], j * cell.box[1], 0.0])
                reach = cell.radii[:, None]
                near = ((there > -reach) & (there < cell.box + reach)).all(axis=1)
                middles.append(there[near])
                radii.append(cell.radii[near])
    return np.concatenate(middles), np.concatenate(radii)
