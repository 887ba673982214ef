"""Polygonal areas, in parts and with holes: any input becomes a valid area or is refused."""

import re
import warnings

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain.topology import LARGEST

ASIDE = np.array([1e-9, 0.37e-9])
"""Shift of points, relative to the size, before the test for inside or outside. Points on an edge, such as a row of a
lattice, are then all inside or all outside in spite of round-off, for edges of any usual slope."""

FLAT = 1e-12
"""Share of its bounding box below which an area counts as none."""


class Polygons:
    """An area of one or more polygons with holes that are valid and do not overlap.

    The mass and the filled area follow from the same geometry.
    """

    def __init__(self, geometry):
        import shapely  # slow to import, and many scenes have no polygon

        shapely.prepare(geometry)
        self._geometry = geometry

    @classmethod
    def of(cls, parts, label):
        """Area of `parts`, each a list of rings (n, 2) of corners [m]: an outline and the holes in it.

        Rings are closed automatically and may have either orientation. A self-intersecting outline is filled as in a
        GIS, by the even-odd rule. Spikes and repeated corners have no area, and an area shared by two parts counts
        once. Each such repair causes a warning that names `label`. InputError: no polygon, a
        corner that is not two finite numbers, no area, or corners so near each other that no area can be made of them.
        """
        import shapely

        repairs = []
        try:
            made = cls.from_geometry(_whole(parts, label, repairs))
        except shapely.errors.GEOSException as error:
            raise InputError(f"{label}: no area can be made of the polygon's corners") from error
        lower, upper = made.bounds() if made.area() > 0.0 else (0.0, 1.0)
        if not made.area() > FLAT * np.prod(upper - lower):
            raise InputError(f"{label}: the polygon has no area")
        if repairs:
            pieces = len(made._geometry.geoms)
            area = f"{made.area():.6g} m2 in {pieces} parts" if pieces > 1 else f"{made.area():.6g} m2"
            flaws = "; ".join(dict.fromkeys(repairs))
            warnings.warn(f"{label}: the polygon is repaired ({flaws}): {area}", stacklevel=2)
        return made

    @classmethod
    def from_geometry(cls, geometry):
        """The polygons of a valid shapely geometry, without lines and points."""
        import shapely

        return cls(shapely.MultiPolygon([p for p in _leaves(geometry) if p.geom_type == "Polygon" and p.area > 0]))

    @property
    def geometry(self):
        """The area as a shapely MultiPolygon."""
        return self._geometry

    def bounds(self):
        """Lower and upper corner (2,) [m]."""
        bounds = np.array(self._geometry.bounds)
        return bounds[:2], bounds[2:]

    def area(self):
        """Area [m2]."""
        return float(self._geometry.area)

    def area_within(self, lower, upper):
        """Area [m2] inside a rectangle between two corners (2,) [m], which may be infinite."""
        import shapely

        low, high = self.bounds()
        low, high = np.maximum(low, lower), np.minimum(high, upper)
        return float(self._geometry.intersection(shapely.box(*low, *high)).area) if (low < high).all() else 0.0

    def contains(self, points):
        """Which of the points (k, 2) lie inside; shape (k,). Points on left and lower edges do, points on others do
        not."""
        import shapely

        if self._geometry.is_empty:
            return np.zeros(len(points), bool)
        lower, upper = self.bounds()
        x, y = (points + ASIDE * np.max(upper - lower)).T
        return shapely.contains_xy(self._geometry, x, y)

    def moved(self, axes):
        """The same area in coordinates along the rows of `axes` (2, 2)."""
        import shapely

        return Polygons(shapely.transform(self._geometry, lambda corners: corners @ np.asarray(axes).T))

    def touches_box(self, other):
        """Whether the bounding boxes of the two have a point in common."""
        (a, b), (c, d) = self.bounds(), other.bounds()
        return bool((a <= d).all() and (c <= b).all())

    def without(self, other):
        """The part of this area that is not in the other."""
        return Polygons.from_geometry(self._geometry.difference(other._geometry))


def _whole(parts, label, repairs):
    """Valid geometry of all parts; what was wrong with them is added to `repairs`."""
    import shapely

    solid = []
    for rings in parts:
        outline, *holes = [_repaired(ring, label, repairs) for ring in rings] or [shapely.Polygon()]
        hollow = shapely.union_all(holes)
        if hollow.difference(outline).area > FLAT * hollow.area:
            repairs.append("a hole reaches outside its outline")
        solid.append(outline.difference(hollow))
    whole = shapely.union_all(solid)
    if sum(part.area for part in solid) > whole.area * (1.0 + 1e-9):
        repairs.append("parts of it overlap, and what they share counts once")
    return whole


def simple_outline(points, label):
    """Corners (n, 2) of an outline that bounds one area without a hole, none twice in a row.

    InputError: it crosses or touches itself, has no area, or a corner is not two finite numbers.
    """
    import shapely

    corners = _corners(points, label)
    ring = shapely.Polygon(corners) if len(corners) > 2 else shapely.Polygon()
    if not ring.is_valid:
        raise InputError(f"{label}: the polygon crosses itself{_where(ring)}, so no inside")
    if not ring.area > FLAT * np.prod(np.ptp(corners, axis=0)):
        raise InputError(f"{label}: the polygon has no area")
    return corners


def _corners(ring, label):
    """Corners (n, 2), none twice in a row."""
    try:
        corners = np.asarray(ring, float)[:, :2]
        sound = corners.shape[1] == 2 and bool((np.abs(corners) <= LARGEST).all())
    except (ValueError, IndexError, TypeError):
        sound = False
    if not sound:
        raise InputError(f"{label}: a polygon is a list of points [x, y], two finite numbers each")
    return corners[(corners != np.roll(corners, 1, axis=0)).any(axis=1)]


def _repaired(ring, label, repairs):
    """Valid geometry of one ring; what was wrong with it is added to `repairs`."""
    import shapely

    corners = _corners(ring, label)
    if len(corners) < 3:
        repairs.append("a ring of fewer than three corners has no area")
        return shapely.Polygon()
    drawn = shapely.Polygon(corners)
    if drawn.is_valid:
        return drawn
    repairs.append(f"its outline crosses or touches itself{_where(drawn)}")
    return Polygons.from_geometry(shapely.make_valid(drawn))._geometry


def _where(geometry):
    """" near (x, y)" of the first flaw of an invalid geometry."""
    import shapely

    found = re.search(r"\[(\S+) (\S+?)\]", shapely.is_valid_reason(geometry))
    return f" near ({float(found[1]):.10g}, {float(found[2]):.10g})" if found else ""


def _leaves(geometry):
    """Simple geometries of which a possibly nested geometry consists."""
    import shapely

    parts = shapely.get_parts(geometry).tolist()
    return [leaf for part in parts for leaf in _leaves(part)] if len(parts) > 1 or parts != [geometry] else [geometry]
