"""Voxels with a header in text, as programs of tomographs write them (MetaImage of ITK):

    ObjectType = Image
    NDims = 3
    DimSize = 400 400 300          voxels along x, y, z; x fastest
    ElementType = MET_UCHAR
    ElementDataFile = sample.raw   beside the header; LOCAL: in the same file, after this line, which is the last

Other keys that are read: BinaryDataByteOrderMSB (False), HeaderSize [bytes before the voxels] (0), CompressedData (must
be False), ElementNumberOfChannels (must be 1). The rest of them, such as spacings, is left alone.
"""

import math

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget

TYPES = {"MET_CHAR": "i1", "MET_UCHAR": "u1", "MET_SHORT": "i2", "MET_USHORT": "u2", "MET_INT": "i4", "MET_UINT": "u4",
         "MET_FLOAT": "f4", "MET_DOUBLE": "f8"}
LONGEST = 65_536
"""Bytes of a header."""


def read_metaimage(path, where, dim, copies):
    """Values of the voxels of a .mhd or .mha file, (nx, nz) or (nx, ny, nz). copies: memory a byte of them takes.

    InputError: keys that are missing or are not as above, a file of voxels that is elsewhere, missing or too short.
    """
    keys, end = _header(path, where)
    counts = _counts(keys, where, dim)
    kind = keys.get("ElementType", "none")
    if kind not in TYPES:
        raise InputError(f"{where}: ElementType = {kind[:40]}: must be one of {', '.join(TYPES)}")
    for key, only in (("CompressedData", "false"), ("ElementNumberOfChannels", "1")):
        if keys.get(key, only).lower() != only:
            raise InputError(f"{where}: {key} = {keys[key][:40]}: must be {only.capitalize()}")
    file, skipped = _voxel_file(keys["ElementDataFile"], keys, path, where, end)
    swapped = keys.get("BinaryDataByteOrderMSB", keys.get("ElementByteOrderMSB", "false")).lower() == "true"
    dtype = np.dtype(TYPES[kind]).newbyteorder(">" if swapped else "<")
    promised, size = math.prod(counts) * dtype.itemsize, file.stat().st_size - skipped
    if promised > size:
        raise InputError(f"{where}: DimSize and ElementType make {promised} bytes, and {file.name} holds"
                         f" {max(0, size)}")
    read_budget.allow(where, copies * float(promised), f"{' x '.join(map(str, counts))} voxels")
    return np.fromfile(file, dtype, math.prod(counts), offset=skipped).reshape(counts, order="F")


def _header(path, where):
    """Keys of the header, and where it ends [bytes]."""
    keys, end = {}, 0
    with open(path, "rb") as file:
        while end < LONGEST and (line := file.readline(LONGEST)):
            end += len(line)
            key, equals, value = line.decode("latin-1").partition("=")
            if not equals:
                break
            keys[key.strip()] = value.strip()
            if key.strip() == "ElementDataFile":
                return keys, end
    raise InputError(f"{where}: no MetaImage: lines of KEY = VALUE must lead to ElementDataFile")


def _counts(keys, where, dim):
    parts = keys.get("DimSize", "").split()
    if len(parts) != dim or not all(part.isdigit() and 0 < int(part) < 2**31 for part in parts):
        raise InputError(f"{where}: DimSize = {' '.join(parts)[:40] or 'none'}: must be {dim} numbers of voxels > 0")
    return tuple(int(part) for part in parts)


def _voxel_file(name, keys, path, where, end):
    """Path of the voxels, and how many bytes are before them."""
    if name == "LOCAL":
        return path, end
    file = path.parent / name
    if not name or file.parent != path.parent or not file.is_file():
        raise InputError(f"{where}: ElementDataFile = {name[:60]}: must be a file beside the header, or LOCAL")
    head = keys.get("HeaderSize", "0")
    if not head.isdigit():
        raise InputError(f"{where}: HeaderSize = {head[:40]}: must be a number of bytes >= 0")
    return file, int(head)
