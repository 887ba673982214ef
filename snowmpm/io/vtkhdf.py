"""The VTKHDF part of a run file: particles as temporal PolyData. The layout is in `snowmpm.io.layout`.

Every function works on the open group `VTKHDF` and writes NSteps, the number of steps, last.
"""

import h5py
import numpy as np
from isal import isal_zlib

from snowmpm.io import layout

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
DEFLATE_LEVEL = 2  # of ISA-L: as small as the level 1 of zlib, in a tenth of its time
INDEX_ROWS = 512  # chunk of the data sets with one row a step


def create_steps(root):
    """Lay out the empty group: no steps, no fields yet."""
    root.attrs["Version"] = np.array(layout.VTK_VERSION, np.int64)
    root.attrs.create("Type", b"PolyData", dtype="S8")  # VTK reads fixed-length ASCII only
    root.create_group("PointData")
    growing(root, "NumberOfPoints")
    for kind in layout.CELL_KINDS:
        for name in ("NumberOfCells", "NumberOfConnectivityIds"):
            growing(root, f"{kind}/{name}")
        for name in ("Connectivity", "Offsets"):
            growing(root, f"{kind}/{name}", chunk=layout.LARGE_CHUNK_ROWS, **COMPRESSION)
    for kind in layout.CELL_KINDS[1:]:
        append(root[f"{kind}/Offsets"], [0])

    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(0)
    growing(steps, "Values", dtype=np.float64)
    for name in ("PartOffsets", "NumberOfParts", "PointOffsets"):
        growing(steps, name)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        growing(steps, name, columns=len(layout.CELL_KINDS))
    steps.create_group("PointDataOffsets")


def append_steps(root, frames, units):
    """Append steps, each (time, points (n, 3), fields by name); ValueError when the names of a step differ from
    those of the first."""
    steps, count = root["Steps"], int(root["Steps"].attrs["NSteps"])
    if "Points" not in root:
        _create_point_data(root, *frames[0][1:], units)
    names = list(root["PointData"])
    for _, _, fields in frames:
        if set(fields) != set(names):
            raise ValueError(f"fields {sorted(fields)}, must be {sorted(names)} as in the first frame")
    sizes, starts, chunk = [len(points) for _, points, _ in frames], [], root["Points"].chunks[0]
    end = len(root["Points"])
    for size in sizes:
        starts.append(layout.next_boundary(end, chunk))
        end = starts[-1] + size
    _fill(root["Points"], starts, [points for _, points, _ in frames], end)
    for name in names:
        _fill(root["PointData"][name], starts, [fields[name] for _, _, fields in frames], end)
        append(steps["PointDataOffsets"][name], starts)
    _number_vertices(root["Vertices"], max(sizes))

    append(root["NumberOfPoints"], sizes)
    for kind in layout.CELL_KINDS:
        cells = sizes if kind == "Vertices" else [0] * len(sizes)
        append(root[f"{kind}/NumberOfCells"], cells)
        append(root[f"{kind}/NumberOfConnectivityIds"], cells)
    append(steps["Values"], [time for time, _, _ in frames])
    append(steps["PartOffsets"], np.arange(count, count + len(sizes)))
    append(steps["NumberOfParts"], [1] * len(sizes))
    append(steps["PointOffsets"], starts)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        append(steps[name], [[0] * len(layout.CELL_KINDS)] * len(sizes))
    steps.attrs["NSteps"] = np.int64(count + len(sizes))


def _fill(data, starts, parts, end):
    """Write parts that each start at a chunk's first row, and end the data set at row `end`."""
    data.resize(end, axis=0)
    for start, values in zip(starts, parts, strict=True):
        for first in range(0, len(values), data.chunks[0]):
            place = (start + first, *[0] * (data.ndim - 1))
            data.id.write_direct_chunk(place, _filtered(data, values[first : first + data.chunks[0]]))


def _filtered(data, rows):
    """A chunk as the filters of `COMPRESSION` leave it: rows, filled up with zeros; first bytes of all numbers first;
    deflated."""
    chunk = np.zeros(data.chunks, data.dtype)
    chunk[: len(rows)] = rows
    shuffled = chunk.reshape(-1).view(np.uint8).reshape(-1, data.dtype.itemsize).T.tobytes()
    return isal_zlib.compress(shuffled, DEFLATE_LEVEL)


def keep_steps(root, limit):
    """Drop every step later than `limit` [s]."""
    steps = root["Steps"]
    keep = int(np.searchsorted(steps["Values"][:], limit, side="right"))
    used = int(steps["PointOffsets"][keep - 1] + root["NumberOfPoints"][keep - 1]) if keep else 0
    steps.attrs["NSteps"] = np.int64(keep)
    if "Points" in root:
        for data in [root["Points"], *root["PointData"].values()]:
            data.resize(used, axis=0)
    per_step = [root["NumberOfPoints"], *steps["PointDataOffsets"].values()]
    per_step += [data for data in steps.values() if isinstance(data, h5py.Dataset)]
    per_step += [
        root[kind][name] for kind in layout.CELL_KINDS for name in ("NumberOfCells", "NumberOfConnectivityIds")
    ]
    for data in per_step:
        data.resize(keep, axis=0)


def growing(group, name, *, dtype=np.int64, columns=None, chunk=INDEX_ROWS, **options):
    """An empty data set that grows along its first axis."""
    tail = () if columns is None else (columns,)
    return group.create_dataset(name, (0, *tail), dtype, maxshape=(None, *tail), chunks=(chunk, *tail), **options)


def append(data, rows):
    """Add rows at the end of a growing data set."""
    start = len(data)
    data.resize(start + len(rows), axis=0)
    data[start:] = rows


def _create_point_data(root, points, fields, units):
    chunk = layout.chunk_rows(len(points))
    growing(root, "Points", dtype=points.dtype, columns=3, chunk=chunk, **COMPRESSION)
    for name, values in fields.items():
        columns = values.shape[1] if values.ndim == 2 else None
        data = growing(root["PointData"], name, dtype=values.dtype, columns=columns, chunk=chunk, **COMPRESSION)
        data.attrs["units"] = units.get(name, "")
        growing(root["Steps/PointDataOffsets"], name)


def _number_vertices(vertices, n):
    """Extend the numbering 0, 1, 2, ... that all steps share, by whole chunks: they are then never rewritten."""
    for name, needed in (("Connectivity", n), ("Offsets", n + 1)):
        have = len(vertices[name])
        if have < needed:
            append(vertices[name], np.arange(have, layout.next_boundary(needed, layout.LARGE_CHUNK_ROWS)))
