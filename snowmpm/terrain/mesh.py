"""Triangles from a mesh file: STL, OBJ, PLY, binary glTF."""

import io
import json
import logging
import re
import warnings
from pathlib import Path

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.terrain.mesh_units import metre_of_mesh
from snowmpm.terrain.topology import LARGEST

SUFFIXES = (".stl", ".obj", ".ply", ".glb")
BYTES_PER_BYTE = 25
"""Memory while a mesh is read and welded, over the size of its file."""

BACKWARD = re.compile(rb"^\s*f\s.*-\d", re.MULTILINE)
"""A face of an OBJ file with a corner that counts backwards."""

DEEPEST = 100
"""Levels of nodes in a glTF file."""

MANY_CORNERS = re.compile(rb"^\s*f(?:\s+\S+){4}", re.MULTILINE)
"""A face of an OBJ file with four corners or more."""

MOST_CORNERS = 200
"""Of a face that is taken apart with care: that takes time with their square or more."""

MOST_CUTTING = 400_000
"""Sum over the faces of more than four corners of the squares of these, up to which faces are taken apart: seconds."""

ROUNDED = 0.01
"""Share of the sides of triangles from which on rounded places are told."""

STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def mesh_facets(path, key="terrain.file"):
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh file.

    Coordinates are taken as metres, unless a remark in the file names another unit: then they are converted, and a
    warning says so. Only the geometry is read: materials and textures named by the file are not opened.
    InputError: unknown kind of file, unreadable, or without triangles.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError.at(key, str(path), "must be an .stl, .obj, .ply or .glb file")
    memory.require(BYTES_PER_BYTE * _size(path), f'{key} = "{path}"', "a mesh of fewer triangles needs less")
    vertices, faces = _binary_stl(path, key) if suffix == ".stl" else (None, None)
    if faces is not None:
        _tell_of_round_off(vertices, f'{key} = "{path}"')
    if faces is None:
        vertices, faces = _any_mesh(path, key, suffix)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError.at(key, str(path), "must have vertices of three coordinates and triangles of three corners")
    if not (np.abs(vertices) <= LARGEST).all():
        raise InputError.at(key, str(path), "has a vertex that is not a finite number, or out of reach")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError.at(key, str(path), "has a triangle with a corner that it does not have")
    metre = metre_of_mesh(path, suffix)
    if metre != 1.0:
        warnings.warn(f'{key} = "{path}": says that a unit of it is {metre:.10g} m: converted to metres', stacklevel=2)
    return converted(vertices, path, suffix), faces


def converted(vertices, path, suffix):
    """Vertices (n, 3) of a mesh file in metres, with z up: glTF has y up, by its standard."""
    if suffix == ".glb":
        return np.column_stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]])
    return vertices * metre_of_mesh(path, suffix)


