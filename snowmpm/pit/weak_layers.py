"""Candidates for the weak layer of a profile, with the reason.

Tests and marks of the observer come first. Then the threshold sum (Schweizer & Jamieson 2007,
doi:10.1016/j.coldregions.2006.08.011), as Monti et al. (2014), doi:10.1016/j.coldregions.2014.04.001, have its limits
for observed and for modelled profiles: a point each for a persistent grain form, large grains, low hardness, a
difference of size and one of hardness to a neighbour, and a top no deeper than a metre. Five of six are unstable.
"""

from dataclasses import dataclass

from snowmpm.pit.profile import Layer, SnowProfile
from snowmpm.quantities.snow_codes import PERSISTENT, hardness_code, is_crust, main_class, words

OBSERVED, MODELLED = (1.3, 1.25, 1.7, 0.75), (2.0, 0.6, 1.0, 0.4)
"""Largest hardness, least size [mm], least difference of hardness, and of size: [mm] observed, as a share modelled."""
DEEPEST = 1.0
"""Top of a weak layer that a person still reaches [m]."""
UNSTABLE = 5
LIGHTER = 0.8
"""Density of a weak layer over that of its neighbours, where grain forms are not known: chosen."""
LEAST_SLAB = 0.05
"""Thickness [m] below which what lies above is no slab."""
POINTS = {"PST": 30, "concern": 20, "ECTP": 15, "fails": 1}
"""Weight of a saw test that ran to the end, a mark of the observer, an ECT that propagated, and any other failure,
beside the points of the threshold sum: chosen."""


@dataclass(frozen=True)
class Candidate:
    """index: of its layer from the top; score; points: of six; reasons: words; depth: at which it fails [m], its top,
    or that of the test which counts most."""

    index: int
    score: float
    points: int
    reasons: tuple[str, ...]
    depth: float

    @property
    def sure(self) -> bool:
        """Whether a test or a mark names it, or five points of six."""
        return self.score - self.points >= POINTS["ECTP"] or self.points >= UNSTABLE


def candidates(profile: SnowProfile) -> list[Candidate]:
    """Layers that may be the weak one, the most likely first; each has a reason."""
    if not any(layer.form for layer in profile.layers):
        return _light_layers(profile)
    tested: dict[int, list] = {}
    for test in profile.tests:
        if test.depth is not None and _worth(test) and (k := profile.index_at(test.depth)) is not None:
            tested.setdefault(k, []).append(test)
    found = []
    for k, layer in enumerate(profile.layers):
        if k == 0 or layer.top < LEAST_SLAB or is_crust(layer.form):
            continue
        points, reasons = _threshold_sum(profile, k)
        score, depth, most = float(points), layer.top, 0
        if layer.concern:
            score, reasons = score + POINTS["concern"], ["marked by the observer", *reasons]
        for test in tested.get(k, ()):
            worth = _worth(test)
            score, reasons = score + worth, [str(test), *reasons]
            if worth > most:
                most, depth = worth, max(test.depth, layer.top)
        if score >= UNSTABLE - 1 or layer.concern or k in tested or main_class(layer.form) in PERSISTENT:
            found.append(Candidate(k, score, points, tuple(dict.fromkeys(reasons)), min(depth, layer.middle)))
    return sorted(found, key=lambda one: (-one.score, one.index))


def _light_layers(profile):
    """Of a profile without grain forms: layers lighter than both neighbours by LIGHTER."""
    found = []
    for k in range(1, len(profile.layers) - 1):
        above, own, below = (profile.layers[i].density for i in (k - 1, k, k + 1))
        if None in (above, own, below) or profile.layers[k].top < LEAST_SLAB:
            continue
        if own < LIGHTER * min(above, below):
            found.append(Candidate(k, min(above, below) / own, 0, (
                f"{own:.0f} kg/m3 between {above:.0f} and {below:.0f}",), profile.layers[k].top))
    return sorted(found, key=lambda one: (-one.score, one.index))


def _worth(test):
    if test.kind == "PST":
        return POINTS["PST"] if "End" in test.result else POINTS["fails"]
    if test.kind == "ECT":
        return POINTS["ECTP"] if "ECTP" in test.result.upper() else POINTS["fails"]
    return POINTS["fails"] if test.kind in ("CT", "RB") and test.result else 0


def _threshold_sum(profile, k):
    """(points, reasons) of a layer."""
    layer = profile.layers[k]
    soft, coarse, harder, coarser = MODELLED if profile.modelled else OBSERVED
    neighbours = [profile.layers[i] for i in (k - 1, k + 1) if 0 <= i < len(profile.layers)]
    reasons = []
    if main_class(layer.form) in PERSISTENT:
        reasons.append(words(layer.form))
    if layer.size is not None and layer.size >= coarse:
        reasons.append(f"grains of {layer.size:g} mm")
    if layer.hardness and min(layer.hardness) <= soft + 1e-9:
        reasons.append(f"hardness {hardness_code(min(layer.hardness))}")
    steps = [step for one in neighbours if (step := _hardness_step(layer, one)) is not None]
    if steps and max(steps) >= harder - 1e-9:
        reasons.append(f"{max(steps):.1f} hand-hardness steps softer than a neighbour")
    gaps = [gap for one in neighbours if (gap := _size_gap(layer, one, profile.modelled)) is not None]
    if gaps and max(gaps) >= coarser - 1e-9:
        reasons.append(f"grains {100 * max(gaps):.0f} % larger than a neighbour's" if profile.modelled else
                       f"grains {max(gaps):.2g} mm larger than a neighbour's")
    if layer.top <= DEEPEST:
        reasons.append("no deeper than a metre")
    return len(reasons), reasons


def _hardness_step(layer: Layer, other: Layer):
    if not layer.hardness or not other.hardness:
        return None
    return other.hardness[1 if other.top < layer.top else 0] - layer.hardness[0 if other.top < layer.top else 1]


def _size_gap(layer: Layer, other: Layer, relative: bool):
    if layer.size is None or other.size is None:
        return None
    return (layer.size - other.size) / layer.size if relative else layer.size - other.size
