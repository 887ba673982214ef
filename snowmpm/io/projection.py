"""The projection of a run's map coordinates: its name and its EPSG code."""

from functools import lru_cache

CERTAIN, LIKELY = 70, 20
"""Confidence [%] at which PROJ's look-up is taken as it is, and from which it is taken for the same projection."""


@lru_cache(maxsize=8)
def epsg_of(wkt):
    """EPSG code of a well-known text, or None.

    A text that went through a .prj file has lost details of its datum, and PROJ is no longer certain: it is the system
    of the same name, ellipsoid and parameters then.
    """
    system = _system(wkt)
    if system is None:
        return None
    code = system.to_epsg(min_confidence=CERTAIN)
    if code is not None:
        return code if _same_numbers(system, code) else None
    code = system.to_epsg(min_confidence=LIKELY)
    return code if code is not None and _same_names(system, code) and _same_numbers(system, code) else None


def projection_name(wkt):
    """Name of the projection that a well-known text describes, with its EPSG code where it has one; None without."""
    system = _system(wkt)
    if system is None:
        return None
    code = epsg_of(wkt)
    return system.name.replace("_", " ") + (f" (EPSG:{code})" if code else "")


def _same_names(system, code):
    import pyproj

    found = pyproj.CRS.from_epsg(code)
    return all(_plain(own) == _plain(other) for own, other in (
        (found.name, system.name), (found.datum.name, system.datum.name)))


def _plain(name):
    """Without what .prj files change: blanks, signs, and whether a datum is an ensemble."""
    name = name.removesuffix(" ensemble")
    return "".join(letter for letter in name.casefold() if letter.isalnum())


def _same_numbers(system, code):
    import pyproj

    found = pyproj.CRS.from_epsg(code)
    if system.is_compound or found.is_compound:
        return True
    return _numbers(found) == _numbers(system)


def _numbers(crs):
    """Semi-major axis [m], inverse flattening, prime meridian [degrees], unit of the axes, and the parameters of the
    projection, in whatever order."""
    form, operation, zero = crs.ellipsoid, crs.coordinate_operation, crs.prime_meridian
    values = [one.value * one.unit_conversion_factor for one in operation.params] if operation else []
    axes = sorted(axis.unit_conversion_factor for axis in crs.axis_info[:2])
    values = [form.semi_major_metre, form.inverse_flattening, zero.longitude if zero else 0.0, *axes, *sorted(values)]
    return [round(value, 9) for value in values]


def _system(wkt):
    if not wkt:
        return None
    import pyproj  # takes 0.1 s, which most commands do not need

    try:
        return pyproj.CRS.from_wkt(wkt)
    except (pyproj.exceptions.CRSError, UnicodeError):
        return None
