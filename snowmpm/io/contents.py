"""Check of a run file before anything of it is read, since the file may come from anybody.

Refused are groups that contain themselves, links, data in other files, names and types that no run file has, tables
that do not fit each other, and files that take more memory than allowed (`snowmpm.reading.budget`).
"""

import math

import h5py
import numpy as np

from snowmpm.errors import InputError, shown_line
from snowmpm.io.obstacles import GROUP as OBSTACLES
from snowmpm.io.obstacles import LOADS, POSES
from snowmpm.io.series import check_series
from snowmpm.io.skins import SKIN, check_skins
from snowmpm.io.surroundings import GROUP as SURROUNDINGS
from snowmpm.reading import budget as read_budget

FRAME_DATA = ("/VTKHDF/Points", "/VTKHDF/PointData", "/VTKHDF/Vertices", f"/{SURROUNDINGS}")
"""Tables that are read frame by frame, or never."""

MOST_ITEMS = 20_000
LONGEST_NAME = 200
RECORDS = ("/provenance/record", "/hazard/record")


def check_contents(h5, path):
    """Raise InputError for an open file that is no run file of this program, or a harmful one."""
    sizes, seen = 0.0, set()
    groups = [h5]
    while groups:
        group = groups.pop()
        above = group.name.rstrip("/")
        for name in group:
            item = _item(group, above, name, path, seen)
            if isinstance(item, h5py.Group):
                groups.append(item)
            else:  # under each of its names: below one it may be read by frames, below another whole
                sizes += _whole_size(item, f"{above}/{name}", path)
        # Checked while the list grows, since the list takes memory too
        read_budget.allow(path, sizes, "its tables")
    _check_frames(h5["VTKHDF"], path)
    _check_tables(h5, path)


def allow_rows(path, what, count, tables):
    """Raise InputError if the rows of these tables take more memory than allowed."""
    size = sum(float(count) * data.dtype.itemsize * np.prod(data.shape[1:], dtype=float) for data in tables)
    read_budget.allow(path, size, what, "fewer fields take less")


def _item(group, above, name, path, seen):
    """The item of a group named `above`, which must lie in this file and be of a kind that run files have.

    Blocks share tables with the particles; a group that is there twice may hold itself.
    """
    if not name.isprintable() or len(name) > LONGEST_NAME:
        raise InputError(f"{path}: {shown_line(f'{above}/{name}')} is no name that a run file has")
    if group.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
        raise InputError(f"{path}: {shown_line(f'{above}/{name}')} is a link to elsewhere, which no run file has")
    item = group[name]
    if not isinstance(item, h5py.Group | h5py.Dataset):
        raise InputError(f"{path}: {shown_line(f'{above}/{name}')} is neither a group nor a table")
    about = h5py.h5o.get_info(item.id)
    if isinstance(item, h5py.Group) and ((about.fileno, about.addr) in seen or item == group.file["/"]):
        raise InputError(f"{path}: {shown_line(f'{above}/{name}')} is a group with another name too, which no run file"
                         " has")
    seen.add((about.fileno, about.addr))
    if len(seen) > MOST_ITEMS:
        raise InputError(f"{path}: more than {MOST_ITEMS} tables and groups, which no run file has")
    return item


def _whole_size(data, where, path):
    """Bytes that reading a table takes; for a table read frame by frame, bytes of one piece."""
    made = data.id.get_create_plist()
    if made.get_external_count() or made.get_layout() == h5py.h5d.VIRTUAL:
        raise InputError(f"{path}: {where} lies in another file, which no run file has")
    kind, shape = data.dtype, data.shape
    if where in RECORDS:
        if shape != () or h5py.check_string_dtype(kind) is None:
            raise InputError(f"{path}: {where} is not a text")
        return float(kind.itemsize)  # a text of variable length is no longer than the file
    if kind.kind not in "iuf" or shape is None:
        raise InputError(f"{path}: {where} is not a table of numbers")
    chunks = made.get_chunk() if made.get_layout() == h5py.h5d.CHUNKED else (0,)
    piece = math.prod(map(float, chunks)) * kind.itemsize
    if where.startswith(FRAME_DATA):
        return piece
    return max(piece, math.prod(map(float, shape)) * kind.itemsize)


