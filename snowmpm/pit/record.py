"""What is told of a profile and its stability: as numbers, and in words."""

from dataclasses import asdict

from snowmpm.pit.mechanics import MODULI, density
from snowmpm.pit.stability import INPUTS, INTERVAL
from snowmpm.quantities.snow_codes import hardness_code, words

NAMES = {"strength": "strength (SNOWPACK)", "energy": "energy, rigid layer", "weac": "energy, WEAC"}
MOST_CANDIDATES = 4
LIKELY = 0.8
"""Share of the columns from which on something is likely."""


def measured(profile, index):
    """Propagation saw tests of the profile in this layer that have a cut length."""
    return [test for test in profile.tests if test.kind == "PST" and test.cut and test.depth is not None
            and profile.index_at(test.depth) == index]


def ran(test):
    """Whether the crack of a saw test ran to the end, so that its cut is a critical length."""
    return "End" in test.result


def profile_record(profile, found):
    """The profile and its candidates as numbers, by name."""
    return {
        "profile": {"name": profile.name, "format": profile.format, "time": profile.time, "place": profile.place,
                    "elevation": profile.elevation, "aspect": profile.aspect, "slope_angle": profile.slope_angle,
                    "layers": [asdict(layer) for layer in profile.layers],
                    "tests": [asdict(one) for one in profile.tests], "notes": profile.notes},
        "candidates": [{"top": profile.layers[one.index].top, "form": profile.layers[one.index].form,
                        "points": one.points, "reasons": one.reasons} for one in found]}


def record_of(profile, found, index, column, stability):
    """All of it as numbers, by name: lengths [m], stresses [Pa], speeds [m/s]."""
    return {
        **profile_record(profile, found),
        "weak_layer": {"index": index, "top": profile.layers[index].top, **asdict(column.weak)},
        "slab": {"thickness": column.thickness, "density": column.density, "angle": column.angle,
                 "modulus_law": MODULI[column.law][0], "plates": [asdict(plate) for plate in column.plates]},
        "normal_stress": stability.normal, "shear_stress": stability.shear,
        "critical_cut_length": {one.theory: {
            "value": one.value, "low": one.low, "high": one.high, "note": one.why, "fails_by_itself": one.failing,
            "variance_from": dict(zip(INPUTS, one.shares, strict=False))} for one in stability.lengths},
        "measured": [asdict(one) for one in measured(profile, index)],
        "crack_speed": stability.crack_speed, "crack_speed_interval": stability.speeds,
        "crack_way": stability.crack_way, "tension": stability.tension, "tension_interval": stability.tensions,
        "slab_tears": stability.tears, "assumed": column.assumed,
    }


def layers_told(profile, found, index=None):
    """The profile, its tests and candidates, in lines. index: of the weak layer."""
    place = [profile.time[:16].replace("T", " "), profile.elevation is not None and f"{profile.elevation:.0f} m",
             profile.aspect, profile.slope_angle is not None and f"{profile.slope_angle:g} degrees"]
    yield f"{profile.name} ({profile.format}): {', '.join(str(one) for one in place if one)}"
    yield "  depth [cm]      form    size [mm]  hardness  density [kg/m3]"
    for k, layer in enumerate(profile.layers):
        known = density(layer)
        yield (f"{'>' if k == index else ' '} {100 * layer.top:5.4g} - {100 * layer.bottom:<7.4g} {layer.form or '-':7}"
               f" {layer.size or '-':>6}      {hardness_code(layer.mean_hardness) if layer.hardness else '-':>4}"
               f"      {'-' if known is None else f'{known[0]:.0f}'}"
               f"{'' if known is None or known[1] == 'measured' else f' (by {known[1]})'}"
               f"{f'  {layer.moisture}' if layer.moisture and layer.moisture != 'D' else ''}".rstrip())
    yield from (f"  {test}" for test in profile.tests)
    if not found:
        yield ("No candidate for the weak layer: no test failed, nothing is marked, no persistent grains; --layer CM"
               " names one")
        return
    yield "Candidates for the weak layer (of 6 points, 5 are critical):"
    for one in found[:MOST_CANDIDATES]:
        layer = profile.layers[one.index]
        yield f"  {100 * layer.top:.4g} cm: {', '.join(one.reasons)}" + (
            f" ({one.points} points)" if one.points else "")
    if index is not None and found[0].index == index and not found[0].sure:
        yield "  a guess: no test names it, and none reaches 5 points"