def _binary_stl(path, key):
    """Corners (3 m, 3) and triangles (m, 3) of a binary STL file, None and None of one that is not: its length
    must match its number of triangles. This is the usual case, and reading it is faster than importing a library."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    n = int.from_bytes(data[80:84], "little")
    if n == 0 or len(data) != 84 + STL_TRIANGLE.itemsize * n:
        return None, None
    corners = np.frombuffer(data, STL_TRIANGLE, offset=84)["corners"].astype(float)
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


def _any_mesh(path, key, suffix):
    import trimesh  # slow to import

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # it prints tracebacks for unreadable files
    try:
        with open(path, "rb") as file:
            if suffix == ".obj":
                file = io.BytesIO(prepared_obj(file.read()))
            if suffix == ".glb":
                file = io.BytesIO(_counted_glb(file.read(), key, path))
            mesh = trimesh.load(
                file, file_type=suffix[1:], force="mesh", process=False, skip_materials=True, resolver={}
            )
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except InputError:
        raise
    except Exception as error:  # a parser may fail in any way on a file of another format
        raise InputError.at(key, str(path), f"is not a readable {suffix[1:].upper()} mesh") from error
    faces = getattr(mesh, "faces", None)
    if faces is None or len(faces) == 0:
        raise InputError.at(key, str(path), "has no triangles")
    return np.asarray(mesh.vertices, float), np.asarray(faces)


def glb_header(data):
    """Header of a binary glTF file as a dictionary. Raises ValueError where it is none."""
    length = int.from_bytes(data[12:16], "little")
    header = json.loads(data[20 : 20 + length]) if data[:4] == b"glTF" else None
    if not isinstance(header, dict):
        raise ValueError("no binary glTF")
    return header


def _counted_glb(data, key, path):
    """Bytes of a binary glTF file, after a look at its header: its tables hold no more than the file, no part is placed
    more often than that, and no part holds itself. Raises InputError where not, and for extensions."""
    header = glb_header(data)
    if needed := header.get("extensionsRequired"):
        raise InputError.at(key, str(path), f"needs the glTF extension {str(needed[0])[:60]}: save it without it")
    counts = [int(one["count"]) for one in header.get("accessors", [])]
    sizes = [sum(counts[k] for part in mesh["primitives"]
                 for k in [*part["attributes"].values(), part.get("indices", 0)]) for mesh in header.get("meshes", [])]
    nodes = header.get("nodes", [])
    placed = sum(sizes[node["mesh"]] for node in nodes if "mesh" in node)
    if not (all(0 <= count <= len(data) for count in counts) and placed <= len(data)):
        raise InputError.at(key, str(path), "has tables that are larger than the file")
    parents = {}
    for number, node in enumerate(nodes):
        for child in node.get("children", []):
            if child in parents:
                raise InputError.at(key, str(path), "has a node that two others hold")
            parents[child] = number
    for number in range(len(nodes)):
        at, steps = number, 0
        while at in parents:
            at, steps = parents[at], steps + 1
            if steps > DEEPEST:
                raise InputError.at(key, str(path), f"has nodes more than {DEEPEST} deep within each other")
    return data


def _counted_from_the_start(data):
    """Text of an OBJ file whose corners are numbered from its start: a negative number counts back from its line, and
    trimesh counts from the end of the file."""
    if not BACKWARD.search(data):
        return data
    counts, lines = {b"v": 0, b"vt": 0, b"vn": 0}, []
    for line in data.splitlines():
        words = line.split()
        if words and words[0] in counts:
            counts[words[0]] += 1
        elif words and words[0] == b"f":
            line = b" ".join([b"f", *(_absolute(word, counts) for word in words[1:])])
        lines.append(line)
    return b"\n".join(lines) + b"\n"


def prepared_obj(data):
    """Text of an OBJ file that `trimesh` reads as meant: corners numbered from the start, and faces with an inward
    corner as triangles, since trimesh makes fans of them, which fold over."""
    data = _counted_from_the_start(data)
    if not MANY_CORNERS.search(data):
        return data
    left = MOST_CUTTING
    places = np.array([line.split()[1:4] for line in data.splitlines() if line.startswith((b"v ", b"v\t"))], float)
    lines = []
    for line in data.splitlines():
        words = line.split()
        if len(words) > 4 and words[0] == b"f":
            at = [int(word.split(b"/")[0]) - 1 for word in words[1:]]
            if all(0 <= k < len(places) for k in at) and len(at) ** 2 <= left:
                left -= len(at) ** 2 if len(at) > 4 else 0
                lines += [b"f " + b" ".join(words[1 + k] for k in ear) for ear in ears(places[at])]
                continue
        lines.append(line)
    return b"\n".join(lines) + b"\n"


def ears(corners):
    """Triangles (numbers of three corners) of a plane polygon with corners (n, 3): a fan where no corner is inward or
    there are more than MOST_CORNERS, else by cutting off ears (Meisters 1975, doi:10.2307/2319703)."""
    after, before = np.roll(corners, -1, axis=0), np.roll(corners, 1, axis=0)
    normal = np.cross(corners - corners[0], after - corners[0]).sum(axis=0)
    turns = np.cross(corners - before, after - corners) @ normal
    left, found = list(range(len(corners))), []
    if len(left) <= MOST_CORNERS and (turns < -1e-9 * np.abs(turns).max(initial=0.0)).any():
        axis = int(np.abs(normal).argmax())
        flat = np.delete(corners, axis, axis=1) * [1.0, 1.0 if (normal[axis] > 0.0) == (axis != 1) else -1.0]
        while len(left) > 3:
            ear = next((k for k in range(len(left)) if _is_ear(flat, left, k)), None)
            if ear is None:  # crosses itself
                break
            found.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
            del left[ear]
    return found + [(left[0], left[k], left[k + 1]) for k in range(1, len(left) - 1)]


def _is_ear(flat, left, k):
    """Whether corner k of those left (counter-clockwise) sticks out and its triangle holds no other."""
    a, b, c = flat[left[k - 1]], flat[left[k]], flat[left[(k + 1) % len(left)]]
    others = flat[[i for i in left if i not in (left[k - 1], left[k], left[(k + 1) % len(left)])]]
    sides = [_side(p, q, others) for p, q in ((a, b), (b, c), (c, a))]
    return bool(_side(a, b, c[None])[0] > 0.0 and not np.logical_and.reduce([side >= 0.0 for side in sides]).any())


def _side(p, q, points):
    """Twice the area of the triangles p, q and points (n, 2), positive counter-clockwise."""
    return (q[0] - p[0]) * (points[:, 1] - p[1]) - (q[1] - p[1]) * (points[:, 0] - p[0])


def _absolute(corner, counts):
    parts = corner.split(b"/")
    for k, name in zip(range(len(parts)), (b"v", b"vt", b"vn"), strict=False):
        if parts[k].startswith(b"-") and parts[k][1:].isdigit():
            parts[k] = str(counts[name] + 1 + int(parts[k])).encode()
    return b"/".join(parts)


def _tell_of_round_off(vertices, where):
    """Warn where single precision, in which a binary STL is, does not hold the places of the corners."""
    edges = np.linalg.norm(vertices[1::3] - vertices[::3], axis=1)
    held, edge = float(np.spacing(np.float32(np.abs(vertices).max()))), float(np.median(edges)) if len(edges) else 0.0
    if held > ROUNDED * edge:
        warnings.warn(f"{where}: single precision holds places to {held:.3g} m there, and sides are {edge:.3g} m long:"
                      " take an origin off its coordinates, or save it as PLY in double precision", stacklevel=3)


def _size(path):
    try:
        return Path(path).stat().st_size
    except OSError:  # said by what reads it
        return 0
