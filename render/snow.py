"""Snow over the ground: a surface through the particles, lit softly, bluish where the sky alone lights it."""

import numpy as np

from snowmpm.render import light
from snowmpm.render.blur import blur
from snowmpm.render.crumble import VISIBLE, crumbled, few_around
from snowmpm.render.shadow import Shadow, shade_on, sunlit
from snowmpm.render.splat import splat_balls

SNOW = light.decode([0.955, 0.97, 0.99])
BALL = 0.80  # radius of a ball in particle spacings: neighbours overlap into a closed surface
SMOOTHING = 1.7  # of the surface, in ball radii on the picture
STEP = (0.65, 1.4)  # ball radii of scatter about the smooth surface: from an even lattice to two sides of an edge
SOFTNESS = 0.35
EXPOSURE = 0.78  # below the ground's, or fresh snow in the sun would lose its relief
SCATTERED = np.array([0.16, 0.18, 0.21], np.float32)  # share of the shade that snow itself lights up
READABLE = np.array([0.28, 0.28, 0.30], np.float32)  # the same where colours must be told in the shade
HIDDEN = np.array([0.75, 0.62, 0.45], np.float32)  # lost in a hollow: what is left in snow is blue
HOLLOWS = ((2.5, 0.30), (7.0, 0.25), (18.0, 0.15))  # widths in those of the surface, and the darkening at each


def draw_snow(ground, camera, sun, points, spacing, colours=None, identity=None, in_crumbs=True):
    """Picture (height, width, 3) in linear light: `ground` with the particles at `points` (n, 3) over it.

    spacing   [m] between particles, one or (n,);  colours (n, 3) in linear light, or (n, 4) of a sheet with
    its opacity, or None for plain snow
    identity  (n,) whole numbers that stay with their particles, or None: gives each a brightness of its own
    in_crumbs  False: loose particles as they are, not taken apart
    """
    if not len(points):
        return ground.light.copy()
    sheet = colours is not None and colours.shape[1] == 4
    # Of whole particles: by that of its crumbs, the surface would be smoothed less the more snow is loose
    radius = BALL * float(np.median(spacing))
    radius_px = radius * float(np.median(camera.pixels_per_metre(camera.project(points)[2])))
    if in_crumbs and not sheet and radius_px >= VISIBLE:
        loose = few_around(points, np.max(spacing))
        points, spacing, identity, colours = crumbled(points, spacing, loose, identity, colours)
    number, front = seen_snow(ground, camera, points, spacing)
    hit = number >= 0
    if not hit.any():
        return ground.light.copy()
    width = float(np.clip(SMOOTHING * radius_px, 1.1, 8.0))
    # What is see-through has no shadow
    shadow = Shadow.of(points[colours[:, 3] > 0.5] if sheet else points, radius, sun)
    picture = _shaded_ground(ground, shadow)
    window = _window(hit, int(8.0 * width) + 4)
    number, front, hit, behind = number[window], front[window], hit[window], ground.depth[window]
    surface = _smooth_depth(front, hit, width, radius)
    places = camera.places(surface, hit, (window[0].start, window[1].start))
    sunlight = sunlit(shadow, places, hit, softness=max(0.6 * width, 0.8))
    openness = 1.0 - _hollows(surface, hit, behind, camera, width)
    normals = _normals(surface, hit, camera, window)
    shade = EXPOSURE * light.illuminate(normals, sun, softness=SOFTNESS, sunlight=sunlight, openness=openness)
    fill = SCATTERED if colours is None else READABLE
    shade += fill * (1.0 - np.minimum(shade, 1.0))
    shade *= 1.0 - (1.0 - openness)[..., None] * HIDDEN
    seen = number[hit]
    albedo = np.zeros((*hit.shape, 3), np.float32)
    albedo[hit] = SNOW if colours is None else colours[seen, :3]
    if colours is not None:
        albedo = _even(albedo, hit, 0.5 * width)
    if identity is not None:
        albedo[hit] *= grain(identity[seen])[:, None]
    lit = albedo * shade
    opacity = None
    if sheet:
        opacity = np.zeros(hit.shape, np.float32)
        opacity[hit] = colours[seen, 3]
    picture[window] = _compose(picture[window], lit, hit, width, opacity)
    return picture


def seen_snow(ground, camera, points, spacing):
    """The particle at each pixel (height, width), -1 for none, and its depth [m] along the view, inf for none.

    Arguments as of `draw_snow`.
    """
    x, y, depth = camera.project(points)
    radii = BALL * np.broadcast_to(spacing, len(points))
    number, front = splat_balls(x, y, depth, radii, radii * camera.pixels_per_metre(depth), camera.size)
    # Snow lies on the ground to within a particle: what is a little below the drawn facets still shows from above,
    # and what is a little above them does not shine through from below. Obstacles hide what is behind them.
    own = radii[number] if len(radii) else BALL
    hidden = front > ground.depth + 2.0 * own * ground.slack
    number[hidden], front[hidden] = -1, np.inf
    return number, front


def _shaded_ground(ground, shadow):
    """Light of the ground (height, width, 3) with the shadow of the snow on it."""
    picture = ground.light.copy()
    window, on_ground = shade_on(shadow, ground.places, ground.takes_sun, softness=1.5)
    picture[window] *= light.shaded(on_ground)
    return picture


