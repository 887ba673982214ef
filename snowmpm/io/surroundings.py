"""Terrain and obstacles of a run file as blocks that VTK reads, and the file beside it that opens them with the snow.

Each block is a temporal PolyData of its own, in map coordinates. The terrain is written once, an obstacle again in each
step in which it has moved. Data common to all blocks and the particles' steps (times, numbers of parts, offsets of
zero) are stored once and shared by hard links. VTK looks into the group `VTKHDF` only; the companion file is a
multi-block data set (VTKHDF 2.1, ParaView 5.13) whose blocks are links into the run file, so it never changes and is
always up to date.
"""

import io
from pathlib import Path

import h5py
import numpy as np

from snowmpm.io import layout
from snowmpm.io.archive import write_bytes
from snowmpm.io.obstacles import last_placed
from snowmpm.io.rows import as_rows
from snowmpm.io.vtkhdf import COMPRESSION, append, growing

GROUP = "surroundings"
TERRAIN = "terrain"
OBSTACLE = "obstacle_"
"""Name of the terrain's block, and prefix of the names of obstacle blocks."""

SHARED = ("Values", "NumberOfParts", "CellOffsets", "ConnectivityIdOffsets")
"""Data sets of the particles' steps that all blocks share."""


def create_surroundings(h5, terrain, obstacles, origin):
    """Groups in a new run file for the terrain (vertices, facets) or None, and obstacles {name: (vertices, facets)}."""
    root = h5.create_group(GROUP)
    if terrain is not None:
        _create_block(h5, TERRAIN, *terrain)
        append(root[TERRAIN]["Points"], as_rows(terrain[0]) + origin)
    for name, drawing in (obstacles or {}).items():
        _create_block(h5, OBSTACLE + name, *drawing)
    return root


def _create_block(h5, name, vertices, facets):
    facets = np.asarray(facets)
    group, (cells, corners) = h5[GROUP].create_group(name), facets.shape
    group.attrs["Version"] = np.array(layout.VTK_VERSION, np.int64)
    group.attrs.create("Type", b"PolyData", dtype="S8")
    growing(group, "Points", dtype=np.float64, columns=3, chunk=layout.chunk_rows(len(vertices)),
            **COMPRESSION)
    group["NumberOfPoints"] = np.array([len(vertices)], np.int64)
    for kind in layout.CELL_KINDS:
        own = cells if kind == ("Lines" if corners == 2 else "Polygons") else 0
        group[f"{kind}/NumberOfCells"] = np.array([own], np.int64)
        group[f"{kind}/NumberOfConnectivityIds"] = np.array([own * corners], np.int64)
        options = COMPRESSION if own else {}
        group[kind].create_dataset("Offsets", data=corners * np.arange(own + 1), dtype=np.int64, **options)
        group[kind].create_dataset("Connectivity", data=facets.ravel()[: own * corners], dtype=np.int64, **options)
    steps = group.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(0)
    for shared in SHARED:
        steps[shared] = h5["VTKHDF/Steps"][shared]
    growing(steps, "PartOffsets")
    growing(steps, "PointOffsets")


def append_surroundings(h5, origin):
    """Add the step whose particles and poses have just been added."""
    for name, group in h5.get(GROUP, {}).items():
        steps = group["Steps"]
        count = int(steps.attrs["NSteps"])
        start = 0
        if name != TERRAIN:
            points = last_placed(h5, name.removeprefix(OBSTACLE)) + origin
            start = int(steps["PointOffsets"][-1]) if count else 0
            if not count or not np.array_equal(group["Points"][start:], points):
                start = len(group["Points"])
                append(group["Points"], points)
        append(steps["PartOffsets"], [0])
        append(steps["PointOffsets"], [start])
        steps.attrs["NSteps"] = np.int64(count + 1)


def keep_surroundings(h5, count):
    """Keep only the first steps, so many; data shared with the particles are dropped there."""
    for name, group in h5.get(GROUP, {}).items():
        steps = group["Steps"]
        steps.attrs["NSteps"] = np.int64(count)
        steps["PartOffsets"].resize(count, axis=0)
        steps["PointOffsets"].resize(count, axis=0)
        if name != TERRAIN:
            group["Points"].resize(int(steps["PointOffsets"][-1] + group["NumberOfPoints"][0]) if count else 0, axis=0)


def write_companion(run_file, blocks):
    """Write the companion of a run file, with the snow and these blocks; -> its path. Raises OSError."""
    path, draft = companion(run_file), io.BytesIO()
    with h5py.File(draft, "w", libver=layout.HDF5_VERSIONS) as h5:
        root = h5.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = np.array(layout.VTK_COMPOSITE_VERSION, np.int64)
        root.attrs.create("Type", b"MultiBlockDataSet", dtype="S17")
        assembly = root.create_group("Assembly", track_order=True)
        for name, target in {"snow": "/VTKHDF", **{name: f"/{GROUP}/{name}" for name in blocks}}.items():
            root[name] = h5py.ExternalLink(Path(run_file).name, target)
            assembly[name] = h5py.SoftLink(f"/VTKHDF/{name}")
    write_bytes(path, draft.getbuffer())
    return path


def companion(run_file):
    """Path of the companion: `paraview.vtkhdf`, or `NAME.paraview.vtkhdf` beside a run file of another name."""
    path = Path(run_file)
    return path.with_name(layout.COMPANION_FILE if path.name == layout.RUN_FILE
                          else f"{path.stem}.{layout.COMPANION_FILE}")
