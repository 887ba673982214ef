"""Profiles in a CSV of our own: one line a layer, from the surface down.

    # slope_angle = 36
    top [cm], bottom [cm], form, size [mm], hardness, density [kg/m3]
    0, 20, PP, 1.0, F, 110
    20, 45, RG, 0.3, 1F,
    # test = PST, depth [cm] 45, cut [cm] 38, column [cm] 100, End

Columns in any order; of top, bottom and thickness two, or thickness alone; all others may be missing. A unit in
brackets is converted. Lines that begin with # and have `key = value` tell of the profile: KEYS, and one `test` each.
"""

import csv
import math
import re

from snowmpm.errors import InputError, did_you_mean, shown_line
from snowmpm.pit.caaml import DENSITIES, LENGTHS, SIZES
from snowmpm.pit.profile import Layer, SnowProfile, StabilityTest, checked
from snowmpm.quantities.snow_codes import hardness_index, main_class
from snowmpm.reading.limited import read_text_limited

COLUMNS = {"top": LENGTHS, "bottom": LENGTHS, "thickness": LENGTHS, "size": SIZES, "density": DENSITIES, "form": None,
           "second_form": None, "hardness": None, "moisture": None, "comment": None}
"""Units of each; None: a text."""
USUAL = {"top": "cm", "bottom": "cm", "thickness": "cm", "size": "mm", "density": "kg/m3"}
"""Units where none is given."""
KEYS = ("name", "time", "elevation", "aspect", "slope_angle", "latitude", "longitude", "test")
MAX_BYTES = 1 << 20
CODE = re.compile(r"[A-Za-z]{2,6}")
"""Of a grain form."""
UNITS = {"elevation": "m", "slope_angle": "degrees", "latitude": "degrees", "longitude": "degrees"}
KINDS = ("PST", "ECT", "CT", "RB")


def read_csv(path):
    """The profile of a file. Raises InputError, and OSError."""
    lines = read_text_limited(path, MAX_BYTES).splitlines()
    about, tests, rows = {}, [], []
    for n, line in enumerate(lines, 1):
        if line.lstrip().startswith("#"):
            key, equal, value = line.lstrip("# \t").partition("=")
            key = key.strip()
            if not equal:
                continue
            if key not in KEYS:
                near = did_you_mean(key, KEYS)
                if not near:
                    continue  # a sentence
                raise InputError(f"{path}: line {n}: {shown_line(key, 40)}: no key of a profile{near}")
            if key == "test":
                tests.append(_test(path, n, value))
            else:
                about[key] = shown_line(value.strip(), 100)
        elif line.strip():
            rows.append((n, line))
    if len(rows) < 2:
        raise InputError(f"{path}: needs a line of column names and a line for each layer")
    columns = _columns(path, *rows[0])
    layers, depth = [], 0.0
    for n, line in rows[1:]:
        layers.append(_layer(path, n, line, columns, depth))
        depth = layers[-1].bottom
    latitude, longitude = _number(path, about, "latitude"), _number(path, about, "longitude")
    return checked(SnowProfile(
        name=about.get("name", shown_line(path.stem, 100)), source=str(path), format="CSV", layers=tuple(layers),
        time=about.get("time", ""), place=None if latitude is None or longitude is None else (latitude, longitude),
        elevation=_number(path, about, "elevation"), aspect=about.get("aspect", ""),
        slope_angle=_number(path, about, "slope_angle"), tests=tuple(tests)))


