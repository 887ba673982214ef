"""Voxel images: what a body of two phases is made of, from a file."""

import io
import zipfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageSequence

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.terrain.load import existing

ENDINGS = (".npy", ".npz", ".tif", ".tiff", ".raw")


def read_voxels(spec, dim, base_dir, key):
    """Values of the voxels, (nx, nz) or (nx, ny, nz), from the file of a `voxels` shape.

    .npy, .npz (its first array)  indices along x, (y,) z
    .tif                          pages are levels of z from below, rows y, columns x; in 2-D one page, its rows from
                                  above
    .raw                          unsigned bytes, `counts` of them along x, (y,) z, x fastest
    InputError: unreadable, of another number of axes, not as many bytes as `counts` says.
    """
    path = existing(spec.file, base_dir, f"{key}.file")
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        raise InputError.at(f"{key}.file", str(spec.file), f"must end in {', '.join(ENDINGS)}")
    try:
        voxels = _raw(path, spec.counts, key) if ending == ".raw" else _read(path, ending, dim)
    except InputError:
        raise
    except Exception as error:  # damaged files fail in NumPy, zipfile and Pillow in a dozen ways
        reason = " ".join(str(error).split())[:120]
        raise InputError.at(f"{key}.file", str(spec.file), f"cannot be read as a voxel image ({reason})") from None
    if voxels.ndim != dim or 0 in voxels.shape:
        raise InputError.at(f"{key}.file", str(spec.file),
                            f"must have {dim} axes in a {dim}-D scene, and has {' x '.join(map(str, voxels.shape))}"
                            " voxels")
    return voxels


def _read(path, ending, dim):
    if ending == ".npy":
        # Mapped: a header that promises more than the file holds takes no memory
        return np.array(np.load(path, mmap_mode="r", allow_pickle=False))
    if ending == ".npz":
        with zipfile.ZipFile(path) as archive:
            first = archive.infolist()[0]
            memory.require(2.0 * first.file_size, f"shape.file = {path.name!r}", "fewer voxels need less")
            with archive.open(first) as file:
                return np.lib.format.read_array(io.BytesIO(file.read()), allow_pickle=False)
    with Image.open(path) as image:
        pages = np.stack([np.asarray(page) for page in ImageSequence.Iterator(image)])
    if dim == 2 and len(pages) == 1:
        return pages[0][::-1].T
    return pages.T


def _raw(path, counts, key):
    if counts is None:
        raise InputError(f"{key}.counts is missing: voxels of the .raw file along each axis")
    values = np.fromfile(path, np.uint8)
    if len(values) != np.prod(counts):
        allowed = f"makes {np.prod(counts)} voxels, and the file holds {len(values)}"
        raise InputError.at(f"{key}.counts", list(counts), allowed)
    return values.reshape(counts, order="F")


def phase_inside(voxels, phase, voxel_size, origin):
    """Function points (k, dim) [m] -> (k,) bool: whether they lie in voxels of value `phase`."""
    filled = voxels == phase

    def contains(points):
        at = np.clip(((points - origin) / voxel_size).astype(int), 0, np.array(filled.shape) - 1)
        return filled[tuple(at.T)]

    return contains
