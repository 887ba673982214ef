"""How thick a release is: a number, a raster, or the snow of three days by altitude and slope.

    d = (d* + w) f(psi),   d* = (H + G (z - z0) / 100 m) cos 28°,   f = 0.291 / (sin psi - 0.202 cos psi), at most 1

Salm, Burkard and Gubler (1990), Berechnung von Fliesslawinen, Mitteilungen des SLF 47: H [m], the increase of the snow
depth within three days at the altitude z0, of the return period; G, its increase a hundred metres of altitude; w, snow
drifted by wind, that grows from 0 at 1000 m to its whole at 2000 m; psi, the mean slope of the area; d normal to the
slope. f is 1 at 28 degrees.
"""

import math
from dataclasses import replace
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from snowmpm.scenes.spec import Number, Spec, refuse

LEVEL = 28.0
"""Slope [degrees] at which f is 1."""
CALM, WINDY = 1000.0, 2000.0
"""Altitudes [m] from which drifted snow begins, and is whole."""
THINNEST, MOST = 0.1, 10.0
"""Least and largest thickness [m]."""


class Thickness(Spec):
    """How thick releases are, normal to the slope: one of value, file and three_day_snow."""

    EXAMPLES: ClassVar = {"value": 1.2, "file": "d0.tif"}

    value: Annotated[Number, Field(gt=0.0, le=MOST)] | None = None
    """of all releases [m]"""
    file: Annotated[str, Field(strict=True, min_length=1)] | None = None
    """raster of thickness [m], relative to the file of the region; an area has its mean"""
    three_day_snow: Annotated[Number, Field(gt=0.0, le=MOST)] | None = None
    """increase of the snow depth within three days at reference_altitude [m]"""
    reference_altitude: Number = 2000.0
    """of three_day_snow [m]"""
    gradient: Number = 0.05
    """increase of three_day_snow a hundred metres of altitude [m]"""
    wind: Annotated[Number, Field(ge=0.0, le=MOST)] = 0.0
    """snow drifted by wind, from 2000 m on [m]"""

    @model_validator(mode="after")
    def _one(self):
        if sum(one is not None for one in (self.value, self.file, self.three_day_snow)) != 1:
            raise refuse("needs one of value, file, three_day_snow")
        return self


def slope_factor(slope):
    """f of a slope [degrees]."""
    psi = math.radians(slope)
    return min(1.0, 0.291 / max(math.sin(psi) - 0.202 * math.cos(psi), 1e-9)) if slope > LEVEL else 1.0


def guideline(given, altitude, slope):
    """Thickness [m], normal to the slope, of a `Thickness` with three_day_snow, at an altitude [m], on a slope."""
    depth = given.three_day_snow + given.gradient * (altitude - given.reference_altitude) / 100.0
    drifted = given.wind * min(max((altitude - CALM) / (WINDY - CALM), 0.0), 1.0)
    return max(THINNEST, (max(depth, 0.0) * math.cos(math.radians(LEVEL)) + drifted) * slope_factor(slope))


def of(area, given, mean=None):
    """The area with its thickness. mean: function of a geometry -> mean [m] of the raster over it."""
    if given.value is not None:
        return replace(area, thickness=given.value)
    if given.file is not None:
        return replace(area, thickness=mean(area.geometry))
    return replace(area, thickness=guideline(given, area.altitude, area.slope))
