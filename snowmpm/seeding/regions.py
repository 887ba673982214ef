"""Plan region of a layer: an interval, a rectangle, a polygon, or polygons from a file."""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.seeding import attributes
from snowmpm.seeding.polygons import Polygons
from snowmpm.seeding.region_files import read_features


@dataclass(frozen=True, eq=False)
class Region:
    """Part of the plan.

    lower, upper (dim - 1,) [m]: bounds; polygons: the area, None for the whole box; thickness [m]: of the snow there,
    as given by the file, or None; label: name in messages; to_border: the region ends with the terrain (an axis was
    left free), instead of refusing parts off the terrain; flaw: why a file gives no thickness.
    """

    lower: np.ndarray
    upper: np.ndarray
    polygons: Polygons | None = None
    thickness: float | None = None
    label: str = "region"
    to_border: bool = False
    flaw: str = f"{attributes.ABSENT} {attributes.USUAL[0]!r}"

    def area(self):
        """Plan area [m2], length [m] in 2-D."""
        return float(np.prod(self.upper - self.lower)) if self.polygons is None else self.polygons.area()

    def outline(self):
        """Its border in 3-D, lines of shapely in the plan."""
        import shapely

        whole = shapely.box(*self.lower, *self.upper) if self.polygons is None else self.polygons.geometry
        return whole.boundary


def regions_of(spec, surface, base_dir, key, attribute=None):
    """Regions of a scene's region table; without one, the whole terrain.

    spec: None or an object with one of x = [x0, x1] (and y = [y0, y1] in 3-D, default all of the terrain), polygon =
    [[x, y], ...], file = .shp, .geojson or .gpkg (polygons; an attribute for the thickness [m] where there is one;
    carried into the surface's reference system). attribute: its name, by default `attributes.USUAL`.
    InputError: no area, unreadable file, a polygon in 2-D.
    """
    d = surface.dim - 1
    lower, upper = surface.lower[:d].copy(), surface.upper[:d].copy()
    if spec is None:
        return [Region(lower, upper, label="terrain", to_border=True)]
    given = {name: spec.get(name) for name in ("x", "y", "polygon", "file")}
    given = {name: value for name, value in given.items() if value is not None}
    if d == 1 and set(given) - {"x"}:
        raise InputError(f"{key}: in 2-D only x = [from, to] can be given, not {', '.join(sorted(set(given) - {'x'}))}")
    if "polygon" in given or "file" in given:
        if len(given) > 1:
            raise InputError(f"{key}: give one of x and y, polygon, or file, not {' and '.join(given)}")
        if "file" in given:
            return read_regions(existing(given["file"], base_dir, f"{key}.file"), f"{key}.file", surface.system,
                                attribute)
        area = Polygons.of([[given["polygon"]]], f"{key}.polygon")
        return [Region(*area.bounds(), area, None, f"{key}.polygon")]
    for axis, name in enumerate(("x", "y")[:d]):
        if name in given:
            first, last = (float(v) for v in given[name])
            if not last > first:
                raise InputError.at(f"{key}.{name}", [first, last], "must go from small to large")
            lower[axis], upper[axis] = first, last
    return [Region(lower, upper, label=key, to_border=len(given) < d)]


def read_regions(path, key, terrain=None, attribute=None):
    """Regions of the polygons in a .shp, .geojson or .gpkg file, without overlap: an area shared by two belongs to the
    first.

    terrain: `ReferenceSystem` of the terrain, None where it names none; attribute: see
    `region_files.read_features`. Overlaps and repairs cause warnings. InputError: unreadable, no polygon, a polygon
    without area.
    """
    label = f"{key} = {Path(path).name!r}"
    regions, shared, kept = [], 0.0, []
    for feature in read_features(path, key, terrain, attribute):
        area = Polygons.of(feature.parts, label)
        whole = area.area()
        for other in kept:
            area = area.without(other) if area.area() > 0.0 and area.touches_box(other) else area
        shared += whole - area.area()
        if area.area() > 1e-9 * whole:
            regions.append(Region(*area.bounds(), area, feature.thickness, label, flaw=feature.flaw))
            kept.append(area)
    if shared > 1e-9 * sum(area.area() for area in kept):
        warnings.warn(f"{label}: its polygons overlap: the {shared:.6g} m2 that two of them share count once, with the"
                      " first", stacklevel=2)
    return regions


def inside_region(spec, surface, plan, base_dir, key):
    """Whether plan places (n, 2) [m] lie in a `scenes.regions.Region`; InputError if none does."""
    inside = np.zeros(len(plan), bool)
    for region in regions_of(spec, surface, base_dir, key):
        if region.polygons is None:
            inside |= ((plan >= region.lower) & (plan <= region.upper)).all(axis=1)
        else:
            inside |= region.polygons.contains(plan)
    if not inside.any():
        raise InputError(f"{key}: no cell of the plan grid has its middle in it")
    return inside
