"""Obstacles on a picture: blocks in space, areas in a section."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from PIL import Image, ImageDraw

from snowmpm.render import light
from snowmpm.render.ground import OVERSAMPLING, seen_facets

SOLID = light.decode([0.42, 0.50, 0.64])  # slate: apart from snow, ground and the warm colours of speed
AREA = light.decode([0.30, 0.38, 0.52])
RIM = 0.45  # share of its light at the edge of an area
EDGE = 2  # px: width of that edge
FINE = 4  # subpixels a side of the areas of a section
NEARBY = 1.0  # of the extent of the snow: obstacles up to this far from it are kept in sight
SAMPLED_FRAMES = 8


def placed(run, i):
    """Vertices (n, 3) [m] and facets (m, 3) or (m, 2) of all obstacles of a run together, in frame `i`."""
    vertices, facets, count = [np.zeros((0, 3))], [np.zeros((0, run.dimension), int)], 0
    for obstacle in run.obstacles.values():
        vertices.append(obstacle.placed(i))
        facets.append(obstacle.facets + count)
        count += len(obstacle.vertices)
    return np.concatenate(vertices), np.concatenate(facets)


def nearby(run, low, high):
    """Corners (k, 3) or, of a section, (k, 2) of obstacles at any time of the run that lie in and around the box from
    `low` to `high` of its snow, given along (x, y, z) or (x, z)."""
    axes = [0, 1, 2] if len(low) == 3 else [0, 2]
    frames = np.unique(np.linspace(0, len(run) - 1, SAMPLED_FRAMES).round().astype(int))
    corners = np.concatenate([placed(run, int(i))[0][:, axes] for i in frames])
    margin = NEARBY * float(np.max(high - low))
    return corners[((corners >= low - margin) & (corners <= high + margin)).all(axis=1)]


def draw_solids(ground, camera, sun, vertices, facets):
    """`Ground` with solids of triangles before it, smoothed by drawing them larger; what snow may cover."""
    if not len(facets):
        return ground
    solid = SimpleNamespace(vertices=vertices, facets=facets)
    raster, depth, _ = seen_facets(solid, camera.enlarged(OVERSAMPLING))
    behind = np.kron(ground.depth, np.ones((OVERSAMPLING, OVERSAMPLING), np.float32))
    front = raster.hit & (depth < behind)
    corners = vertices[facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    inwards = ((corners[:, 0] - camera.eye) * normals).sum(axis=1) > 0.0  # as some mesh files have them
    if not camera.perspective:
        inwards = np.einsum("ni,i->n", normals, camera.axes[2]) > 0.0
    normals[inwards] *= -1.0
    shade = SOLID * light.illuminate(normals.astype(np.float32), sun, softness=0.1)
    large = np.zeros((*front.shape, 3), np.float32)
    large[front] = shade[raster.facet[front]]
    rows, columns = ground.depth.shape
    blocks = (rows, OVERSAMPLING, columns, OVERSAMPLING)
    cover = front.reshape(blocks).mean(axis=(1, 3))[..., None]
    picture = ground.light * (1.0 - cover) + large.reshape(*blocks, 3).mean(axis=(1, 3))
    nearest = np.where(front, depth, np.inf).reshape(blocks).min(axis=(1, 3))
    solid = nearest < ground.depth
    return replace(ground, light=picture.astype(np.float32), depth=np.where(solid, nearest, ground.depth),
                   slack=np.where(solid, 0.0, ground.slack))


def draw_areas(picture, camera, vertices, facets):
    """Fill the areas that segments `facets` (m, 2) enclose, each with a dark rim by which it is told from those that
    touch it, in a picture (height, width, 3) in linear light."""
    if not len(facets):
        return
    x, y, _ = camera.project(vertices)
    height, width = picture.shape[:2]
    areas, rims = (Image.new("L", (FINE * width, FINE * height)) for _ in range(2))
    for ring in rings(facets):
        corners = [(FINE * x[v], FINE * y[v]) for v in ring]
        ImageDraw.Draw(areas).polygon(corners, fill=255)
        ImageDraw.Draw(rims).line([*corners, corners[0]], fill=255, width=2 * EDGE * FINE)
    blocks = (height, FINE, width, FINE)
    cover, rim = ((np.asarray(one) > 0).reshape(blocks).mean(axis=(1, 3), dtype=np.float32)[..., None]
                  for one in (areas, rims))
    picture[:] = picture * (1.0 - cover) + AREA * (1.0 - (1.0 - RIM) * rim) * cover


def rings(facets):
    """Closed chains of vertex numbers from segments (m, 2) that run one way round."""
    following = dict(facets.tolist())
    while following:
        start, at = next(iter(following.items()))
        ring = [start]
        del following[start]
        while at in following:
            ring.append(at)
            at = following.pop(at)
        yield ring
