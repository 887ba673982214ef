"""Triangles from a mesh file: STL, OBJ, PLY."""

from pathlib import Path

import numpy as np

from snowmpm.errors import InputError

SUFFIXES = (".stl", ".obj", ".ply")


def mesh_facets(path, key="terrain.file"):
    """Vertices (n, 3) [m] and triangles (m, 3) of a mesh file.

    Coordinates are taken as metres. Only the geometry is read: materials and textures named by the file are not opened.
    InputError: unknown kind of file, unreadable, or without triangles.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError.at(key, str(path), "must be an .stl, .obj or .ply file")
    import trimesh  # slow to import

    try:
        with open(path, "rb") as file:
            mesh = trimesh.load(
                file, file_type=suffix[1:], force="mesh", process=False, skip_materials=True, resolver={}
            )
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except Exception as error:  # a parser may fail in any way on a file that is not what its name says
        raise InputError.at(key, str(path), f"is not a readable {suffix[1:].upper()} mesh") from error
    faces = getattr(mesh, "faces", None)
    if faces is None or len(faces) == 0:
        raise InputError.at(key, str(path), "has no triangles")
    vertices = np.asarray(mesh.vertices, float)
    if not np.isfinite(vertices).all():
        raise InputError.at(key, str(path), "has a vertex that is not a finite number")
    return vertices, np.asarray(faces)
