"""Profiles in CAAML (SnowPilot, niViz and others), version 5 and 6: http://caaml.org/Schemas/SnowProfileIACS.

Elements are found by their local names, whatever version their namespace has. Depths are vertical.
"""

import math
from dataclasses import replace
from typing import Any

from snowmpm.errors import InputError, shown_line
from snowmpm.pit.profile import MOST_LAYERS, Layer, SnowProfile, StabilityTest, checked
from snowmpm.quantities.snow_codes import hardness_index
from snowmpm.reading.xml_file import read_xml

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
SIZES = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
DENSITIES = {"kgm-3": 1.0, "kg/m3": 1.0, "kg m-3": 1.0, "gcm-3": 1000.0, "g/cm3": 1000.0}
DEGREES = {"deg": 1.0, "degrees": 1.0, "rad": 180.0 / math.pi}
CELSIUS = {"degC": 1.0, "C": 1.0}
TESTS = {"PropSawTest": "PST", "ExtColumnTest": "ECT", "ComprTest": "CT", "RBlockTest": "RB"}


def read_caaml(path):
    """The profile of a file. Raises InputError, and OSError."""
    root = read_xml(path, namespaces=True)
    measured = root.find(".//SnowProfileMeasurements")
    if measured is None:
        raise InputError(f"{path}: no snow profile in CAAML: has no <SnowProfileMeasurements>")
    if measured.get("dir", "top down") not in ("top down", "bottom up"):  # depthTop is from the surface in both
        raise InputError(f"{path}: dir = {measured.get('dir')!r}: must be \"top down\" or \"bottom up\"")
    found = _Values(path)
    strata = measured.findall("./stratProfile/Layer")
    if len(strata) > MOST_LAYERS or len(measured.findall("./densityProfile/Layer")) > MOST_LAYERS:
        raise InputError(f"{path}: {len(strata)} layers: at most {MOST_LAYERS} layers and densities are read")
    layers = [_layer(found, element, n) for n, element in enumerate(strata, 1)]
    densities = [_density(found, element, n)
                 for n, element in enumerate(measured.findall("./densityProfile/Layer"), 1)]
    place, location = root.find(".//locRef//pos"), root.find(".//locRef")
    name = _text(location.find("./name")) if location is not None else ""
    return checked(SnowProfile(
        name=shown_line(name or path.stem, 100), source=str(path), format="CAAML",
        layers=tuple(with_densities(layers, [one for one in densities if one])),
        time=shown_line(_text(root.find(".//timeRef//timePosition")), 40),
        place=_place(_text(place)),
        elevation=found.number(root.find(".//locRef/validElevation//position"), "elevation"),
        aspect=shown_line(_text(root.find(".//locRef/validAspect//position")), 10),
        slope_angle=found.measure(root.find(".//locRef/validSlopeAngle//position"), DEGREES, "slope angle",
                                  _unit(root.find(".//locRef/validSlopeAngle/SlopeAnglePosition"))),
        temperatures=tuple(_temperatures(found, measured)),
        tests=tuple(_tests(found, measured)),
        notes=tuple(found.notes)))


def with_densities(layers, observed):
    """Layers with the densities that were observed in them, by the thickness that they share.

    observed: [(top [m], bottom [m], density [kg/m3])]. A sample is of a layer where it covers half of it, or where half
    of it lies in it. A layer that has a density of its own keeps it.
    """
    for layer in layers:
        shared = []
        for top, bottom, density in observed:
            length = min(layer.bottom, bottom) - max(layer.top, top)
            if length > 0.0 and length >= 0.499 * min(layer.thickness, bottom - top):
                shared.append((length, density))
        if layer.density is None and shared:
            known = sum(length for length, _ in shared)
            layer = replace(layer, density=sum(length * density for length, density in shared) / known)
        yield layer


