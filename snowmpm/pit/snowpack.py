"""Profiles in SNOWPACK's .pro: one a time step, elements from the bottom up.

A line is `code,n,value,...`. Heights (0501) are of the tops of elements [cm], vertical, negative below the ground;
`0501,1,0` is ground without snow. Other codes have a value an element, of soil as well or of snow alone, and the grain
type one more, of the surface; so values are taken from the top.
"""

import math

from snowmpm.errors import InputError, shown_line
from snowmpm.pit.profile import Layer, SnowProfile, checked
from snowmpm.quantities.snow_codes import of_swiss
from snowmpm.reading.limited import read_text_limited

HEIGHT, DENSITY, TEMPERATURE, SIZE, GRAIN, HAND = "0501", "0502", "0503", "0512", "0513", "0534"
MAX_BYTES = 512 << 20
CODES = (HEIGHT, DENSITY, TEMPERATURE, SIZE, GRAIN, HAND)
LARGEST_INDEX = 6.0
"""Of hand hardness; larger values are forces [N], as a setting of SNOWPACK has it."""


def read_pro(path, time=None):
    """The last profile that has snow, or that of `time`, as the file writes it (30.01.2004 12:00:00) or its date.

    Raises InputError, and OSError.
    """
    lines = read_text_limited(path, MAX_BYTES).splitlines()
    station, steps = _parsed(path, lines)
    if not steps:
        raise InputError(f"{path}: no profiles: has no line 0500 below [DATA]")
    snowy = [step for step in steps if _tops(path, step)]
    if not snowy:
        raise InputError(f"{path}: none of its {len(steps)} profiles has snow")
    if time is None:
        step = snowy[-1]
    else:
        step = next((one for one in snowy if one["time"].startswith(time)), None)
        if step is None:
            raise InputError(f"{path}: --time {time}: no profile with snow at that time; it has {snowy[0]['time']} to"
                             f" {snowy[-1]['time']}")
    notes = [f"{len(snowy)} profiles with snow in the file: that of {step['time']} is taken"] if len(snowy) > 1 else []
    return checked(_profile(path, station, step, notes))


def _parsed(path, lines):
    station, steps, part = {}, [], ""
    for n, line in enumerate(lines, 1):
        line = line.strip()
        if line.startswith("["):
            part = line.strip("[]").upper()
        elif part == "STATION_PARAMETERS" and "=" in line:
            key, _, value = line.partition("=")
            station[key.strip()] = value.strip()
        elif part == "DATA" and line:
            code, _, rest = line.partition(",")
            if code == "0500":
                steps.append({"time": shown_line(rest.strip(), 40)})
            elif code in CODES and not steps:
                raise InputError(f"{path}: line {n}: {code} before any date (0500)")
            elif code in CODES:
                steps[-1][code] = n, rest
    return station, steps


def _values(path, step, code):
    """Numbers of a line; -> (n,) without the count before them, None where there is no line."""
    if code not in step:
        return None
    n, rest = step[code]
    try:
        count, *values = map(float, rest.split(","))
    except ValueError:
        raise InputError(f"{path}: line {n}: {shown_line(rest, 40)!r}: must be numbers with commas between") from None
    if count != len(values) or not all(map(math.isfinite, values)):
        raise InputError(f"{path}: line {n}: {len(values)} values, and {count:g} are announced: is the file cut off?")
    return values


def _tops(path, step):
    return [value for value in _values(path, step, HEIGHT) or [] if value > 0.0]


def _profile(path, station, step, notes):
    tops = _tops(path, step)
    bottoms, height = [0.0, *tops[:-1]], tops[-1]
    if any(top <= bottom for top, bottom in zip(tops, bottoms, strict=True)):
        raise InputError(f"{path}: line {step[HEIGHT][0]}: heights of elements must grow from the bottom up")

    elements = len(_values(path, step, DENSITY) or tops)

    def of(code, surface=False):
        values = _values(path, step, code)
        if values is None:
            return [None] * len(tops)
        if surface and len(values) in (len(tops) + 1, elements + 1):
            values = values[:-1]
        if len(values) < len(tops):
            raise InputError(f"{path}: line {step[code][0]}: {len(values)} values for {len(tops)} elements of snow")
        return values[-len(tops):]

    density, size, hand, warmth = of(DENSITY), of(SIZE), of(HAND), of(TEMPERATURE)
    grains = of(GRAIN, surface=True)
    if any(value is not None and abs(value) > LARGEST_INDEX for value in hand):
        notes.append("hand hardness is in newtons: left out")
        hand = [None] * len(tops)
    layers = []
    for k in reversed(range(len(tops))):
        index = None if hand[k] is None else abs(hand[k])
        layers.append(Layer(
            top=0.01 * (height - tops[k]), bottom=0.01 * (height - bottoms[k]),
            form="" if grains[k] is None or not 0 <= grains[k] < 1000 else of_swiss(int(grains[k])),
            size=size[k] if size[k] and size[k] > 0.0 else None,  # -999: none
            hardness=(index, index) if index and index >= 0.5 else None, density=density[k]))
    latitude, longitude, angle, altitude = (
        _station(path, station, key) for key in ("Latitude", "Longitude", "SlopeAngle", "Altitude"))
    return SnowProfile(
        name=shown_line(station.get("StationName", path.stem), 100), source=str(path), format="SNOWPACK",
        layers=tuple(layers), time=step["time"], elevation=altitude, slope_angle=angle,
        place=None if latitude is None or longitude is None else (latitude, longitude),
        aspect=shown_line(station.get("SlopeAzi", ""), 10), modelled=True, notes=tuple(notes),
        temperatures=tuple((layer.middle, value) for layer, value in zip(layers, reversed(warmth), strict=True)
                           if value is not None))


def _station(path, station, key):
    if key not in station:
        return None
    try:
        value = float(station[key])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}: {key} = {shown_line(station[key], 40)!r}: must be a number")
    return value
