"""An elastic block of snow that settles under its weight in a smooth box turned about two axes (M5 in space)."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from snowmpm.particles.population import Population
from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion
from snowmpm.solids.primitives import BOX
from snowmpm.solids.shape import SolidShape
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, lattice
from snowmpm.study.problems.self_weight_column import SNOW, G, exact_height, settle

WIDTH, HEIGHT, DX = 4, 8, 0.3125
"""Of the block [cells], and a cell [m]."""


def wall(face, normal, axes):
    """A block with a smooth side of this normal through the point `face`, its edges along `axes`."""
    across = axes[np.argmin(np.abs(axes @ normal))]
    half = 3.0 * HEIGHT * DX
    middle = face - half * normal
    frame = np.array([across, np.cross(normal, across), normal])
    return Obstacle("block", SolidShape(BOX, middle, frame, np.full(3, half)), RigidMotion(middle, None), "slip", 0.0)


def settled(*degrees):
    """Turned by these angles about y, then x: mean error of the height of the top over the settlement, largest error of
    the stresses of each particle over the pressure at the base, and its distance from the nearest wall [cells]."""
    axes = Rotation.from_euler("yx", degrees, degrees=True).as_matrix().T
    right, deep, up = axes
    length = HEIGHT * DX
    x, volumes = lattice([0.0] * 3, [WIDTH * DX, WIDTH * DX, length], DX, 4)
    base = np.array([0.37, 0.61, 0.23]) * DX
    foot = base + 0.5 * WIDTH * DX * (right + deep)
    walls = [wall(foot, up, axes)]
    walls += [wall(foot + 0.5 * (WIDTH * DX * side * across + length * up), -side * across, axes)
              for across in (right, deep) for side in (1, -1)]
    corners = base + x @ axes
    lower, upper = corners.min(axis=0) - 4 * DX, corners.max(axis=0) + 4 * DX
    solver = replace(APIC, gradient="shape").solver(
        Population(corners, volumes, 0), [SNOW], dx=DX, gravity=-G * up, lower=lower, upper=upper,
        origin=DX * np.floor(lower / DX), obstacles=walls)
    states = ParticleStates(solver)
    place = (states.reference - base) @ axes.T
    settle(solver, SNOW, length)
    height = (states.positions() - base) @ up
    tau = states.column("stress")
    stress = (tau / states.column("volume_ratio").reshape(-1, 1))[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    normal = np.einsum("ia,nab,ib->ni", axes, stress, axes)
    pressure = SNOW.density * G * (length - place[:, 2])
    side = SNOW.poisson_ratio / (1.0 - SNOW.poisson_ratio)
    off = np.abs(normal + pressure[:, None] * [side, side, 1.0]).max(axis=1) / pressure.max()
    error = (height - exact_height(SNOW, length, place[:, 2])) / (length - exact_height(SNOW, length, length))
    far_side = [WIDTH * DX, WIDTH * DX, np.inf] - place
    inside = np.minimum(place, far_side).min(axis=1)
    return error[place[:, 2] > 0.9 * length].mean(), off, inside / DX


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [(30, 0), (30, 25)])
def test_turned_box(degrees):
    """64 particles a cell. Without what holds the lines of its walls together (`joined_contact`) the top is 3.5 and
    7.1 % off, the stress half a cell from the walls 19 and 44 % of the pressure. Single particles in corners of three
    walls stay off by up to 0.10 and 1.9 of it."""
    top, off, inside = settled(*degrees)
    print(degrees, top, off.max(), off[inside > 0.5].max(), off[inside > 1.0].max(), np.sqrt((off**2).mean()))
    assert abs(top) < 0.01
    assert off[inside > 0.5].max() < 0.05 and off[inside > 1.0].max() < 0.03
    assert np.sqrt((off**2).mean()) < 0.04
