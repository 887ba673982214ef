"""Layers on a terrain (3-D): sheets of points that follow the ground."""

from dataclasses import dataclass

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.seeding.lattice import POINT_BYTES, sub_layers, unit_points

SMOOTHING = 2.0  # cells: normals are taken from heights this far to each side, so kinks of the ground become bends
WIDENINGS = 6  # how often that width may be doubled where a thick layer would fold in a hollow
LEAST_SHRINK = 0.1  # a column may narrow to this share of its foot before the layer counts as folded
CELL_SAMPLES = 4  # along each side of a lattice cell: places at which a thickness that varies is read
SURVEY = 4000  # points that measure the mean slope of a region


def terrain_layer(surface, region, bottom, top, *, dx, spacing, sampling, rng, rows=None, columns=False,
                  thickness=None, rim=None):
    """Positions (n, 3) [m] and volumes (n,) [m3] of the layer between two distances from the terrain.

        X(u, v, h) = S(u, v) + h n(u, v),    volume = integral of (X_u x X_v) . n  du dv dh

    S: the surface over a plan lattice (u down the mean slope, v across, or x and y for a rectangle), n: its unit
    normal, smoothed over a few cells. The lattice is narrowed by the mean slope so that points are `spacing` [m] apart
    along the ground; sub-layers about `spacing` thick, or so many `rows`, are stacked along n. The map is continuous:
    no gap and no overlap between columns or stacked layers. The plan area of the region is met exactly. columns: one
    sheet, which stands over its region as release polygons are drawn: X = S + height, volume = |S_u x S_v| du dv
    (top - bottom);
    thickness: of such a sheet where it is not top - bottom, thickness(plan (n, 2)) -> (n,) [m], 0 where there is none;
    rim: `Rim` at which columns are divided, of a sheet that is as thick everywhere.
    """
    if columns or rows:
        n_rows, row = rows or 1, (top - bottom) / (rows or 1)
    else:
        n_rows, row, spacing = sub_layers(bottom, top, spacing, 3)
    box = np.prod(region.upper - region.lower) / spacing**2
    memory.require(POINT_BYTES * box * n_rows, f"{region.label}: the lattice over it")
    lattice = Lattice.over(region, surface, spacing, SMOOTHING * dx)
    unit = unit_points((*lattice.counts, n_rows), sampling, rng)
    plan = lattice.plan(unit[:, :2])
    if region.polygons is not None:
        inside = region.polygons.contains(plan)
        unit, plan = unit[inside], plan[inside]
    if len(unit) == 0:
        raise InputError(f"{region.label}: too small for a particle at a spacing of {spacing:g} m")
    height = surface.height(plan)
    on = ~np.isnan(height)
    if not on.any() or not (on.all() or region.to_border):
        raise InputError(_off_terrain(region, surface, 1.0 - on.mean()))
    plan_share = region.area() * n_rows / len(unit)  # plan area that a point stands for
    unit, plan, height = unit[on], plan[on], height[on]
    if thickness is not None:
        row = _mean_over_cells(thickness, lattice, unit[:, :2])
        there = row > 0.0
        unit, plan, height, row = unit[there], plan[there], height[there], row[there]
        top = bottom + row
        if not len(unit):
            return np.zeros((0, 3)), np.zeros(0)
    low = bottom + np.minimum(np.floor(unit[:, 2]), n_rows - 1) * row
    frames = _unfolded_frames(surface, lattice, unit[:, :2], plan, height, (bottom, top), SMOOTHING * dx, region)
    if columns:
        volumes = frames.jacobian(np.zeros(len(unit))) * plan_share * row
        positions = frames.foot + np.outer((bottom + 0.5 * row) / frames.normal[:, 2], [0.0, 0.0, 1.0])
    else:
        # (X_u x X_v) . n is a quadratic in h: Simpson's rule is exact.
        bottom_middle_top = [frames.jacobian(low + share * row) for share in (0.0, 0.5, 1.0)]
        volumes = np.array([1.0, 4.0, 1.0]) / 6.0 @ bottom_middle_top * plan_share * row
        positions = frames.foot + (bottom + unit[:, 2] * row)[:, None] * frames.normal
    parts = rim.divided(region, plan, lattice, dx=dx, depth=row) if columns and rim else None
    if parts is None:
        return positions, volumes
    number, shift, share = parts
    rise = surface.height(plan[number] + shift) - height[number]
    return positions[number] + np.column_stack([shift, np.nan_to_num(rise)]), volumes[number] * share