def _window(hit, margin):
    """Slices of the part of the picture that holds all snow, and `margin` pixels more."""
    return tuple(
        slice(max(int(there[0]) - margin, 0), int(there[-1]) + margin + 1)
        for there in (np.flatnonzero(hit.any(axis=axis)) for axis in (1, 0))
    )


def _smooth_depth(front, hit, width, radius):
    """Depth blurred within the snow, but not across steps: there each side is blurred by itself, so that edges stay.

    A step is where the depth scatters around its blur by more than balls of that `radius` [m] on a lattice do.
    """
    filled = np.where(hit, front, 0.0)
    blurred = _mean(filled, hit, width)
    off = np.where(hit, filled - blurred, 0.0)
    scatter = np.sqrt(np.maximum(_mean(off**2, hit, width), 0.0)) / radius
    stepped = np.clip((scatter - STEP[0]) / (STEP[1] - STEP[0]), 0.0, 1.0)
    if stepped.any():
        before = off < 0.0
        sides = [_mean(np.where(side, filled, 0.0), side, 0.7 * width) for side in (hit & before, hit & ~before)]
        blurred += stepped * (np.where(before, *sides) - blurred)
    return np.where(hit, blurred, np.inf).astype(np.float32)


def _mean(values, mask, width):
    """Mean of what is in the mask around each pixel; `values` are 0 outside it."""
    return blur(values, width) / np.maximum(blur(mask, width), 1e-6)


def _normals(surface, hit, camera, window):
    """Unit normals (height, width, 3) in space, towards the camera; along each axis from the flatter side."""
    rows, columns = np.indices(surface.shape, dtype=np.float32)
    rows, columns = rows + window[0].start + 0.5, columns + window[1].start + 0.5
    point = camera.local(columns, rows, np.where(hit, surface, 0.0)).astype(np.float32)
    across, down = (_flatter_difference(point, hit, axis) for axis in (1, 0))
    normal = np.cross(across, down)
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = np.where(length > 1e-12, normal / np.maximum(length, 1e-12), np.array([0.0, 0.0, -1.0], np.float32))
    normal *= np.where(normal[..., 2:] > 0.0, -1.0, 1.0)
    return np.einsum("...i,ij->...j", normal, camera.axes.astype(np.float32))


def _flatter_difference(point, hit, axis):
    step = np.diff(point, axis=axis)
    valid = np.logical_and(*(np.take(hit, range(k, hit.shape[axis] - 1 + k), axis=axis) for k in (0, 1)))
    step[~valid] = 1e9
    pad = [(0, 0), (0, 0), (0, 0)]
    pad[axis] = (0, 1)
    forward = np.pad(step, pad, constant_values=1e9)
    pad[axis] = (1, 0)
    backward = np.pad(step, pad, constant_values=1e9)
    chosen = np.where(np.abs(forward[..., 2:]) < np.abs(backward[..., 2:]), forward, backward)
    lone = np.abs(chosen[..., 2]) > 1e8
    chosen[lone] = 0.0
    return chosen


def _hollows(surface, hit, ground_depth, camera, width):
    """Share [0, 0.7] of the sky that what stands around hides: between clods, in grooves, at the foot of steps.

    Ambient occlusion on the picture: how far a place lies behind the mean of its surroundings, over their width.
    """
    scene = np.where(hit, np.minimum(surface, 1e30), ground_depth)
    known = np.isfinite(scene)
    scene = np.where(known, scene, np.max(scene[known], initial=0.0)).astype(np.float32)
    metres = 1.0 / float(np.median(camera.pixels_per_metre(surface[hit])))  # of a pixel
    total = np.zeros(scene.shape, np.float32)
    for share, most in HOLLOWS:
        behind = scene - blur(scene, share * width, truncate=2.5)
        total += most * np.clip(2.5 * behind / (share * width * metres), 0.0, 1.0)
    return np.where(hit, np.minimum(total, 0.7), 0.0).astype(np.float32)


def _even(colours, hit, width):
    """Colours averaged within the snow over a few pixels: single particles of another speed are not what is shown."""
    weight = np.maximum(blur(hit, width), 1e-6)
    mean = np.stack([blur(colours[..., k], width) / weight for k in range(3)], axis=-1)
    return np.where(hit[..., None], mean, 0.0)


def grain(identity):
    """A brightness for each particle, so that the eye can follow the motion within the white."""
    mixed = (identity.astype(np.uint32) * np.uint32(2654435761)) >> np.uint32(16)
    return (0.95 + 0.08 * (mixed & np.uint32(1023)).astype(np.float32) / 1023.0).astype(np.float32)


def _compose(behind, lit, hit, width, through=None):
    """Snow over what is behind it, with soft edges and a soft shadow around; through (height, width): its opacity."""
    cover = blur(hit, 0.6)
    snow = np.stack([blur(lit[..., k], 0.6) for k in range(3)], axis=-1)
    opacity = np.clip(1.25 * cover, 0.0, 1.0)[..., None]
    if through is not None:
        opacity = opacity * (blur(through, width) / np.maximum(blur(hit, width), 1e-6))[..., None]
    shadow = blur(hit if through is None else through, 2.0 + 1.5 * width)
    shadow = 1.0 - 0.3 * np.clip(shadow, 0.0, 1.0)[..., None] * ~hit[..., None]
    return behind * shadow * (1.0 - opacity) + snow / np.maximum(cover, 1e-6)[..., None] * opacity
