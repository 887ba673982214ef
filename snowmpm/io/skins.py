"""Colours and pictures of obstacles in a run file."""

import h5py
import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.vtkhdf import COMPRESSION
from snowmpm.reading.skin import Skin

SKIN = "skin"
"""Group of an obstacle with one group for each of its materials."""

PARTS = ("vertices", "facets", "st", "picture")
WIDEST = 4096
"""Longer side [px] of a picture that is read."""


def create_skins(group, skins):
    """Write the `Skin`s of an obstacle into its group."""
    for number, skin in enumerate(skins):
        part = group.create_group(f"{SKIN}/{number}")
        part.create_dataset("vertices", data=np.asarray(skin.vertices, np.float64), **COMPRESSION)
        part.create_dataset("facets", data=np.asarray(skin.facets, np.int32), **COMPRESSION)
        part.create_dataset("st", data=np.asarray(skin.st, np.float32), **COMPRESSION)
        part.create_dataset("picture", data=np.asarray(skin.picture, np.uint8), **COMPRESSION)
        part["vertices"].attrs["units"] = "m"


def read_skins(group):
    """`Skin`s of an obstacle, none in files without."""
    parts = group.get(SKIN, {})
    return tuple(Skin(*(part[name][:] for name in PARTS)) for _, part in sorted(parts.items(), key=lambda one: one[0]))


def check_skins(group, path, check_drawing):
    """Raises InputError for what cannot be the `Skin`s of an obstacle."""
    skins = group.get(SKIN, {})
    for part in [skins] if isinstance(skins, h5py.Dataset) else skins.values():
        if not isinstance(part, h5py.Group) or set(part) != set(PARTS):
            raise InputError(f"{path}: {part.name} is not what colours of an obstacle are")
        check_drawing(part, path)
        st, picture = part["st"], part["picture"]
        fits = st.shape == (len(part["vertices"]), 2) and st.dtype.kind == "f" and np.isfinite(st[:]).all()
        fits = fits and part["facets"].shape[1] == 3 and picture.dtype == np.uint8 and len(picture.shape) == 3
        if not (fits and picture.shape[2] == 3 and min(picture.shape) > 0 and max(picture.shape) <= WIDEST):
            raise InputError(f"{path}: {part.name} is not what colours of an obstacle are")
