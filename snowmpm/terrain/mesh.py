"""Triangles from a mesh file: STL, OBJ, PLY."""

import logging
import warnings
from pathlib import Path

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.terrain.mesh_units import metre_of_mesh
from snowmpm.terrain.topology import LARGEST

SUFFIXES = (".stl", ".obj", ".ply")
BYTES_PER_BYTE = 25
"""Memory while a mesh is read and welded, over the size of its file."""

STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def mesh_facets(path, key="terrain.file"):
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh file.

    Coordinates are taken as metres, unless a remark in the file names another unit: then they are converted, and a
    warning says so. Only the geometry is read: materials and textures named by the file are not opened.
    InputError: unknown kind of file, unreadable, or without triangles.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError.at(key, str(path), "must be an .stl, .obj or .ply file")
    memory.require(BYTES_PER_BYTE * _size(path), f'{key} = "{path}"', "a mesh of fewer triangles needs less")
    vertices, faces = _binary_stl(path, key) if suffix == ".stl" else (None, None)
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
        vertices = vertices * metre
    return vertices, faces


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
            mesh = trimesh.load(
                file, file_type=suffix[1:], force="mesh", process=False, skip_materials=True, resolver={}
            )
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except Exception as error:  # a parser may fail in any way on a file of another format
        raise InputError.at(key, str(path), f"is not a readable {suffix[1:].upper()} mesh") from error
    faces = getattr(mesh, "faces", None)
    if faces is None or len(faces) == 0:
        raise InputError.at(key, str(path), "has no triangles")
    return np.asarray(mesh.vertices, float), np.asarray(faces)


def _size(path):
    try:
        return Path(path).stat().st_size
    except OSError:  # said by what reads it
        return 0
