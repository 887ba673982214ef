"""Units of elevation rasters: factors to metres for coordinates and heights, or the reason for refusal."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain.reference_system import FAR, SCALE

FOOT, SURVEY_FOOT = 0.3048, 1200.0 / 3937.0

UNITS = {"m": 1.0, "ft": FOOT, "us-ft": SURVEY_FOOT}
"""Metres in each unit that a scene may name."""

SPELLINGS = {
    1.0: ("m", "metre", "metres", "meter", "meters"),
    FOOT: ("ft", "foot", "feet", "international foot", "international feet"),
    SURVEY_FOOT: ("us-ft", "ftus", "us ft", "us foot", "us feet", "survey foot", "us survey foot", "us survey feet",
                  "foot us", "foot_us", "us_survey_foot"),
    0.1: ("dm", "decimetre", "decimeter"),
    0.01: ("cm", "centimetre", "centimeter", "centimetres", "centimeters"),
    0.001: ("mm", "millimetre", "millimeter", "millimetres", "millimeters"),
    1000.0: ("km", "kilometre", "kilometer", "kilometres", "kilometers"),
    0.0254: ("in", "inch", "inches"),
}
METRES = {spelling: metres for metres, spellings in SPELLINGS.items() for spelling in spellings}
"""Metres in a unit of length, by the spellings that programs use, in lower case."""

ASSIGN = ("the tag is wrong; name the right system (.tif: `rio edit-info --crs EPSG:... FILE`; .prj: with a GIS), or"
          " take it away if coordinates are metres")

STEEPEST = 10.0
"""Height over extent in plan beyond which x and y without a system are degrees rather than metres."""


def plan_metres(system, x, y, where):
    """Metres in a unit of x and y of a raster; 1 where it names no system.

    x, y: ends of its axes, as they are in the file; where: how a message begins. InputError: degrees, a projection
    whose metres are not metres on the ground, a system that the coordinates contradict.
    """
    if system is None:
        return 1.0
    if wrong := system.contradiction(x, y):
        raise InputError(f"{where}: is tagged {system.name}, but {wrong}: {ASSIGN}")
    centre = 0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1])
    if system.is_geographic or not system.is_map:
        what = "degrees" if system.is_geographic else "no projection"
        raise InputError(f"{where}: is in {what} ({system.name}): project it to metres, as {_command(system, centre)}")
    scale = system.scale(*centre)
    if scale is not None and abs(scale - 1.0) > SCALE:
        if doubt := doubted(system, *centre):
            raise InputError(f"{where}: {doubt.partition(':')[0]}: {ASSIGN}")
        raise InputError(f"{where}: a metre on the ground is {scale:.3g} m of {system.name}: project it to metres on"
                         f" the ground, as {_command(system, centre)}")
    return system.metre


def height_metres(given, band_unit, system, where):
    """Metres in a unit of height: as the scene says (`given`, a key of UNITS), else the band, else the system; for a
    file in metres that names none, metres. InputError: a unit that is no length, or plan in feet without a unit of
    heights."""
    if given is not None:
        return UNITS[given]
    if band_unit:
        metres = METRES.get(band_unit.strip().lower().replace(".", ""))
        if metres is None:
            raise InputError(f"{where}: its values are in {band_unit[:40]!r}: must be elevations, in a unit of length")
        return metres
    if system is None:
        return 1.0
    if system.height_metre is not None:
        return system.height_metre
    if system.metre != 1.0:
        raise InputError(f"{where}: x and y are in {system.unit}, and it does not say in what its elevations are: give"
                         f" terrain.elevation_unit, one of {', '.join(UNITS)}")
    return 1.0


def length_metres(band_unit):
    """Metres in a unit of a band that is no elevation, 1 where it names none or no length."""
    return METRES.get((band_unit or "").strip().lower().replace(".", ""), 1.0)


def doubted(system, x, y):
    """A warning where a place lies far outside the area that a system is made for, "" elsewhere."""
    off = system.far_off(x, y) if system is not None else 0.0
    return f"lies {off:.0f} degrees outside the area of {system.name}: is this system right?" if off > FAR else ""


def refuse_unnamed_degrees(raster, where):
    """Refuse a raster without a system whose x and y can only be degrees: within 360 and 90, steeper than any ground.
    InputError."""
    east, north = np.abs(raster.x).max(), np.abs(raster.y).max()
    extent = np.hypot(np.ptp(raster.x), np.ptp(raster.y))
    height = np.nanmax(raster.z) - np.nanmin(raster.z)
    if east <= 360.0 and north <= 90.0 and height > STEEPEST * extent:
        raise InputError(f"{where}: is {height:.4g} m high on {extent:.4g} m in plan: x and y look like degrees;"
                         " project it to metres")


def converted(plan, height, what="elevations"):
    """Text on the conversions, "" if there were none; what: the values of the raster."""
    said = []
    if plan != 1.0:
        said.append(f"x and y are converted to metres ({plan:.10g} m a unit)")
    if height != 1.0:
        said.append(f"{what} are converted to metres ({height:.10g} m a unit)")
    return "; ".join(said)


def _command(system, centre):
    return f"`rio warp FILE OUT.tif --dst-crs {system.projected_here(*centre)} --resampling bilinear` does"