def _columns(path, n, line):
    """[(name, factor or None)] of the first line."""
    found = []
    for cell in _cells(path, n, line):
        name, bracket, rest = cell.partition("[")
        name, unit = name.strip().lower(), rest.partition("]")[0].strip()
        if name not in COLUMNS:
            raise InputError(f"{path}: column {shown_line(name, 40)}: must be one of {', '.join(COLUMNS)}"
                             f"{did_you_mean(name, COLUMNS)}")
        if name in dict(found):
            raise InputError(f"{path}: column {name}: twice")
        units = COLUMNS[name]
        unit = unit if bracket else USUAL.get(name, "")
        if units is not None and unit not in units:
            raise InputError(f"{path}: column {name}: unit {shown_line(unit, 20)!r}: must be one of {', '.join(units)}")
        found.append((name, None if units is None else units[unit]))
    names = dict(found)
    if not ({"top", "bottom"} <= names.keys() or "thickness" in names):
        semicolons = "; cells are separated by commas, not semicolons" if ";" in line else ""
        raise InputError(f"{path}: columns must have top and bottom, or thickness{semicolons}")
    return found


def _layer(path, n, line, columns, depth):
    cells = _cells(path, n, line)
    if len(cells) > len(columns):
        raise InputError(f"{path}: line {n}: {len(cells)} cells for {len(columns)} columns")
    texts = dict(zip((name for name, _ in columns), cells, strict=False))
    values = {}
    for name, factor in columns:
        text = texts.get(name, "")
        if factor is None or not text:
            continue
        try:
            values[name] = float(text) * factor
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise InputError(f"{path}: line {n}: {name} = {shown_line(text, 40)!r}: must be a number")
    top = values.get("top", depth)
    bottom = values.get("bottom", top + values["thickness"] if "thickness" in values else None)
    if bottom is None:
        raise InputError(f"{path}: line {n}: neither bottom nor thickness")
    form, hardness = texts.get("form", ""), texts.get("hardness", "")
    second = texts.get("second_form", "")
    for text, name, sound in (
            (form, "form", CODE.fullmatch(form) and main_class(form)),
            (second, "form", CODE.fullmatch(second) and main_class(second)),
            (hardness, "hardness", hardness_index(hardness))):
        if text and not sound:
            raise InputError(f"{path}: line {n}: {name} = {shown_line(text, 20)!r}: must be "
                             + ("a code such as PP, DF, RG, FC, DH, SH, MF, MFcr, IF" if name == "form" else
                                "F, 4F, 1F, P, K or I, with + or -, or an index from 1 to 6"))
    index = hardness_index(hardness)
    return Layer(top, bottom, form, second, values.get("size"),
                 None if index is None else (index, index), values.get("density"),
                 shown_line(texts.get("moisture", ""), 10), comment=shown_line(texts.get("comment", ""), 300))


def _test(path, n, text):
    """`PST, depth [cm] 45, cut [cm] 38, column [cm] 100, End`"""
    kind, *parts = (part.strip() for part in text.split(","))
    if kind not in KINDS:
        raise InputError(f"{path}: line {n}: test = {shown_line(kind, 20)!r}: must begin with one of"
                         f" {', '.join(KINDS)}")
    lengths, words = {}, []
    for part in parts:
        if found := re.fullmatch(r"(depth|cut|column)\s*\[(\w+)\]\s*([-+.\deE]+)", part):
            if found[2] not in LENGTHS:
                raise InputError(f"{path}: line {n}: {found[1]}: unit {found[2]!r}: must be one of"
                                 f" {', '.join(LENGTHS)}")
            try:
                lengths[found[1]] = float(found[3]) * LENGTHS[found[2]]
            except ValueError:
                raise InputError(f"{path}: line {n}: {shown_line(part, 40)!r}: must be a number") from None
        elif re.match(r"(depth|cut|column)\b", part):
            raise InputError(f"{path}: line {n}: {shown_line(part, 40)!r}: must be as depth [cm] 45")
        elif part:
            words.append(part)
    return StabilityTest(kind, lengths.get("depth"), shown_line(" ".join(words), 40), lengths.get("cut"),
                         lengths.get("column"))


def _cells(path, n, line):
    try:
        return [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))]
    except csv.Error as error:
        raise InputError(f"{path}: line {n}: not a table of text ({error})") from None


def _number(path, about, key):
    if key not in about:
        return None
    try:
        value = float(about[key])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}: {key} = {about[key]!r}: must be a number without a unit, in {UNITS[key]}")
    return value
