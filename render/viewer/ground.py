"""The ground of an interactive page: its own triangles, cut straight at the rim, fewer where it is flat."""

import io
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from PIL import Image

from snowmpm.render import light
from snowmpm.render.ground import EARTH, ground_colour
from snowmpm.render.relief import WALL, with_walls

FACETS = 60_000  # of the ground, at most
PICTURE = 900  # px: longer side of the ground's colours seen from above
QUALITY = 82
TOP, BELOW = [150, 138, 126], [96, 90, 88]  # of the ground of a section


@dataclass(frozen=True)
class Mesh:
    """vertices (n, 3) [m], colours (n, 3) uint8, facets (m, 3).

    ground: number of facets that are ground, the rest are walls below its rim
    picture: JPEG of the ground's colours from above, first row at the largest y, over the plan box `box` (x0, y0, x1,
             y1) [m]; None: the colours of the vertices
    """

    vertices: np.ndarray
    colours: np.ndarray
    facets: np.ndarray
    ground: int
    picture: bytes | None = None
    box: tuple[float, ...] = (0.0, 0.0, 1.0, 1.0)


def space_ground(view):
    """`Mesh` of the ground in space of a `space_view.SpaceView`; None without ground."""
    relief = view.relief
    if relief is None:
        return None
    vertices, facets = cut(relief.vertices, relief.facets[: relief.ground], *view.action.box())
    vertices, facets = fewer(vertices, facets, FACETS)
    # Walls stand again below the new rim
    mesh = with_walls(replace(relief, vertices=vertices, facets=facets, normals=np.zeros_like(vertices),
                              ground=len(facets)), WALL * float(np.ptp(vertices[:, :2], axis=0).max()))
    shade = EARTH * light.illuminate(mesh.normals.astype(np.float32), view.sun, softness=0.1)
    x0, y0 = vertices[:, :2].min(axis=0)
    x1, y1 = vertices[:, :2].max(axis=0)
    return Mesh(mesh.vertices, light.encode(shade), mesh.facets, len(facets), _from_above(view, x0, y0, x1, y1),
                (float(x0), float(y0), float(x1), float(y1)))


def section_ground(profile):
    """`Mesh` of the ground of a section as a ribbon from its profile downwards; None without ground."""
    if profile is None:
        return None
    x, z = profile.x, profile.z
    depth = 0.12 * float(np.ptp(x))
    # Below the lowest ground it ends evenly
    low = np.full_like(z, z.min() - 0.25 * depth)
    back = np.full_like(x, 1e-3 * depth)  # behind the snow
    n = len(x)
    a = np.arange(n - 1)
    facets = np.concatenate([np.column_stack([a, a + n, a + 1]), np.column_stack([a + 1, a + n, a + n + 1])])
    shade = np.concatenate([np.tile([TOP], (n, 1)), np.tile([BELOW], (n, 1))]).astype(np.uint8)
    return Mesh(np.concatenate([np.column_stack([x, back, z]), np.column_stack([x, back, low])]), shade, facets,
                len(facets))


def cut(vertices, facets, lower, upper):
    """(vertices, facets) of triangles within the plan box `lower`, `upper` (2,) [m]: those on its rim are cut there."""
    for axis in (0, 1):
        for side, at in ((1.0, lower[axis]), (-1.0, upper[axis])):
            normal, origin = np.zeros(3), np.zeros(3)
            normal[axis], origin[axis] = side, at
            vertices, facets, _ = trimesh.intersections.slice_faces_plane(vertices, facets, normal, origin)
    used, renumbered = np.unique(facets, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3)


def fewer(vertices, facets, most):
    """At most about so many triangles on some of the same vertices, the rest left out where the ground is flattest.

    By VTK's vtkDecimatePro (Schroeder et al. 1992, doi:10.1145/133994.134010), which keeps the rim.
    """
    if len(facets) <= most:
        return vertices, facets
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkDecimatePro

    places, cells, mesh, filtered = vtkPoints(), vtkCellArray(), vtkPolyData(), vtkDecimatePro()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(vertices, np.float64), deep=True))
    rows = np.column_stack([np.full(len(facets), 3), facets]).astype(np.int64)
    cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
    mesh.SetPoints(places)
    mesh.SetPolys(cells)
    filtered.SetInputData(mesh)
    filtered.SetTargetReduction(1.0 - most / len(facets))
    filtered.PreserveTopologyOn()
    filtered.BoundaryVertexDeletionOff()
    filtered.Update()
    found = filtered.GetOutput()
    return (vtk_to_numpy(found.GetPoints().GetData()).astype(float),
            vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64))


def _from_above(view, x0, y0, x1, y1):
    """JPEG of the ground's colours over a plan box: sun, shadows, snow and the bare track as they are at the end."""
    pixel = max(x1 - x0, y1 - y0) / PICTURE
    columns, rows = (max(2, round(side / pixel)) for side in (x1 - x0, y1 - y0))
    x, y = np.meshgrid(x0 + (np.arange(columns) + 0.5) * (x1 - x0) / columns,
                       y1 - (np.arange(rows) + 0.5) * (y1 - y0) / rows)
    height = view.relief.height(x.ravel(), y.ravel(), outside=float(np.nanmean(view.relief.heights)))
    points = np.column_stack([x.ravel(), y.ravel(), height])
    colours = light.encode(ground_colour(view.relief, points, view.sun, view.cover)).reshape(rows, columns, 3)
    file = io.BytesIO()
    Image.fromarray(colours).save(file, "JPEG", quality=QUALITY)
    return file.getvalue()
