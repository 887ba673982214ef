"""A snow profile: layers from the surface down, temperatures, stability tests.

Depths are vertical, from the surface [m], as observers measure them and as CAAML has them. Hardness is the hand
hardness index, 1 fist, 2 four fingers, 3 one finger, 4 pencil, 5 knife, 6 ice; + and - are a third (Fierz et al. 2009,
International Classification for Seasonal Snow on the Ground). Grain forms have the codes of that classification.
"""

import itertools
from dataclasses import dataclass, field

from snowmpm.errors import InputError

ICE_DENSITY = 917.0
"""[kg/m3]"""
LIGHTEST = 10.0
"""Least density that is taken for one of snow [kg/m3]."""
DEEPEST = 100.0
"""Depth [m] beyond which a file has another unit."""
TOLERANCE = 1e-6
"""Overlap of layers that is rounding [m]."""
BORDER = 0.01
"""Distance [m] within which a test belongs to a layer that the observer marked: where two layers meet, observers write
the depth of either."""
STEEPEST = 80.0
"""[degrees]"""


@dataclass(frozen=True)
class Layer:
    """top, bottom: depth [m]; form, second_form: codes, "" where none is known; size [mm]; hardness: index at its top
    and at its bottom; density, as measured [kg/m3]; moisture: D, M, W, V or S; concern: marked by the observer."""

    top: float
    bottom: float
    form: str = ""
    second_form: str = ""
    size: float | None = None
    hardness: tuple[float, float] | None = None
    density: float | None = None
    moisture: str = ""
    concern: bool = False
    comment: str = ""

    @property
    def thickness(self) -> float:
        """[m], vertical"""
        return self.bottom - self.top

    @property
    def middle(self) -> float:
        """Depth [m]"""
        return 0.5 * (self.top + self.bottom)

    @property
    def mean_hardness(self) -> float | None:
        return None if self.hardness is None else 0.5 * sum(self.hardness)


@dataclass(frozen=True)
class StabilityTest:
    """kind: PST, ECT, CT or RB; depth of what failed [m], None where nothing did; result: as observers write it, such
    as "ECTP12" or "End"; cut, column: lengths of a saw test [m]."""

    kind: str
    depth: float | None
    result: str
    cut: float | None = None
    column: float | None = None

    def __str__(self) -> str:
        where = "" if self.depth is None else f" at {100 * self.depth:.0f} cm"
        if self.kind == "PST" and self.cut is not None:
            of = f"/{100 * self.column:.0f}" if self.column else ""
            return f"PST {100 * self.cut:.0f}{of} ({self.result}){where}"
        return (self.result if self.result.startswith(self.kind) else f"{self.kind} {self.result}".strip()) + where


@dataclass(frozen=True)
class SnowProfile:
    """name; source: its file; format; time as text; place (latitude, longitude) [degrees]; elevation [m]; aspect;
    slope_angle [degrees], None where it is not known; layers; temperatures (depth [m], degrees C); tests; notes: what
    its reader had to assume; modelled: by a program, whose grains and hardness have other thresholds."""

    name: str
    source: str
    format: str
    layers: tuple[Layer, ...]
    time: str = ""
    place: tuple[float, float] | None = None
    elevation: float | None = None
    aspect: str = ""
    slope_angle: float | None = None
    temperatures: tuple[tuple[float, float], ...] = ()
    tests: tuple[StabilityTest, ...] = ()
    notes: tuple[str, ...] = field(default=())
    modelled: bool = False

    @property
    def depth(self) -> float:
        """[m]"""
        return self.layers[-1].bottom

    def index_at(self, depth: float) -> int | None:
        """Index of the layer at a depth [m], as tests name it: by the top of the layer that fails, or one that the
        observer marked within BORDER of it; None below the profile."""
        found = None
        for k, layer in enumerate(self.layers):
            if layer.top - TOLERANCE <= depth < layer.bottom - TOLERANCE:
                found = k
            if layer.concern and layer.top - BORDER <= depth <= layer.bottom + BORDER:
                return k
        return found


def checked(profile: SnowProfile) -> SnowProfile:
    """The profile, with its layers from the top down. InputError: no layers, layers that overlap, thicknesses,
    densities, depths, an angle or a test that cannot be."""
    where = profile.source
    if not profile.layers:
        raise InputError(f"{where}: has no layers of snow")
    layers = tuple(sorted(profile.layers, key=lambda layer: (layer.top, layer.bottom)))
    notes = list(profile.notes)
    for n, layer in enumerate(layers, 1):
        what = f"{where}: layer {n}, {_cm(layer)}"
        if not layer.thickness > 0.0:
            raise InputError(f"{what}: thickness = {100 * layer.thickness:g} cm: must be above 0")
        if layer.top < -TOLERANCE or layer.bottom > DEEPEST:
            raise InputError(f"{what}: depth must be from 0 to {DEEPEST:g} m: is its unit right?")
        if layer.density is not None and not LIGHTEST <= layer.density <= ICE_DENSITY:
            raise InputError(f"{what}: density = {layer.density:g} kg/m3: must be from {LIGHTEST:g} to {ICE_DENSITY:g}:"
                             " is its unit right?")
        if layer.hardness and not all(0.5 <= one <= 6.5 for one in layer.hardness):
            raise InputError(f"{what}: hardness = {layer.hardness}: the index is from 1 (fist) to 6 (ice)")
        if layer.size is not None and not 0.0 < layer.size <= 50.0:
            raise InputError(f"{what}: grain size = {layer.size:g} mm: must be above 0 and at most 50")
    for n, (upper, lower) in enumerate(itertools.pairwise(layers), 1):
        if lower.top < upper.bottom - TOLERANCE:
            raise InputError(f"{where}: layers {n} and {n + 1} overlap: {_cm(upper)} and {_cm(lower)}")
        if lower.top > upper.bottom + TOLERANCE:
            notes.append(f"nothing is known from {100 * upper.bottom:.4g} to {100 * lower.top:.4g} cm")
    angle = profile.slope_angle
    if angle is not None and not 0.0 <= angle <= STEEPEST:
        raise InputError(f"{where}: slope angle = {angle:g} degrees: must be from 0 to {STEEPEST:g}")
    for test in profile.tests:
        if test.depth is not None and not 0.0 <= test.depth <= DEEPEST:
            raise InputError(f"{where}: {test.kind} at {test.depth:g} m: depth must be from 0 to {DEEPEST:g} m")
        if test.cut is not None and not 0.0 <= test.cut <= DEEPEST:
            raise InputError(f"{where}: {test.kind}: cut of {test.cut:g} m: must be from 0 to {DEEPEST:g} m")
    return SnowProfile(**{**vars(profile), "layers": layers, "notes": tuple(notes)})


def _cm(layer: Layer) -> str:
    return f"{100 * layer.top:.4g} to {100 * layer.bottom:.4g} cm"
