"""A cell of bonded grains, such as snow: grains stick where they touch while the cell is compressed, then sinter."""

from dataclasses import replace

import numpy as np

from snowmpm.micro.grains.assembly import Assembly

START = 0.1
"""Solid fraction of the scattered grains."""

STRAIN = 6e-5
"""Strain of a step while the cell is compressed: overlaps of collisions are then about a hundredth of a radius."""

REST = 3000
"""Steps for the motion to die down."""

TRIES = 10_000


def bonded_cell(count, radius, law, solid=0.22, seed=1, spread=0.2, density=917.0):
    """`Assembly` of bonded grains, free of stress and at rest.

    Grains are scattered without overlap, and the cell is compressed alike along its axes to the solid fraction `solid`;
    grains that touch stick. Then bonds are relaxed (`Assembly.bond`) and get their strength. count: number of grains;
    radius [m]: mean; spread: half width of the uniform distribution of radii, relative; density of the grains [kg/m3].
    Raises ValueError for a solid fraction out of range.
    """
    if not START < solid <= 0.6:
        raise ValueError(f"solid = {solid!r}: must be above {START} and at most 0.6")
    rng = np.random.default_rng(seed)
    radii = radius * rng.uniform(1.0 - spread, 1.0 + spread, count)
    positions, box = scattered(radii, START, rng)
    cell = Assembly(positions, radii, replace(law, strength=np.inf, shear_strength=np.inf, damping=0.5), density,
                    box=box)
    cell.damping = 0.01 / cell.dt
    steps = int(np.ceil(np.log(solid / START) / 3.0 / STRAIN))
    cell.rates[:] = -np.log(solid / START) / 3.0 / (steps * cell.dt)
    for _ in range(steps // 10):
        cell.step(10)
        cell.bond()
    cell.rates[:] = 0.0
    cell.step(REST)
    cell.bond(relaxed=True)
    cell.law, cell.deformation = law, np.eye(3)
    cell.velocities[:], cell.spins[:], cell.damping = 0.0, 0.0, 0.0
    cell.step()
    return cell


def scattered(radii, solid, rng):
    """Positions (n, 3) without overlap in a periodic cube, and its sides (3,): one grain after the other at random.
    Raises ValueError where one finds no place."""
    side = float((4.0 / 3.0 * np.pi * (radii**3).sum() / solid) ** (1.0 / 3.0))
    at = np.zeros((len(radii), 3))
    for i, radius in enumerate(radii):
        for _ in range(TRIES):
            at[i] = rng.uniform(0.0, side, 3)
            way = at[:i] - at[i]
            way -= side * np.round(way / side)
            if ((way**2).sum(axis=1) > (radii[:i] + radius) ** 2).all():
                break
        else:
            raise ValueError(f"grain {i + 1} of {len(radii)} finds no place at a solid fraction of {solid:g}")
    return at, np.full(3, side)