def told(profile, found, index, column, stability):
    """Lines for reading: `layers_told`, then stability."""
    yield from layers_told(profile, found, index)
    yield from stability_told(profile, index, column, stability)


def stability_told(profile, index, column, stability):
    """Lines on the weak layer and its stability."""
    layer, weak = profile.layers[index], column.weak
    if profile.slope_angle is not None and abs(column.angle - profile.slope_angle) > 0.05:
        yield f"On {column.angle:.3g} degrees, in place of the {profile.slope_angle:g} of the file:"
    yield (f"Weak layer at {100 * layer.top:.4g} cm, {words(layer.form)}, below a slab of"
           f" {100 * column.thickness:.0f} cm normal to the slope, {column.density:.0f} kg/m3, on"
           f" {column.angle:.3g} degrees:")
    strength = "" if weak.strength is None else f"; shear strength by form and density {weak.strength:.0f} Pa"
    yield f"  load: {stability.normal:.0f} Pa normal, {stability.shear:.0f} Pa shear{strength}"
    yield (f"  critical cut length, and the interval that holds {100 * (INTERVAL[1] - INTERVAL[0]):.0f} % of what the"
           " scatter of the laws gives:")
    for one in stability.lengths:
        value = "-" if one.value is None else f"{one.value:.2f} m"
        interval = "" if one.low is None else f"  {one.low:.2f} to {one.high:.2f} m"
        yield f"    {NAMES[one.theory]:22} {value:>7}{interval}{f'  ({one.why})' if one.why else ''}"
    if stability.length("weac") is None:
        yield "    energy, WEAC           not installed: pip install \"snowmpm[peers]\""
    yield from (f"  measured: {line}" for line in _against(profile, index, stability))
    if stability.dominant:
        theory, name, share = stability.dominant
        yield f"  the interval of {NAMES[theory]} comes from {name} most: {100 * share:.0f} % of its variance"
    between = "" if stability.speeds is None else f" ({stability.speeds[0]:.0f} to {stability.speeds[1]:.0f})"
    yield f"  crack propagation speed: {stability.crack_speed:.0f} m/s{between}, {stability.crack_way}"
    if stability.tension is not None:
        yield (f"  tension in the slab as the crack begins to run: {stability.tension:.2f} of its strength"
               f"{_tears(stability)}")
    for line in (*profile.notes, *column.assumed):
        yield f"  assumed: {line}"


def _tears(stability):
    """What the tension says of the slab."""
    if stability.tensions is None:
        return ""
    low, high = stability.tensions
    verdict = ("it likely tears, and the crack may stop" if stability.tears >= LIKELY else
               "it likely holds" if stability.tears <= 1.0 - LIKELY else "it may tear or hold")
    return f" ({low:.2f} to {high:.2f}): {verdict}"


def _against(profile, index, stability):
    """A line for each saw test in the weak layer."""
    for test in measured(profile, index):
        if not ran(test):
            yield f"{test}: the crack did not run to the end, so its cut is no critical length"
            continue
        ratios = [f"{one.value / test.cut:.2f} by {NAMES[one.theory]}" for one in stability.lengths if one.value]
        near = "" if not test.column or test.cut < 0.8 * test.column else "; near the end of the column"
        yield f"{test}: computed over measured {', '.join(ratios) or 'none'}{near}"
