"""Sun, sky and the step from light to picture values. Colours are linear light until `encode`."""

import numpy as np

SUN = np.array([1.0, 0.96, 0.88], np.float32) * 0.86
SKY = np.array([0.62, 0.76, 1.0], np.float32) * 0.40
GROUND_BOUNCE = np.array([1.0, 0.95, 0.88], np.float32) * 0.10
ZENITH = np.array([0.56, 0.66, 0.77], np.float32)
HORIZON = np.array([0.86, 0.89, 0.92], np.float32)


def decode(colour):
    """sRGB in [0, 1] -> linear light."""
    return np.asarray(colour, np.float32) ** 2.2


def encode(light):
    """Linear light -> sRGB bytes; what is brighter than white is rolled off rather than cut."""
    knee = 0.8
    excess = np.maximum(light - knee, 0.0)
    rolled = np.where(light > knee, knee + (1.0 - knee) * excess / (excess + (1.0 - knee)), light)
    return np.round(255.0 * np.clip(rolled, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8)


def sun_direction(axes, facing, behind_share=0.44, elevation=38.0):
    """Unit vector towards the sun for a camera with `axes`: from behind one of its shoulders, 38 degrees up.

    facing: mean normal (3,) of what is drawn; the sun stands on the side that lights it better, left if in doubt;
    behind_share: how far behind the camera, 0 beside it; elevation [degrees]
    """
    right, behind = axes[0] * [1.0, 1.0, 0.0], -axes[2] * [1.0, 1.0, 0.0]
    if np.linalg.norm(behind) < 1e-6:  # from straight above: light from the top left of the picture, as on maps
        behind = axes[1] * [1.0, 1.0, 0.0]
    right, behind = right / np.linalg.norm(right), behind / np.linalg.norm(behind)
    height = np.radians(elevation)
    choices = []
    for side in (-0.90, 0.90):
        plan = (side * right + behind_share * behind) / np.hypot(side, behind_share)
        choices.append(np.array([plan[0] * np.cos(height), plan[1] * np.cos(height), np.sin(height)]))
    left, right = choices
    return right if right @ facing > left @ facing + 0.1 else left


def illuminate(normals, sun, *, softness, sunlight=1.0, openness=1.0):
    """Light (..., 3) on surfaces with unit `normals` (..., 3); softness 0.1 for rock, 0.5 for snow."""
    towards = np.einsum("...i,i->...", normals, sun.astype(np.float32))
    facing = np.clip((towards + softness) / (1.0 + softness), 0.0, None) * sunlight
    up = 0.5 + 0.5 * normals[..., 2]
    open_sky = up * openness
    return facing[..., None] * SUN + open_sky[..., None] * SKY + (1.0 - up)[..., None] * GROUND_BOUNCE


def shaded(share):
    """Factor (..., 3) on light that assumed the whole sun, where a share [0, 1] of it comes: blue sky light is left.

    For surfaces already drawn, whose own direction is not known: half of their light is taken to come from the sun.
    """
    left = np.array([0.42, 0.48, 0.60], np.float32)
    return left + np.asarray(share, np.float32)[..., None] * (1.0 - left)


def sky(size):
    """(height, width, 3) backdrop, brighter towards the bottom."""
    share = np.linspace(0.0, 1.0, size[1], dtype=np.float32)[:, None, None] ** 0.8
    return decode(ZENITH + share * (HORIZON - ZENITH)) * np.ones((1, size[0], 1), np.float32)
