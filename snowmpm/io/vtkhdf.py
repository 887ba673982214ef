"""The VTKHDF part of a run file: particles as temporal PolyData. The layout is in `snowmpm.io.layout`.

Every function works on the open group `VTKHDF` and writes NSteps, the number of steps, last.
"""

import h5py
import numpy as np

from snowmpm.io import layout

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
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


def append_step(root, time, points, fields, units):
    """Append one step: points (n, 3), fields by name; ValueError when the names differ from those of the first step."""
    steps, n = root["Steps"], len(points)
    count = int(steps.attrs["NSteps"])
    if "Points" not in root:
        _create_point_data(root, points, fields, units)
    if set(fields) != set(root["PointData"]):
        raise ValueError(f"fields {sorted(fields)}, must be {sorted(root['PointData'])} as in the first frame")
    start = layout.next_boundary(len(root["Points"]), root["Points"].chunks[0])
    for data, values in [(root["Points"], points), *((root["PointData"][name], fields[name]) for name in fields)]:
        data.resize(start + n, axis=0)
        data[start:] = values
    _number_vertices(root["Vertices"], n)

    append(root["NumberOfPoints"], [n])
    for kind in layout.CELL_KINDS:
        cells = n if kind == "Vertices" else 0
        append(root[f"{kind}/NumberOfCells"], [cells])
        append(root[f"{kind}/NumberOfConnectivityIds"], [cells])
    append(steps["Values"], [time])
    append(steps["PartOffsets"], [count])
    append(steps["NumberOfParts"], [1])
    append(steps["PointOffsets"], [start])
    for name in fields:
        append(steps["PointDataOffsets"][name], [start])
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        append(steps[name], [[0] * len(layout.CELL_KINDS)])
    steps.attrs["NSteps"] = np.int64(count + 1)


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
