"""Coordinate reference systems: projection, unit, and transformation to another system."""

import re
from functools import cached_property

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import companion

LARGEST_TEXT = 100_000
"""Largest size of a .prj file [bytes]."""

SCALE = 0.03
"""Largest relative difference between a metre on the map and on the ground: projections for surveys differ by 0.001,
national ones by 0.01, Web Mercator in the Alps by 0.47."""

SAME = 1e-3
"""Difference of coordinates [m] below which two systems count as the same."""

DEGREES = 360.0, 90.0
"""Largest longitude and latitude."""

LEAST_EXTENT = 2.0
"""Extent [m] below which a map with coordinates that could be degrees has degrees."""

FAR = 10.0
"""Degrees outside the area that a system is made for from which on its name is doubted."""

NAMED = re.compile(r"(?:urn:ogc:def:crs:)?(EPSG|OGC|ESRI|IAU_2015)(?::[\d.]*)?:{1,2}(\w+)", re.IGNORECASE)


class ReferenceSystem:
    """Reference system of coordinates x, y (east, north), and of heights where it has one.

    crs: a `pyproj.CRS`. `of_text` and `named` create one, and refuse invalid input.
    """

    def __init__(self, crs):
        parts = crs.sub_crs_list if crs.is_compound else [crs]
        self._plan = parts[0].to_2d() if len(parts[0].axis_info) == 3 else parts[0]
        self._heights = [axis for part in parts for axis in part.axis_info if axis.direction == "up"]

    @classmethod
    def of_text(cls, text, where):
        """System of a text: well-known text, in the dialect of whatever program. InputError, which begins with `where`,
        for a text that is none."""
        pyproj = _pyproj()
        try:
            return cls(pyproj.CRS.from_wkt(text))
        except (pyproj.exceptions.CRSError, UnicodeError) as error:
            raise InputError(f"{where}: names no coordinate system that PROJ knows; write it anew with a GIS, or take"
                             " it away if coordinates are metres") from error

    @classmethod
    def named(cls, name, where):
        """System of a name such as EPSG:31287 or urn:ogc:def:crs:EPSG::31287, axes east, north; InputError."""
        pyproj = _pyproj()
        found = NAMED.fullmatch(str(name)[:200])
        try:
            return cls(pyproj.CRS.from_authority(found[1].upper(), found[2].upper()))
        except (TypeError, pyproj.exceptions.CRSError) as error:
            raise InputError(f"{where}: {str(name)[:60]!r}: must be the name of a coordinate system, as"
                             " urn:ogc:def:crs:EPSG::31287") from error

    @property
    def name(self):
        return self._plan.name

    @property
    def is_geographic(self):
        """Whether x and y are degrees."""
        return self._plan.is_geographic

    @property
    def is_map(self):
        """Whether x and y are lengths on a map of the Earth, or of no known place."""
        return self._plan.is_projected or self._plan.is_engineering

    @property
    def metre(self):
        """Metres in a unit of x and y."""
        return float(self._plan.axis_info[0].unit_conversion_factor) if self._plan.axis_info else 1.0

    @property
    def unit(self):
        """Name of the unit of x and y."""
        if self.is_geographic:
            return "degrees"
        return self._plan.axis_info[0].unit_name if self._plan.axis_info else "metre"

    @property
    def height_metre(self):
        """Metres in a unit of heights; None where the system has no heights."""
        return float(self._heights[0].unit_conversion_factor) if self._heights else None

    @property
    def wkt(self):
        """The system of x and y as well-known text."""
        return self._plan.to_wkt()

    @cached_property
    def in_metres(self):
        """This system with x and y in metres: `metre` times the coordinates of this one."""
        if self.metre == 1.0 or self.is_geographic:
            return self
        described = self._plan.to_json_dict()
        for axis in described["coordinate_system"]["axis"]:
            axis["unit"] = "metre"
        described.pop("id", None)
        described["name"] = f"{self.name} in metres"
        return ReferenceSystem(_pyproj().CRS.from_json_dict(described))

    def carried(self, points, to):
        """Coordinates (n, 2) of this system in the system `to`; not finite if no transformation exists. Unchanged if
        both systems agree within SAME."""
        pyproj = _pyproj()
        if self._plan == to._plan:
            return points
        try:
            change = pyproj.Transformer.from_crs(self._plan, to._plan, always_xy=True)
            moved = np.column_stack(change.transform(points[:, 0], points[:, 1]))
        except pyproj.exceptions.ProjError:
            return np.full_like(points, np.nan)
        same = self.is_map and to.is_map and np.abs(moved - points).max(initial=0.0) < SAME
        return points if same else moved

    def contradiction(self, x, y):
        """What coordinates x, y (in this system, as the file says) show to be wrong with it, "" where nothing is.

        Degrees beyond 360 and 90 are none. Lengths within these that span less than LEAST_EXTENT are degrees.
        """
        x, y = (np.asarray(values, float) for values in (x, y))
        x, y = x[np.isfinite(x)], y[np.isfinite(y)]
        if not len(x) or not len(y):
            return ""
        at = f"x = {x[0]:.10g}, y = {y[0]:.10g}"
        could_be = np.abs(x).max() <= DEGREES[0] and np.abs(y).max() <= DEGREES[1]
        if self.is_geographic and not could_be:
            return f"its coordinates, such as {at}, are no degrees"
        if self.is_map and could_be and max(np.ptp(x), np.ptp(y)) * self.metre < LEAST_EXTENT and np.ptp(x) + np.ptp(y):
            return f"its coordinates, such as {at}, look like degrees"
        return ""

    def far_off(self, x, y):
        """Degrees by which one position lies outside the area that the system is made for; 0 where none is known."""
        area = self._plan.area_of_use
        if area is None:
            authority = self._plan.to_authority(min_confidence=70)
            area = authority and _pyproj().CRS.from_authority(*authority).area_of_use
        if not area or not self.is_map:
            return 0.0
        longitude, latitude = self.carried(np.array([[x, y]], float), WORLD())[0]
        if not np.isfinite([longitude, latitude]).all():
            return 180.0
        west, south, east, north = area.bounds
        middle = 0.5 * (west + east) if east >= west else 0.5 * (west + east) + 180.0
        half = 0.5 * (east - west) if east >= west else 0.5 * (east - west) + 180.0
        beside = abs((longitude - middle + 180.0) % 360.0 - 180.0) - half
        return float(max(beside, south - latitude, latitude - north, 0.0))

    def scale(self, x, y):
        """Scale factor (map over ground) at one position, the larger of both directions; None if unknown."""
        pyproj = _pyproj()
        if not self._plan.is_projected:
            return None
        try:
            project = pyproj.Proj(self._plan)
            factors = project.get_factors(*project(x, y, inverse=True))
        except pyproj.exceptions.ProjError:
            return None
        scales = np.array([factors.meridional_scale, factors.parallel_scale])
        return float(scales[np.argmax(np.abs(scales - 1.0))]) if np.isfinite(scales).all() else None

    def projected_here(self, x, y):
        """Name of a projection in metres that suits one place: the zone of UTM."""
        longitude, latitude = self.carried(np.array([[x, y]], float), WORLD())[0]
        if not np.isfinite([longitude, latitude]).all():
            return "EPSG:32632"
        zone = int((longitude + 180.0) % 360.0 // 6.0) + 1
        return f"EPSG:{(32600 if latitude >= 0.0 else 32700) + zone}"


def WORLD():
    """Longitude and latitude on WGS 84, in degrees: what GeoJSON is in unless it says otherwise (RFC 7946)."""
    return ReferenceSystem(_pyproj().CRS.from_authority("OGC", "CRS84"))


def system_beside(path):
    """System that the .prj file beside a file names, as other programs write it; None without one. InputError."""
    file = companion(path, ".prj")
    if file is None:
        return None
    if file.stat().st_size > LARGEST_TEXT:
        raise InputError(f"{file}: has {file.stat().st_size} bytes: must be a coordinate system, in text")
    try:
        text = file.read_text(encoding="utf-8-sig", errors="replace").strip()
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror})") from error
    return ReferenceSystem.of_text(text, file) if text else None


def _pyproj():
    """The library, which takes a tenth of a second to import. It never asks the network for grids of datum shifts."""
    import pyproj
    import pyproj.network

    pyproj.network.set_network_enabled(False)
    return pyproj