def _mean_over_cells(thickness, lattice, unit):
    """Means of thickness(plan) over the lattice's cells around points (n, 2)."""
    steps = (np.arange(CELL_SAMPLES) + 0.5) / CELL_SAMPLES - 0.5
    samples = [thickness(lattice.plan(unit + np.array([u, v]))) for u in steps for v in steps]
    return np.mean(samples, axis=0)


LV03_TO_LV95 = np.array([2e6, 1e6])
"""What Swiss coordinates grew by [m]."""


def _off_terrain(region, surface, share):
    (low, high), (lower, upper) = ([corner[:2] for corner in ends] for ends in (
        (region.lower, region.upper), (surface.lower, surface.upper)))
    from_to = [f"from {_place(a)} to {_place(b)}" for a, b in ((low, high), (lower, upper))]
    return (f"{region.label}: {100 * share:.3g} % of it lies off the terrain (outside, or where there is no data): it"
            f" goes {from_to[0]}, the terrain {from_to[1]}{_why_off(low, high, lower, upper)}")


def _place(corner):
    return f"({', '.join(f'{round(float(value), 3):.10g}' for value in corner)})"


def _why_off(low, high, lower, upper):
    """What would bring a region, from low to high in plan, onto a terrain, from lower to upper; "" where unknown."""
    def on(a, b):
        return (a >= lower).all() and (b <= upper).all()

    if (np.abs([low, high]) <= [180.0, 90.0]).all() and not (np.abs([lower, upper]) <= [360.0, 90.0]).all():
        return ("; these look like degrees: where both files name their coordinate system, one is carried into the"
                " other's (a .prj beside the terrain, or a tag in it)")
    if on(low[::-1], high[::-1]):
        return "; with x and y exchanged it would lie on it"
    if on(low + LV03_TO_LV95, high + LV03_TO_LV95) or on(low - LV03_TO_LV95, high - LV03_TO_LV95):
        return "; one is in LV03 and the other in LV95, which differ by 2 000 000 and 1 000 000 m"
    return ""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Plan lattice: position = origin + (u steps_u) axis_u + (v steps_v) axis_v; counts: cells along u and v."""

    origin: np.ndarray
    axes: np.ndarray
    steps: np.ndarray
    counts: tuple

    @classmethod
    def over(cls, region, surface, spacing, width):
        """Lattice that covers the region, points `spacing` [m] apart on the mean slope; rectangles fit exactly."""
        slope = _mean_slope(region, surface, width)
        axes = np.eye(2)
        lower, upper = region.lower, region.upper
        if region.polygons is not None:
            values, vectors = np.linalg.eigh(slope)
            if values[1] > 1e-6 + 1.01 * values[0]:  # otherwise there is no direction of slope to follow
                u = vectors[:, 1] * np.sign(vectors[np.argmax(np.abs(vectors[:, 1])), 1])  # one of the two, always
                axes = np.array([u, [-u[1], u[0]]])
            lower, upper = region.polygons.moved(axes).bounds()
        metric = np.eye(2) + axes @ slope @ axes.T
        steps = spacing / np.sqrt(np.diag(metric))
        # Where the lattice is skewed on the ground its cells are smaller than spacing squared.
        steps *= np.sqrt(spacing**2 / (steps.prod() * np.sqrt(np.linalg.det(metric))))
        size = upper - lower
        counts = np.maximum(np.round(size / steps), 1).astype(int)
        if region.polygons is None:
            return cls(lower, axes, size / counts, tuple(counts))
        counts = np.maximum(np.ceil(size / steps), 1).astype(int)
        return cls((lower - 0.5 * (counts * steps - size)) @ axes, axes, steps, tuple(counts))

    def plan(self, unit):
        """Plan positions (k, 2) [m] of lattice coordinates (k, 2)."""
        return self.origin + (unit * self.steps) @ self.axes


def _mean_slope(region, surface, width):
    """Mean of grad h grad h^T (2, 2) over the region."""
    step = np.sqrt(np.prod(region.upper - region.lower) / SURVEY)
    counts = np.maximum(np.ceil((region.upper - region.lower) / step), 1)
    unit = unit_points(counts, "regular", None)
    plan = region.lower + unit * (region.upper - region.lower) / counts
    if region.polygons is not None:
        plan = plan[region.polygons.contains(plan)]
    gradient = surface.gradient(plan, width)
    gradient = gradient[np.isfinite(gradient).all(axis=1)]
    return gradient.T @ gradient / len(gradient) if len(gradient) else np.zeros((2, 2))


@dataclass(frozen=True, eq=False)
class Frames:
    """Foot S, normal n and their derivatives along the two plan axes at each point, all (n, 3), per metre of plan."""

    foot: np.ndarray
    normal: np.ndarray
    foot_u: np.ndarray
    foot_v: np.ndarray
    normal_u: np.ndarray
    normal_v: np.ndarray

    def jacobian(self, h):
        """Volume per plan area and height (n,) at heights h (n,)."""
        h = np.broadcast_to(h, len(self.foot))[:, None]
        return (np.cross(self.foot_u + h * self.normal_u, self.foot_v + h * self.normal_v) * self.normal).sum(axis=1)


def _unfolded_frames(surface, lattice, unit, plan, height, heights, width, region):
    """Frames whose columns do not cross within the layer; the normals are smoothed over twice the width until so."""
    for _ in range(WIDENINGS + 1):
        frames = _frames(surface, lattice, unit, plan, height, width)
        foot = frames.jacobian(0.0)
        folded = np.minimum(*(frames.jacobian(h) for h in heights)) < LEAST_SHRINK * foot
        if not folded.any():
            return frames
        width *= 2.0
    x, y = plan[np.argmax(folded)]
    raise InputError(
        f"{region.label}: the terrain near ({x:.6g}, {y:.6g}) bends too sharply for a layer {np.max(heights[1]):g} m"
        " high; smooth the terrain or thin the layer"
    )


def _frames(surface, lattice, unit, plan, height, width):
    """Frames from the four corners of the lattice cell around each point; the corners are shared between points."""
    rows = lattice.counts[1] + 2  # jittered points stay in their cell; the last corner line is one further
    cell = np.clip(np.floor(unit).astype(np.int64), 0, np.array(lattice.counts) - 1)
    corner = np.stack([(cell[:, 0] + i) * rows + cell[:, 1] + j for i in (0, 1) for j in (0, 1)], axis=1)
    used, corner = np.unique(corner, return_inverse=True)
    corner = corner.reshape(-1, 4)
    at = lattice.plan(np.stack([used // rows, used % rows], axis=1).astype(float))
    normals = surface.smooth_normal(at, width)[corner]
    foot = np.column_stack([at, surface.height(at)])[corner]

    beyond = np.isnan(foot[:, :, 2])  # a corner past the border of the terrain continues the point's own slope
    u, v = (unit - cell).T
    weight = np.stack([(1 - u) * (1 - v), (1 - u) * v, u * (1 - v), u * v], axis=1) * ~beyond
    normal = (weight[:, :, None] * np.where(beyond[:, :, None], 0.0, normals)).sum(axis=1)
    lost = beyond.all(axis=1)
    if lost.any():
        normal[lost] = surface.facet_normals[surface.locate(plan[lost])[0]]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    i, j = np.nonzero(beyond)
    slope = -normal[i, :2] / normal[i, 2:]
    foot[i, j, 2] = height[i] + ((foot[i, j, :2] - plan[i]) * slope).sum(axis=1)
    normals[i, j] = normal[i]

    def derivative(f, axis):
        a, b = ((2, 0), (3, 1)) if axis == 0 else ((1, 0), (3, 2))
        return 0.5 * (f[:, a[0]] - f[:, a[1]] + f[:, b[0]] - f[:, b[1]]) / lattice.steps[axis]

    return Frames(
        np.column_stack([plan, height]),
        normal,
        *(derivative(f, axis) for f in (foot, normals) for axis in (0, 1)),
    )
