"""A quantity: its name, unit, definition, and format."""

import math
from dataclasses import dataclass

THIN = "\u202f"
"""Narrow no-break space between groups of three digits."""

PREFIXED = ("Pa", "J", "N", "W", "N m", "J/m", "N/m", "N s", "N s/m")
"""Units that take k, M or G."""


EXTENSIVE = ("J", "N", "kg", "kg m/s", "kg m2/s", "N s", "N m")
"""Units of amounts, which grow with the width of a model."""


def per_width(unit):
    """The unit of an amount in plane strain, per metre of width: J/m of J, kg/m of kg. Densities stay as they are."""
    return f"{unit}/m" if unit in EXTENSIVE else unit


@dataclass(frozen=True)
class Quantity:
    """name: in files, tables and Python; label: in words; unit: SI, as stored ("1": none); definition: what it is, in
    a sentence or two; where: module that computes it; decimals: fixed number of them, or None (`written`)."""

    name: str
    label: str
    unit: str
    definition: str
    where: str
    decimals: int | None = None

    @property
    def heading(self):
        """Label and unit, as over a column: run-out [m]; the label alone without a unit."""
        return self.label if self.unit in ("", "1", "share") else f"{self.label} [{_SHOWN.get(self.unit, self.unit)}]"

    def text(self, value, resolution=None):
        """A value with its unit: 1970 m, 27.3 m/s, 12.4 kPa; with the resolution to which it is known: 1970 ± 5 m."""
        if not resolution or value is None or not math.isfinite(value):
            return written(value, self.unit, self.decimals)
        scaled, unit = _scaled(float(value), self.unit)
        resolution = resolution * (scaled / value if value else 1.0)
        place = math.floor(math.log10(resolution))
        value = round(scaled, -place) + 0.0
        number = f"{value:.{max(0, -place)}f}"
        if self.decimals is None and abs(value) >= 1e4 and place >= 0:
            number = grouped(number)
        known, shown = float(f"{resolution:.1g}"), _SHOWN.get(unit, unit)
        half = grouped(known) if known >= 1e4 else f"{known:g}"
        return f"{number} ± {half}{'' if shown == '°' else ' '}{shown}".rstrip()


_SHOWN = {"1": "", "m2": "m²", "m3": "m³", "degrees": "°", "kg/m3": "kg/m³", "m/s2": "m/s²", "m2/s": "m²/s",
          "m3/s": "m³/s"}
"""Units as they are printed."""


def written(value, unit="1", decimals=None):
    """A number with its unit, formatted for reading.

    All digits before the decimal point are given, and at least three in total; from 10 000 on they are grouped by
    three. decimals: exactly so many, without groups (for coordinates, which are copied). Shares ("share") are in per
    cent, pressures, forces and energies take k, M or G, masses from 10 t on are in tonnes. Not finite: "-".
    """
    if value is None or not math.isfinite(value):
        return "-"
    value, unit = _scaled(float(value), unit)
    number = f"{value:.{decimals}f}" if decimals is not None else digits(value)
    shown = _SHOWN.get(unit, unit)
    return f"{number}{'' if shown == '°' else ' '}{shown}".strip()


def digits(value):
    """A number with at least three digits: 0.0234, 5.27, 84.6, 1970, 12 300; whole ones without decimals."""
    if value == 0.0:
        return "0"
    size = abs(value)
    if size < 1e-4 or size >= 1e15:
        return f"{value:.3g}"
    places = max(0, 2 - math.floor(math.log10(size)))
    text = f"{value:.{places}f}"
    if size < 1e3 and float(value).is_integer():
        text = f"{value:.0f}"
    return grouped(text) if size >= 1e4 else text


def grouped(text):
    """Digits of a whole number in groups of three."""
    return f"{int(text):,}".replace(",", THIN)


def _scaled(value, unit):
    """The value in the unit used for reading."""
    if unit == "share":
        return 100.0 * value, "%"
    if unit == "kg" and abs(value) >= 1e4:
        return value / 1e3, "t"
    if unit in PREFIXED:
        for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
            if abs(value) >= factor:
                return value / factor, prefix + unit
    return value, unit
