"""Obstacles that snow cannot reach, or that the grid cannot resolve."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.solids.primitives import BALL, CYLINDER, SAMPLED

ACROSS = 2.0
"""Least width of an obstacle across the flow [cells]. Nodes inside it stop the snow, and one thinner than a cell may
contain none: for discs of 0.3 to 0.6 cells in a stream, the force was zero at two of three positions in the grid, and
several times too large at the third."""

BURIED = 0.2
"""Share of an obstacle within reach of the snow below which it counts as mostly buried or outside."""

LEVELS = 13
"""Points along each axis of an obstacle that are checked for reach."""

MOMENTS = 33
"""Number of times at which a moving obstacle is checked."""

MARGIN = 2.0
"""Cells beyond the domain at which nodes still act on the snow in it."""


@dataclass(frozen=True)
class Doubt:
    """key: of the scene; says: the doubt about an obstacle; cure: its remedy."""

    key: str
    says: str
    cure: str

    def __str__(self):
        return f"{self.key}: {self.says}; {self.cure}"


def refuse_unreachable(model):
    """Raise InputError, with its position, for an obstacle of a `Model` that snow can never reach."""
    for i, obstacle in enumerate(model.obstacles):
        if not _reached(model, obstacle):
            raise InputError(f"{model.scene.source}: {key_of(model, i)}: snow cannot reach any of it"
                             f"\n{_whereabouts(model, obstacle)}")


def doubts(model):
    """`Doubt`s about the obstacles of a `Model`; of the segments of a member, about the first that has one."""
    doubted = set()
    for i, doubt in _all_doubts(model):
        segment = i >= len(model.scene.obstacles)
        about = (model.obstacles[i].name.rsplit("_", 1)[0], doubt.says) if segment else i
        if not segment or about not in doubted:
            yield doubt
        doubted.add(about)


def _all_doubts(model):
    """Number of an obstacle of a `Model`, and a `Doubt` about it."""
    dx, on_grid = model.scene.solver.dx, METHODS[model.scene.solver.method].capabilities.grid
    for i, obstacle in enumerate(model.obstacles):
        key = key_of(model, i)
        width = across(obstacle)
        if on_grid and width < ACROSS * dx * (1.0 - 1e-6):
            yield i, Doubt(key, f"{width / dx:.2g} cells across: the force on what is thinner than {ACROSS:g} cells"
                                " across the flow depends on where it lies between the nodes, and may be 0",
                           f"solver.dx = {_rounded_down(width / ACROSS):g} or less")
        share = _reached(model, obstacle)
        if share < BURIED:
            yield i, Doubt(key, f"snow can reach {share:.0%} of it: the rest is below the ground or outside the"
                                " domain", "look where it stands")


def key_of(model, i):
    """Where obstacle i of a `Model` stands in its scene, in words."""
    table = f"obstacles.{i}" if i < len(model.scene.obstacles) else next(iter(model.made))
    return f"{table} ({model.obstacles[i].name})"


def across(obstacle):
    """Least width [m] of an obstacle across the flow: the second smallest side of its box, since the smallest one may
    lie along the flow, like the thickness of a wall."""
    return 2.0 * float(np.sort(obstacle.shape.size)[1])


def _reached(model, obstacle):
    """Largest share of the points of an obstacle that snow can reach at one time."""
    return max(float((inside & above).mean()) for _, inside, above in _states(model, obstacle))


def _states(model, obstacle):
    """Points (k, dim) [m] of each place of the obstacle over time, and which of them are in the domain, and over
    ground."""
    margin = MARGIN * model.scene.solver.dx
    points, x = _points(obstacle.shape), None
    for time in [0.0] if obstacle.still else np.linspace(0.0, model.scene.end_time, MOMENTS):
        before, x = x, obstacle.motion.moved(points, time)
        if before is not None and np.array_equal(before, x):  # at rest then, or moved by forces that are not known yet
            continue
        inside = ((x >= model.lower - margin) & (x <= model.upper + margin)).all(axis=1)
        yield x, inside, _over_ground(model, x)


def _over_ground(model, x):
    surface = model.surface
    if surface is None:
        return np.ones(len(x), bool)
    height = surface.height(x[:, :-1])
    if (surface.facet_normals[:, -1] < 0.0).any():  # the highest surface does not tell what lies below it
        return np.isfinite(height) & (model.distance.query(x)[0] > 0.0)
    return x[:, -1] > height  # False without ground


def _points(shape):
    """Points (k, dim) [m] all over a shape, its outermost ones among them."""
    if shape.kind == SAMPLED:
        vertices, facets = shape.surface.vertices, shape.surface.facets
        return np.concatenate([vertices, vertices[facets].mean(axis=1)])
    axes = [np.linspace(-1.0, 1.0, LEVELS)] * shape.dim
    u = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, shape.dim)
    if shape.kind in (BALL, CYLINDER):
        u = u[np.linalg.norm(u[:, : 2 if shape.kind == CYLINDER else None], axis=1) <= 1.0 + 1e-9]
    return shape.origin + (u * shape.size) @ shape.axes


def _whereabouts(model, obstacle):
    """The reason why an obstacle is out of reach, with numbers."""
    x, inside, _ = next(_states(model, obstacle))
    box = f"{np.round(x.min(axis=0), 2).tolist()} to {np.round(x.max(axis=0), 2).tolist()} m"
    if not inside.any():
        domain = f"{np.round(model.lower, 2).tolist()} to {np.round(model.upper, 2).tolist()} m"
        return f"it lies at {box}, outside the domain, {domain}"
    height = model.surface.height(x[:, :-1])
    if not np.isfinite(height).any():
        return f"it lies at {box}, beside the terrain"
    return (f"it lies at {box}, below the ground, which is {np.nanmin(height):.2f} to {np.nanmax(height):.2f} m high"
            " there")


def _rounded_down(length):
    """Two digits of a length [m]."""
    unit = 10.0 ** (np.floor(np.log10(length)) - 1)
    return float(f"{np.floor(length / unit + 1e-9) * unit:.3g}")
