"""Layers on a profile (2-D): rows of points at equal distances from the ground."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.seeding.lattice import sub_layers, unit_points

SIDE = np.array([[0.0, 1.0], [-1.0, 0.0]])  # t @ SIDE is t turned left by 90 degrees: the normal of a segment


def profile_layer(surface, region, bottom, top, *, dx, spacing, sampling, rng):
    """Positions (n, 2) [m] and volumes (n,) [m3 per metre of width] of a layer between two distances from the profile.

    The layer is cut into sub-layers about `spacing` [m] thick. The points of each lie on the line at its mid-distance
    from the profile (straight pieces, arcs about ridges, mitred corners in hollows), evenly spaced along it, so that
    stacked layers share their border exactly and the volume is that of the ground strip between the two distances.
    """
    ground = stretch(surface, region)
    n_rows, thickness, spacing = sub_layers(bottom, top, spacing, 2)
    rows = [OffsetLine(ground, bottom + (k + 0.5) * thickness) for k in range(n_rows)]
    lengths = np.array([row.length for row in rows])
    if sampling == "poisson":
        per_row = max(round(lengths.mean() / spacing), 1)
        unit = unit_points((per_row, n_rows), sampling, rng)
        which = np.minimum(unit[:, 1].astype(int), n_rows - 1)
        parts = [
            rows[k].points(unit[which == k, 0] / per_row * lengths[k], (unit[which == k, 1] - k - 0.5) * thickness)
            for k in range(n_rows)
        ]
        n = per_row * n_rows
        return np.concatenate(parts), np.full(n, lengths.sum() * thickness / n)
    positions, volumes = [], []
    for row in rows:
        n = max(round(row.length / spacing), 1)
        unit = unit_points((n, 1), sampling, rng)
        positions.append(row.points(unit[:, 0] / n * row.length, (unit[:, 1] - 0.5) * thickness))
        volumes.append(np.full(n, row.length * thickness / n))
    return np.concatenate(positions), np.concatenate(volumes)


def stretch(surface, region):
    """The profile (n, 2) between the region's ends. InputError when the region reaches beyond the terrain."""
    start, end = float(region.lower[0]), float(region.upper[0])
    slack = 1e-9 * (surface.upper[0] - surface.lower[0])
    if start < surface.lower[0] - slack or end > surface.upper[0] + slack:
        raise InputError.at(
            f"{region.label}.x",
            [start, end],
            f"lies off the terrain, which goes from {surface.lower[0]:g} to {surface.upper[0]:g}",
        )
    line = surface.vertices[np.r_[surface.facets[:, 0], surface.facets[-1:, 1]]]
    inside = (line[:, 0] > start + slack) & (line[:, 0] < end - slack)
    height = surface.height(np.clip([[start], [end]], surface.lower[0], surface.upper[0]))
    return np.concatenate([[[start, height[0]]], line[inside], [[end, height[1]]]])


class OffsetLine:
    """The line at a constant distance above a polyline.

    ground: (n, 2) [m], x never decreasing; distance [m]. Above a ridge it runs along an arc; in a hollow the sides meet
    at the bisector, and sides shorter than the mitre are dropped.
    """

    def __init__(self, ground, distance):
        self.distance = distance
        line = _shortened(ground, distance)
        self.foot = line[:-1]
        tangent, length, turn = _sides(line)
        self.tangent, self.normal = tangent, tangent @ SIDE
        cut = distance * np.tan(0.5 * np.maximum(turn, 0.0))
        self.skip = np.r_[0.0, cut]
        straight = np.maximum(length - self.skip - np.r_[cut, 0.0], 0.0)
        self.fan = np.r_[np.maximum(-turn, 0.0), 0.0]
        # Pieces in order: side 0, arc 0, side 1, arc 1, ...; an arc may have no length.
        self.lengths = np.stack([straight, distance * self.fan], axis=1).ravel()
        self.starts = np.r_[0.0, np.cumsum(self.lengths)]
        self.length = float(self.starts[-1])

    def points(self, along, shift):
        """Points (k, 2) at arc lengths `along` (k,) [m], moved by `shift` (k,) [m] away from the ground."""
        piece = np.clip(np.searchsorted(self.starts, along, side="right") - 1, 0, len(self.lengths) - 1)
        side, is_arc = piece // 2, piece % 2 == 1
        rest = along - self.starts[piece]
        angle = np.where(is_arc, rest / self.distance, 0.0)  # clockwise from this side's normal
        t, n = self.tangent[side], self.normal[side]
        direction = np.cos(angle)[:, None] * n + np.sin(angle)[:, None] * t
        end = np.r_[self.foot[1:], self.foot[-1:]][side]
        straight = self.foot[side] + (self.skip[side] + rest)[:, None] * t
        return np.where(is_arc[:, None], end, straight) + (self.distance + shift)[:, None] * direction


def _sides(line):
    """Unit tangents (n - 1, 2), lengths (n - 1,) and left turns (n - 2,) [rad] of a polyline (n, 2)."""
    edge = np.diff(line, axis=0)
    length = np.linalg.norm(edge, axis=1)
    t = edge / length[:, None]
    turn = np.arctan2(t[:-1, 0] * t[1:, 1] - t[:-1, 1] * t[1:, 0], (t[:-1] * t[1:]).sum(axis=1))
    return t, length, turn


def _shortened(line, distance):
    """The polyline without the inner sides that the line at `distance` does not reach; their neighbours are extended to
    meet."""
    while len(line) > 3:
        t, length, turn = _sides(line)
        cut = distance * np.tan(0.5 * np.maximum(turn, 0.0))
        left = length - np.r_[0.0, cut] - np.r_[cut, 0.0]
        hollow = np.r_[False, (turn[:-1] > 0) & (turn[1:] > 0), False]
        left = np.where(hollow, left, np.inf)
        i = int(np.argmin(left))
        if left[i] >= -1e-12 * distance:
            break
        before, after = t[i - 1], t[i + 1]
        gap = line[i + 1] - line[i]
        reach = (gap[0] * after[1] - gap[1] * after[0]) / (before[0] * after[1] - before[1] * after[0])
        line = np.concatenate([line[:i], [line[i] + reach * before], line[i + 2 :]])
    return line
