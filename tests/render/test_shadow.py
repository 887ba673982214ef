"""Shadows: where geometry puts them."""

import numpy as np
import pytest
from synthetic_runs import slab_3d

from snowmpm.io import Run
from snowmpm.render.shadow import Shadow
from snowmpm.render.snow import _smooth_depth, draw_snow
from snowmpm.render.space_view import SpaceView

HIGH = np.array([0.0, 0.0, 12.0])


def ball(centre, radius, spacing):
    grid = np.arange(-radius, radius + spacing, spacing)
    points = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    return points[np.linalg.norm(points, axis=1) <= radius] + centre


@pytest.mark.parametrize("height", [30.0, 60.0, 89.9])
def test_shadow_of_a_ball_lies_where_the_sun_throws_it(height):
    """On a floor, a ball of radius R at height h shades an ellipse around h / tan(sun's height), R across."""
    up = np.radians(height)
    sun = np.array([np.cos(up), 0.0, np.sin(up)])
    shadow = Shadow.of(ball([0.0, 0.0, 10.0], 2.0, 0.1), 0.08, sun)
    middle = -10.0 / np.tan(up)
    x, y = np.meshgrid(np.arange(middle - 8.0, middle + 8.0, 0.1), np.arange(-6.0, 6.0, 0.1))
    lit = shadow.lit(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    inside = ((x - middle) * np.sin(up)) ** 2 + y**2
    assert (lit[inside.ravel() < 1.7**2] < 0.02).all()
    assert (lit[inside.ravel() > 2.4**2] > 0.98).all()
    area = 0.01 * (1.0 - lit).sum()
    assert area == pytest.approx(np.pi * 2.06**2 / np.sin(up), rel=0.05)  # the balls reach 0.08 m further, on average


def test_the_lit_side_of_snow_does_not_shade_itself():
    sun = np.array([0.6, 0.0, 0.8])
    shadow = Shadow.of(ball(np.zeros(3), 2.0, 0.1), 0.08, sun)
    directions = np.random.default_rng(0).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    lit, facing = shadow.lit(2.05 * directions), directions @ sun
    assert (lit[facing > 0.6] > 0.99).all() and (lit[facing < -0.4] < 0.01).all()


def test_the_surface_is_smooth_but_its_edges_are_not_rounded():
    """Balls on a lattice, in two levels: the bumps go, the step of five balls stays within a pixel or two."""
    rows, columns = np.indices((60, 80))
    bumps = 0.25 * (np.sin(1.9 * rows) * np.sin(1.7 * columns))
    front = np.where(columns < 40, 20.0, 25.0) + 0.05 * rows + bumps
    surface = _smooth_depth(front.astype(np.float32), np.ones(front.shape, bool), 3.0, 1.0)
    even = np.where(columns < 40, 20.0, 25.0) + 0.05 * rows
    off = np.abs(surface - even)[12:-12]
    assert off[:, 10:30].max() < 0.1 and off[:, 50:70].max() < 0.1  # of the bumps' 0.25
    assert (off[:, 30:50] > 0.5).sum(axis=1).max() <= 2
    assert np.isinf(_smooth_depth(front.astype(np.float32), columns < 40, 3.0, 1.0)[:, 40:]).all()


def test_places_in_plain_light_or_shade_need_no_taps():
    """The share of the sun is that of all taps, to the bit, also beyond the sun's picture."""
    sun = np.array([0.6, 0.0, 0.8])
    points = np.concatenate([ball(np.zeros(3), 2.0, 0.1), ball([5.0, 1.0, 1.0], 0.7, 0.1)])
    shadow = Shadow.of(points, 0.08, sun)
    places = np.random.default_rng(1).uniform([-9.0, -6.0, -4.0], [9.0, 6.0, 4.0], (20000, 3))
    x, y, depth = shadow.camera.project(places)
    taps = shadow._taps(x, y, depth - np.float32(shadow.bias))
    assert (shadow.lit(places) == taps).all()
    assert (taps == 0.0).any() and (taps == 1.0).any() and ((taps > 0.0) & (taps < 1.0)).any()


def test_snow_darkens_the_ground_beside_it_away_from_the_sun(tmp_path):
    slab_3d(tmp_path, particles=2000, frames=2)
    view = SpaceView(Run(tmp_path), (480, 270), "snow", "top")
    ground = np.array([60.0, 0.0, float(view.relief.height([60.0], [0.0])[0])])
    snow = ball(ground + HIGH, 3.0, 0.4)
    before, after = view.ground.light, draw_snow(view.ground, view.camera, view.sun, snow, 0.4)
    ratio = (after / np.maximum(before, 1e-6)).mean(axis=-1)
    ray = ground + HIGH - np.arange(0.0, 60.0, 0.1)[:, None] * view.sun
    foot = ray[np.argmax(view.relief.height(ray[:, 0], ray[:, 1]) >= ray[:, 2])]
    other = 2.0 * ground - foot
    other[2] = float(view.relief.height(other[:1], other[1:2])[0])
    column, row, _ = view.camera.project(np.array([foot, other]))
    dark, bright = ratio[row.astype(int), column.astype(int)]
    assert dark < 0.75 and bright > 0.97
