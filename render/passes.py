"""What a picture is made of, for a compositing program: see-through sky, and distance along the view."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render import light

PASSES = ("picture", "transparent", "depth")


def checked_pass(name, kind, dimension):
    """The name of a pass. Raises InputError for an unknown one, of a section, or into a file of a `kind` (its ending)
    that cannot hold it."""
    if name not in PASSES:
        raise InputError.not_in("pass", name, PASSES)
    if name != "picture" and dimension != 3:
        raise InputError.at("pass", name, "is of a run in three dimensions")
    endings = {"transparent": (".png", ""), "depth": (".tif", "")}.get(name)
    if endings and kind not in endings:
        raise InputError.at("pass", name, f"goes into a {endings[0]} file or a folder, not into a {kind} file")
    if kind == ".tif" and name != "depth":
        raise InputError.at("output", kind, 'is for pass = "depth"')
    return name


def sky_of(brightness):
    """A sky as `light.sky`, all of one brightness in linear light."""
    return lambda size: np.full((size[1], size[0], 3), brightness, np.float32)


def with_alpha(over_black, over_white):
    """(height, width, 4) uint8 of the same picture, in linear light, over a black and a white sky: what is seen of the
    sky is see-through, to the edges; colours are not multiplied by alpha."""
    alpha = np.clip(1.0 - (over_white - over_black).mean(axis=2, keepdims=True), 0.0, 1.0)
    colour = light.encode((over_black / np.maximum(alpha, 1e-3)).astype(np.float32))
    return np.concatenate([colour, np.round(255.0 * alpha).astype(np.uint8)], axis=2)
