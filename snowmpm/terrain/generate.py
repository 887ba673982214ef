"""The avalanche slope of the scene library: `python -m snowmpm.terrain.generate slope.stl` writes it again."""

import sys

import numpy as np
import trimesh

LENGTH, WIDTH = 60.0, 26.0  # m, plan: down the slope (x), across (y)
CELL = 0.5  # m
STEEP, FLAT = np.radians(39.0), np.radians(3.0)  # dip of the release area and of the run-out
BEND = (30.0, 47.0)  # m: where the dip changes from the one to the other
AXIS = 13.0  # m: y of the middle line


def slope_mesh():
    """A slope of 60 m by 26 m: open release area of about 39 degrees, gully, bend, run-out of 13 m at 3 degrees.

    x points down the slope, the run-out ends at height zero on the middle line. All relief is smooth: the shallow bowl
    of the release area narrows into a gully 1.1 m deep that fades out in the bend; low ribs give the surface life.
    """
    x = np.arange(0.0, LENGTH + 0.5 * CELL, CELL)
    y = np.arange(0.0, WIDTH + 0.5 * CELL, CELL)
    xx, yy = np.meshgrid(x, y, indexing="ij")
    zz = _middle_line(x)[:, None] + _relief(xx, yy)
    number = np.arange(xx.size).reshape(xx.shape)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    # Diagonals alternate like a chess board, so that none of the two directions leaves a grain in the ground.
    black = ((np.arange(len(x) - 1)[:, None] + np.arange(len(y) - 1)) % 2 == 0).ravel()
    one = np.where(black[:, None], np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    two = np.where(black[:, None], np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    vertices = np.column_stack([xx.ravel(), yy.ravel(), zz.ravel()])
    return trimesh.Trimesh(vertices, np.concatenate([one, two]), process=False)


def smooth_step(t):
    """0 below t = 0, 1 above t = 1, twice continuously differentiable between."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 + t * (6.0 * t - 15.0))


def _middle_line(x):
    """Height [m] of the middle line: the dip integrated from the lower end, by the trapezoidal rule on a fine grid."""
    fine = np.linspace(0.0, LENGTH, 6001)
    dip = STEEP + (FLAT - STEEP) * smooth_step((fine - BEND[0]) / (BEND[1] - BEND[0]))
    drop = np.r_[0.0, np.cumsum(0.5 * (np.tan(dip[1:]) + np.tan(dip[:-1])) * np.diff(fine))]
    return np.interp(x, fine, drop[-1] - drop)


def _relief(x, y):
    """Height [m] above the middle line."""
    across = y - AXIS - 1.2 * np.sin(2.0 * np.pi * x / 55.0) * smooth_step(x / 15.0)
    fade = 1.0 - smooth_step((x - 34.0) / 14.0)
    bowl = 0.01 * across**2 * fade
    gully_depth = 1.1 * smooth_step((x - 12.0) / 12.0) * fade
    gully = -gully_depth * np.exp(-0.5 * (across / 2.6) ** 2)
    ribs = 0.14 * np.sin(0.62 * y + 0.21 * x + 0.7) * np.cos(0.33 * x - 0.17 * y)
    ribs += 0.07 * np.sin(0.95 * y + 0.45 * x + 2.1)
    return bowl + gully + ribs * (0.35 + 0.65 * fade)


if __name__ == "__main__":
    slope_mesh().export(sys.argv[1], file_type="stl")