class _Values:
    """Numbers of a file, with units; messages name the file and what was read."""

    def __init__(self, path):
        self.path, self.notes = path, []

    def number(self, element: Any, what: str) -> float | None:
        text = _text(element)
        if not text:
            return None
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"{self.path}: {what} = {shown_line(text, 40)!r}: must be a number")
        return value

    def measure(self, element: Any, units: dict[str, float], what: str, unit: str = "") -> float | None:
        """A number in the unit of factor 1. unit: where the element has none."""
        value = self.number(element, what)
        unit = _unit(element) or unit or next(iter(units))
        if value is not None and unit not in units:
            raise InputError(f"{self.path}: {what}: uom = {shown_line(unit, 20)!r}: must be one of {', '.join(units)}")
        return None if value is None else value * units[unit]

    def length(self, element: Any, what: str) -> float | None:
        return self.measure(element, LENGTHS, what, "cm")


def _layer(found, element, n):
    what = f"layer {n}"
    top, thickness = (found.length(element.find(f"./{key}"), f"{what}: {key}") for key in ("depthTop", "thickness"))
    if top is None or thickness is None:
        missing = "depthTop" if top is None else "thickness"
        raise InputError(f"{found.path}: {what}: {missing} is missing")
    hardness = [_text(element.find(f"./{key}")) for key in ("hardness", "hardnessTop", "hardnessBottom")]
    codes = [hardness_index(text) for text in hardness]
    for text, code in zip(hardness, codes, strict=True):
        if text and code is None:
            found.notes.append(f"{what}: hardness {shown_line(text, 20)!r} is no code of the hand test: left out")
    known = [code for code in (codes[1] if codes[1] is not None else codes[0],
                               codes[2] if codes[2] is not None else codes[0]) if code is not None]
    return Layer(
        top=top, bottom=top + thickness, form=_code(element.find("./grainFormPrimary")),
        second_form=_code(element.find("./grainFormSecondary")),
        size=found.measure(element.find("./grainSize/Components/avg"), SIZES, f"{what}: grain size",
                           _unit(element.find("./grainSize"))) or None,
        hardness=(known[0], known[-1]) if known else None,
        density=found.measure(element.find("./density"), DENSITIES, f"{what}: density"),
        moisture=shown_line(_text(element.find("./wetness")), 10),
        concern=any(one.tag == "layerOfConcern" and _text(one).lower() in ("true", "1", "yes")
                    for one in element.iter()),
        comment=shown_line(_text(element.find(".//comment")), 300))


def _density(found, element, n):
    what = f"density {n}"
    top, thickness = (found.length(element.find(f"./{key}"), f"{what}: {key}") for key in ("depthTop", "thickness"))
    density = found.measure(element.find("./density"), DENSITIES, what)
    if density is None or top is None:
        return None
    if thickness is None:
        found.notes.append(f"{what}: has no thickness: left out")
        return None
    return top, top + thickness, density


def _temperatures(found, measured):
    for n, one in enumerate(measured.findall("./tempProfile/Obs"), 1):
        depth = found.length(one.find("./depth"), f"temperature {n}: depth")
        value = found.measure(one.find("./snowTemp"), CELSIUS, f"temperature {n}")
        if depth is not None and value is not None:
            yield depth, value


def _tests(found, measured):
    for element in measured.findall("./stbTests/*"):
        kind = TESTS.get(element.tag)
        if kind is None:
            continue
        depth = found.length(element.find("./failedOn/Layer/depthTop"), f"{kind}: depthTop")
        results = element.find("./failedOn/Results")
        if results is None:
            yield StabilityTest(kind, None, "no failure")
            continue
        result = " ".join(filter(None, (_text(results.find(f"./{key}")) for key in (
            "testScore", "fracturePropagation" if kind == "PST" else "fractureCharacter"))))
        cut, column = (found.length(results.find(f"./{key}"), f"{kind}: {key}")
                       for key in ("cutLength", "columnLength"))
        yield StabilityTest(kind, depth, shown_line(result, 40), cut, column)


def _place(text):
    try:
        latitude, longitude = map(float, text.split())
    except ValueError:
        return None
    return (latitude, longitude) if abs(latitude) <= 90.0 and abs(longitude) <= 360.0 else None


def _text(element):
    return "" if element is None or element.text is None else element.text.strip()


def _unit(element):
    return "" if element is None else (element.get("uom") or "").strip()


def _code(element):
    return shown_line(_text(element), 10)