def _check_frames(root, path):
    """Check that the index of the frames is consistent with itself and the particles."""
    steps = root["Steps"]
    count = int(steps.attrs["NSteps"])
    tables = {"Values": steps["Values"], "PointOffsets": steps["PointOffsets"],
              "NumberOfPoints": root["NumberOfPoints"]}
    for name, data in tables.items():
        if data.ndim != 1 or not 0 <= count <= len(data):
            raise InputError(f"{path}: {name} is not a row of {count} steps")
    if not count:
        return
    if not np.isfinite(tables["Values"][:count]).all():
        raise InputError(f"{path}: the time of a frame is not a finite number")
    starts, counts = (tables[name][:count].astype(float) for name in ("PointOffsets", "NumberOfPoints"))
    _shape(root["Points"], ("rows", 3), path)
    rows = len(root["Points"])
    if (starts < 0).any() or (counts < 0).any() or (starts + counts > rows).any():
        raise InputError(f"{path}: a frame has particles where the file has none")
    for data in root["PointData"].values():
        if data.ndim not in (1, 2) or len(data) < rows or (data.ndim == 2 and data.shape[1] not in (3, 6, 9)):
            raise InputError(f"{path}: {data.name} does not fit the particles")


def _check_tables(h5, path):
    if h5.attrs["origin"].shape != (3,) or not np.isfinite(h5.attrs["origin"]).all():
        raise InputError(f"{path}: origin is not three finite numbers")
    if int(h5.attrs["dimension"]) not in (2, 3):
        raise InputError(f"{path}: dimension = {int(h5.attrs['dimension'])}: must be 2 or 3")
    lengths = {data.shape for data in h5["history"].values()}
    if "time" not in h5["history"]:
        raise InputError(f"{path}: its history has no time")
    if len(lengths) > 1 or any(len(shape) != 1 for shape in lengths):
        raise InputError(f"{path}: the columns of its history are not of one length")
    if "vertices" in h5["terrain"]:
        _check_drawing(h5["terrain"], path)
    for data in h5["maps"].values():
        _shape(data, ("rows", "columns"), path)
        if data.name.rsplit("/", 1)[1].startswith("."):
            raise InputError(f"{path}: {data.name} is no name of a map")
        place = [float(data.attrs[name]) for name in ("x0", "y0", "cell")]
        if not np.isfinite(place).all() or not place[2] > 0.0 or 0 in data.shape:
            raise InputError(f"{path}: {data.name} has no place in plan")
    places = {(data.shape, *(float(data.attrs[name]) for name in ("x0", "y0", "cell"))) for data in h5["maps"].values()}
    if len(places) > 1:
        raise InputError(f"{path}: its maps have different cells: they are not of this program")
    check_series(h5, path)
    frames = int(h5["VTKHDF/Steps"].attrs["NSteps"])
    for group in h5.get(OBSTACLES, {}).values():
        if set(group) - {SKIN} != {"vertices", "facets", *LOADS, *POSES}:
            raise InputError(f"{path}: {group.name} is not what an obstacle has")
        _check_drawing(group, path)
        check_skins(group, path, _check_drawing)
        _shape(group["rotation"], (frames, 3, 3), path)
        _shape(group["translation"], (frames, 3), path)
        for name in LOADS:
            columns = () if group[name].ndim == 1 and name in ("time", "work", "moment") else (3,)
            _shape(group[name], (len(group["time"]), *columns), path)
        _require_finite(group["time"], path)


def _require_finite(data, path):
    if not np.isfinite(data[:]).all():
        raise InputError(f"{path}: {data.name} holds a number that is not finite")


def _check_drawing(group, path):
    """Vertices (n, 3) and facets between them."""
    _shape(group["vertices"], ("n", 3), path)
    _require_finite(group["vertices"], path)
    facets = group["facets"]
    if facets.ndim != 2 or facets.shape[1] not in (2, 3) or facets.dtype.kind not in "iu":
        raise InputError(f"{path}: {facets.name} are neither triangles nor segments")
    corners = facets[:]
    if corners.size and not (corners.min() >= 0 and corners.max() < len(group["vertices"])):
        raise InputError(f"{path}: {facets.name} name a vertex that is not there")


def _shape(data, wanted, path):
    """Raise InputError for a table of another shape; a word in `wanted` stands for any number."""
    fits = len(data.shape) == len(wanted) and all(isinstance(w, str) or n == w for n, w in zip(data.shape, wanted,
                                                                                            strict=True))
    if not fits:
        raise InputError(f"{path}: {data.name} has {' x '.join(map(str, data.shape))} numbers, must have"
                         f" {' x '.join(map(str, wanted))}")
