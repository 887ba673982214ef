"""A snow profile: layers from the surface down, temperatures, stability tests.

Depths are vertical, from the surface [m], as observers measure them and as CAAML has them. Hardness is the hand
hardness index, 1 fist, 2 four fingers, 3 one finger, 4 pencil, 5 knife, 6 ice; + and - are a third (Fierz et al. 2009,
International Classification for Seasonal Snow on the Ground). Grain forms have the codes of that classification.
"""

import itertools
from dataclasses import dataclass, field, replace

from snowmpm.errors import InputError
from snowmpm.quantities.snow_codes import main_class

ICE_DENSITY = 917.0
"""[kg/m3]"""
LIGHTEST = 10.0
"""Least density that is taken for one of snow [kg/m3]."""
DEEPEST = 100.0
"""Depth [m] beyond which a file has another unit."""
MOST_LAYERS, MOST_TESTS = 1000, 200
"""That a profile may have: an observer writes ten to thirty."""
FINEST, COARSEST = 0.01, 50.0
"""Grain sizes [mm]."""
COLDEST, WARMEST = -80.0, 5.0
"""Snow temperatures [degrees C]."""
TOLERANCE = 1e-6
"""Overlap of layers that is rounding [m]."""
BORDER = 0.01
"""Distance [m] within which a test belongs to a layer that the observer marked: where two layers meet, observers write
the depth of either."""
WET = ("M", "W", "V", "S")
"""First letters of moisture from moist to soaked."""
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

    def index_at(self, depth: float, marked: bool = True) -> int | None:
        """Index of the layer at a depth [m]; None below the profile. marked: a layer that the observer marked within
        BORDER of it goes first, as for the depth of a test."""
        found = None
        for k, layer in enumerate(self.layers):
            if layer.top - TOLERANCE <= depth < layer.bottom - TOLERANCE:
                found = k
            if marked and layer.concern and layer.top - BORDER <= depth <= layer.bottom + BORDER:
                return k
        return found


def checked(profile: SnowProfile) -> SnowProfile:
    """The profile, with its layers from the top down. InputError: no layers, layers that overlap, thicknesses,
    densities, depths, an angle or a test that cannot be."""
    where = profile.source
    if not profile.layers:
        raise InputError(f"{where}: has no layers of snow")
    if len(profile.layers) > MOST_LAYERS or len(profile.tests) > MOST_TESTS:
        raise InputError(f"{where}: {len(profile.layers)} layers and {len(profile.tests)} tests: at most {MOST_LAYERS}"
                         f" and {MOST_TESTS} are read")
    layers = tuple(sorted(profile.layers, key=lambda layer: (layer.top, layer.bottom)))
    notes = list(profile.notes)
    for n, layer in enumerate(layers, 1):
        what = f"{where}: layer {n}, {_cm(layer)}"
        if not layer.thickness > 0.0:
            raise InputError(f"{what}: thickness = {100 * layer.thickness:g} cm: must be above 0; depths count from"
                             " the surface down")
        if layer.top < -TOLERANCE or layer.bottom > DEEPEST:
            raise InputError(f"{what}: depth must be from 0 to {DEEPEST:g} m: is its unit right?")
        if layer.density is not None and not LIGHTEST <= layer.density <= ICE_DENSITY:
            raise InputError(f"{what}: density = {layer.density:g} kg/m3: must be from {LIGHTEST:g} to {ICE_DENSITY:g}:"
                             " is its unit right?")
        if layer.hardness and not all(0.5 <= one <= 6.5 for one in layer.hardness):
            raise InputError(f"{what}: hardness = {layer.hardness}: the index is from 1 (fist) to 6 (ice)")
        if layer.size is not None and not FINEST <= layer.size <= COARSEST:
            raise InputError(f"{what}: grain size = {layer.size:g} mm: must be from {FINEST:g} to {COARSEST:g}")
    for n, (upper, lower) in enumerate(itertools.pairwise(layers), 1):
        if lower.top < upper.bottom - TOLERANCE:
            raise InputError(f"{where}: layers {n} and {n + 1} overlap: {_cm(upper)} and {_cm(lower)}")
        if lower.top > upper.bottom + TOLERANCE:
            notes.append(f"nothing is known from {100 * upper.bottom:.4g} to {100 * lower.top:.4g} cm: taken as the"
                         " layer below it")
    if layers[0].top > TOLERANCE:
        notes.append(f"nothing is known of the uppermost {100 * layers[0].top:.4g} cm: taken as the layer below it")
    angle = profile.slope_angle
    if angle is not None and not 0.0 <= angle <= STEEPEST:
        raise InputError(f"{where}: slope angle = {angle:g} degrees: must be from 0 to {STEEPEST:g}")
    if profile.elevation is not None and not -500.0 <= profile.elevation <= 9000.0:
        raise InputError(f"{where}: elevation = {profile.elevation:g} m: must be from -500 to 9000")
    if profile.place is not None and not (abs(profile.place[0]) <= 90.0 and abs(profile.place[1]) <= 360.0):
        raise InputError(f"{where}: latitude, longitude = {profile.place[0]:g}, {profile.place[1]:g}: must be degrees")
    for depth, value in profile.temperatures:
        if not 0.0 <= depth <= DEEPEST or not COLDEST <= value <= WARMEST:
            raise InputError(f"{where}: temperature = {value:g} degrees C at {depth:g} m: must be from {COLDEST:g} to"
                             f" {WARMEST:g}, at a depth from 0 to {DEEPEST:g} m")
    tests = [test for test in profile.tests if _sound(test, where, layers[-1].bottom, notes)]
    if any(layer.moisture[:1] in WET or (main_class(layer.form) == "MF" and layer.form.lower() != "mfcr")
           for layer in layers if layer.moisture or layer.form):
        notes.append("moist or wet snow: densities, moduli and strengths are those of dry snow")
    return replace(profile, layers=layers, tests=tuple(tests), notes=tuple(notes))


def _sound(test: StabilityTest, where: str, bottom: float, notes: list[str]) -> bool:
    """Whether a test counts; a note where it does not. InputError for lengths that cannot be."""
    for what, length in (("depth", test.depth), ("cut", test.cut), ("column", test.column)):
        if length is not None and not 0.0 <= length <= DEEPEST:
            raise InputError(f"{where}: {test.kind}: {what} = {length:g} m: must be from 0 to {DEEPEST:g}")
    if test.cut is not None and test.column and test.cut > test.column * (1.0 + TOLERANCE):
        notes.append(f"{test}: cut longer than its column: left out")
        return False
    if test.depth is not None and test.depth >= bottom:
        notes.append(f"{test}: below the profile: left out")
        return False
    return True


def _cm(layer: Layer) -> str:
    return f"{100 * layer.top:.4g} to {100 * layer.bottom:.4g} cm"
