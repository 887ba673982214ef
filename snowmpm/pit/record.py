"""What is told of a profile and its stability: as numbers, and in words."""

from dataclasses import asdict

from snowmpm.pit.mechanics import MODULI, density
from snowmpm.pit.stability import INPUTS, INTERVAL
from snowmpm.quantities.snow_codes import hardness_code, words

NAMES = {"strength": "strength (SNOWPACK)", "energy": "energy, rigid layer", "weac": "energy, WEAC"}
MOST_CANDIDATES = 4


def measured(profile, index):
    """Saw tests of the profile in this layer that have a cut length."""
    return [test for test in profile.tests if test.kind == "PST" and test.cut and test.depth is not None
            and profile.index_at(test.depth) == index]


def record_of(profile, found, index, column, stability):
    """All of it as numbers, by name: lengths [m], stresses [Pa]."""
    return {
        "profile": {"name": profile.name, "format": profile.format, "time": profile.time, "place": profile.place,
                    "elevation": profile.elevation, "aspect": profile.aspect, "slope_angle": profile.slope_angle,
                    "layers": [asdict(layer) for layer in profile.layers],
                    "tests": [asdict(one) for one in profile.tests], "notes": profile.notes},
        "candidates": [{"top": profile.layers[one.index].top, "form": profile.layers[one.index].form,
                        "points": one.points, "reasons": one.reasons} for one in found],
        "weak_layer": {"index": index, "top": profile.layers[index].top, **asdict(column.weak)},
        "slab": {"thickness": column.thickness, "density": column.density, "angle": column.angle,
                 "modulus_law": MODULI[column.law][0], "plates": [asdict(plate) for plate in column.plates]},
        "normal_stress": stability.normal, "shear_stress": stability.shear,
        "critical_cut_length": {one.theory: {
            "value": one.value, "low": one.low, "high": one.high, "note": one.why, "fails_by_itself": one.failing,
            "variance_from": dict(zip(INPUTS, one.shares, strict=False))} for one in stability.lengths},
        "measured": [asdict(one) for one in measured(profile, index)],
        "crack_speed": stability.crack_speed, "crack_way": stability.crack_way, "tension": stability.tension,
        "assumed": column.assumed,
    }


def told(profile, found, index, column, stability):
    """Lines for reading."""
    place = [profile.time[:16].replace("T", " "), profile.elevation and f"{profile.elevation:.0f} m", profile.aspect,
             None if profile.slope_angle is None else f"{profile.slope_angle:g} degrees"]
    yield f"{profile.name} ({profile.format}): {', '.join(str(one) for one in place if one)}"
    yield "  depth [cm]      form    size [mm]  hand   density [kg/m3]"
    for k, layer in enumerate(profile.layers):
        known = density(layer)
        yield (f"{'>' if k == index else ' '} {100 * layer.top:5.4g} - {100 * layer.bottom:<7.4g} {layer.form or '-':7}"
               f" {layer.size or '-':>6}    {hardness_code(layer.mean_hardness) if layer.hardness else '-':>4}"
               f"     {'-' if known is None else f'{known[0]:.0f}'}"
               f"{'' if known is None or known[1] == 'measured' else f' (by {known[1]})'}".rstrip())
    for test in profile.tests:
        if test.kind != "SNOWPACK":
            yield f"  {test}"
    yield "Candidates for the weak layer:"
    for one in found[:MOST_CANDIDATES]:
        layer = profile.layers[one.index]
        yield f"  {100 * layer.top:.4g} cm: {', '.join(one.reasons)}" + (
            f" ({one.points} of 6 points)" if one.points else "")
    layer, weak = profile.layers[index], column.weak
    yield (f"Weak layer at {100 * layer.top:.4g} cm, {words(layer.form)}, below a slab of"
           f" {100 * column.thickness:.0f} cm normal to the slope, {column.density:.0f} kg/m3, on"
           f" {column.angle:.3g} degrees:")
    bears = "" if weak.strength is None else f"; it bears {weak.strength:.0f} Pa of shear by its form and density"
    yield f"  load: {stability.normal:.0f} Pa normal, {stability.shear:.0f} Pa shear{bears}"
    yield (f"  critical cut length, and {100 * (INTERVAL[1] - INTERVAL[0]):.0f} % of what the scatter of the laws makes"
           " of it:")
    for one in stability.lengths:
        value = "-" if one.value is None else f"{one.value:.2f} m"
        interval = "" if one.low is None else f"  {one.low:.2f} to {one.high:.2f} m"
        yield f"    {NAMES[one.theory]:22} {value:>7}{interval}{f'  ({one.why})' if one.why else ''}"
    if stability.length("weac") is None:
        yield "    energy, WEAC           not installed: pip install \"snowmpm[peers]\""
    yield from (f"  measured: {line}" for line in _against(profile, index, stability))
    if stability.dominant:
        name, share = stability.dominant
        yield f"  the interval comes from {name} most: {100 * share:.0f} % of its variance"
    yield f"  a crack that runs: {stability.crack_speed:.0f} m/s ({stability.crack_way})"
    if stability.tension is not None:
        verdict = "the slab tears, and the crack may stop" if stability.tension >= 1.0 else "the slab holds"
        yield f"  tension in the slab as it begins to run: {stability.tension:.2f} of its strength: {verdict}"
    for line in (*profile.notes, *column.assumed):
        yield f"  assumed: {line}"


def _against(profile, index, stability):
    """A line for each saw test in the weak layer."""
    for test in measured(profile, index):
        ratios = [f"{one.value / test.cut:.2f} by {NAMES[one.theory]}" for one in stability.lengths if one.value]
        near = "" if not test.column or test.cut < 0.8 * test.column else "; near the end of the column"
        yield f"{test}: theory over it {', '.join(ratios) or 'none'}{near}"
