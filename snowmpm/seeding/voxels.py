"""Voxel images of a two-phase body, from a file."""

import io
import math
import zipfile
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget
from snowmpm.reading.named_files import existing
from snowmpm.seeding.metaimage import read_metaimage

ENDINGS = (".npy", ".npz", ".tif", ".tiff", ".mhd", ".mha", ".raw")
COPIES = 3.0
"""Memory per byte of an image while it is read and its values are compared."""

MOST_PAGES = 5000
BYTES_PER_PIXEL = {"1": 1, "L": 1, "P": 1, "I;16": 2, "I;16B": 2, "LA": 2, "RGB": 3}
"""Bytes of a pixel by Pillow's mode; 4 for others."""


def read_voxels(spec, dim, base_dir, key):
    """Values of the voxels, (nx, nz) or (nx, ny, nz), from the file of a `voxels` shape.

    .npy, .npz (its first array)  indices along x, (y,) z
    .tif                          pages are levels of z from below, rows y, columns x; in 2-D one page, its rows from
                                  above
    .mhd, .mha                    voxels with a header (`metaimage`), x fastest
    .raw                          unsigned bytes, `counts` of them along x, (y,) z, x fastest
    InputError: unreadable, of another number of axes, not as many bytes as `counts` says.
    """
    path = existing(spec.file, base_dir, f"{key}.file")
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        raise InputError.at(f"{key}.file", str(spec.file), f"must end in {', '.join(ENDINGS)}")
    where = f"{key}.file = {str(spec.file)!r}"
    try:
        voxels = READERS[ending](path, where, dim) if ending != ".raw" else _raw(path, where, spec.counts, key)
    except InputError:
        raise
    except Exception as error:  # damaged files raise many kinds of errors in NumPy, zipfile and Pillow
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{where}: cannot be read as a voxel image ({reason})") from None
    if voxels.ndim != dim or 0 in voxels.shape:
        raise InputError(f"{where}: must have {dim} axes in a {dim}-D scene, and has"
                         f" {' x '.join(map(str, voxels.shape))} voxels")
    if voxels.dtype.kind not in "biuf":
        raise InputError(f"{where}: must hold numbers, and holds {voxels.dtype}")
    return voxels


def _npy(path, where, dim):
    with open(path, "rb") as file:
        return _array(file, path.stat().st_size, where)


def _npz(path, where, dim):
    with zipfile.ZipFile(path) as archive:
        first = archive.infolist()[0]
        read_budget.allow(where, COPIES * float(first.file_size), f"{first.file_size} bytes of {first.filename[:60]}")
        with archive.open(first) as file:
            return _array(io.BytesIO(file.read()), first.file_size, where)


def _array(file, size, where):
    """Array of NumPy's format from a file of `size` bytes, which its header must not promise more than."""
    version = np.lib.format.read_magic(file)
    reader = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = reader(file)
    promised = float(dtype.itemsize) * float(np.prod(np.array(shape, float)))
    if promised > size or dtype.hasobject:
        raise InputError(f"{where}: is too short for the {' x '.join(map(str, shape))} {dtype} values that its header"
                         " promises" if not dtype.hasobject else f"{where}: must hold numbers, and holds objects")
    read_budget.allow(where, COPIES * promised, f"{' x '.join(map(str, shape))} voxels")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)


def _tif(path, where, dim):
    from PIL import Image, ImageSequence

    # Only Pillow's TIFF reader: otherwise the content could select any of forty formats
    with Image.open(path, formats=("TIFF",)) as image:
        pages, size = [], 0.0
        for page in ImageSequence.Iterator(image):
            size += float(page.width) * page.height * BYTES_PER_PIXEL.get(page.mode, 4)
            if len(pages) == MOST_PAGES:
                raise InputError(f"{where}: has more than {MOST_PAGES} pages")
            if pages and page.size != pages[0].shape[1::-1]:
                raise InputError(f"{where}: page {len(pages) + 1} is {page.width} x {page.height} pixels, and the first"
                                 f" {pages[0].shape[1]} x {pages[0].shape[0]}")
            read_budget.allow(where, COPIES * size, f"{page.width} x {page.height} pixels on {len(pages) + 1} pages")
            pages.append(np.asarray(page))
    pages = np.stack(pages)
    if dim == 2 and len(pages) == 1:
        return pages[0][::-1].T
    return pages.T


def _raw(path, where, counts, key):
    if counts is None:
        raise InputError(f"{key}.counts is missing: voxels of the .raw file along each axis")
    promised, size = math.prod(counts), path.stat().st_size
    if size != promised:
        raise InputError.at(f"{key}.counts", list(counts), f"makes {promised} voxels, and the file holds {size}")
    read_budget.allow(where, COPIES * float(size), f"{size} voxels")
    return np.fromfile(path, np.uint8).reshape(counts, order="F")


def _mhd(path, where, dim):
    return read_metaimage(path, where, dim, COPIES)


READERS = {".npy": _npy, ".npz": _npz, ".tif": _tif, ".tiff": _tif, ".mhd": _mhd, ".mha": _mhd}


def phase_inside(voxels, phase, voxel_size, origin):
    """Function points (k, dim) [m] -> (k,) bool: whether they lie in voxels of value `phase`."""
    filled = voxels == phase

    def contains(points):
        at = np.clip(((points - origin) / voxel_size).astype(int), 0, np.array(filled.shape) - 1)
        return filled[tuple(at.T)]

    return contains
