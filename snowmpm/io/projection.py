"""The projection of a run's map coordinates: its name and its EPSG code."""


from functools import lru_cache


@lru_cache(maxsize=8)
def epsg_of(wkt):
    """EPSG code of a well-known text, or None."""
    system = _system(wkt)
    return system.to_epsg() if system is not None else None


def projection_name(wkt):
    """Name of the projection that a well-known text describes, with its EPSG code where it has one; None without."""
    system = _system(wkt)
    if system is None:
        return None
    code = epsg_of(wkt)
    return system.name.replace("_", " ") + (f" (EPSG:{code})" if code else "")


def _system(wkt):
    if not wkt:
        return None
    import pyproj  # takes 0.1 s, which most commands do not need

    try:
        return pyproj.CRS.from_wkt(wkt)
    except (pyproj.exceptions.CRSError, UnicodeError):
        return None
