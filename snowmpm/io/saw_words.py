"""A saw test in words: set-up and outcome."""

from snowmpm.quantities.quantity import written
from snowmpm.quantities.saw import REASONS


def set_up(about):
    """Set-up of the test, as {what: words}. about: of `io.saw_test.SawTest`."""
    slope, notch = about["slope_angle"], about["notch"]
    way = "on the flat" if slope == 0.0 else f"{'up' if slope > 0.0 else 'down'} a slope of {abs(slope):g}°"
    rows = {"saw": f"takes the weak layer away at {about['saw_speed']:g} m/s, {way}, from x = {notch:g} m",
            "notch": f"{notch:g} m, cut before the start and part of the critical length" if notch else
                     "none: the column starts whole"}
    if "saw_length" in about:
        rows["saw"] += f" to {about['saw_length']:g} m"
    if "saw_start" in about:
        rows["saw"] += f", beginning at {about['saw_start']:g} s"
    rows["critical length"] = "cut, notch included, when the crack began to run by itself"
    rows["load on the layer"] = f"{about['normal_stress']:.0f} Pa normal, {about['shear_stress']:.0f} Pa shear"
    return rows


def outcome(found, test):
    """The outcome in one line. found: "saw_test" of a run's summary; test: `io.saw_test.SawTest`."""
    length = found.get("critical_length")
    if length is None:
        return f"critical length: {why(found, 'critical_length')}"
    words = f"critical length {length:.2f}{spread(found, 'critical_length', 2)} m"
    if found.get("crack_speed"):
        words += f", crack speed {found['crack_speed']:.0f}{spread(found, 'crack_speed', 0)} m/s"
    if found.get("collapse_height"):
        words += f", collapse height {1e3 * found['collapse_height']:.2f} mm"
    if found.get("fracture_energy"):
        words += f", fracture energy {found['fracture_energy']:.2f} J/m²"
    if not found.get("runs_to_the_end"):
        return f"{words}, {_end(found, test)}"
    return "; ".join([words, *unknown(found)])


def why(found, name):
    """Why a number of a saw test has no value. Files of earlier versions hold no reason."""
    return found.get("reasons", {}).get(name) or "no crack ran by itself, or the column was too short to tell"


def in_short(found, name):
    """The same in a word or two, for a table."""
    return next((short for reason, short in REASONS.items() if why(found, name).startswith(reason)), "-")


def unknown(found):
    """The numbers without a value, those of one reason together."""
    by_reason = {}
    for name, text in found.get("reasons", {}).items():
        by_reason.setdefault(text, []).append(name.replace("_", " "))
    return [f"{', '.join(names)}: {text}" for text, names in by_reason.items()]


def spread(found, name, places):
    """" ± 0.08" of a measured number, at least the last of its places; "" where it is not known."""
    value = found.get(SPREADS.get(name))
    return f" ± {max(value, 10.0**-places):.{places}f}" if value else ""


SPREADS = {"critical_length": "critical_length_resolution", "crack_speed": "crack_speed_spread"}
"""What tells how well a measured number is known."""


def not_to_the_end(found, test):
    """Why the numbers of a crack are not those of one that ran to the end; None of such a crack, and without one."""
    if not found.get("critical_length") or found.get("runs_to_the_end"):
        return None
    words = _end(found, test)
    if not found.get("stopped"):
        words += ": a longer end_time shows whether it goes on"
    return f"The crack {words}."


def _end(found, test):
    """How a crack ended that did not come to the end of the column."""
    at, length = f"{found.get('crack_length', 0.0):.2f} m", test.about.get("length")
    of = f" of {length:g} m" if length else ""
    if not found.get("stopped"):
        return f"was at {at}{of}, still on its way, when the run ended{_load(found, test.about)}"
    return f"stopped at {at}{of}{_load(found, test.about)}"


def _load(found, about):
    """The load beside Maxwell's."""
    maxwell, load = found.get("theory", {}).get("maxwell_load"), about.get("normal_stress")
    if not maxwell or not load:
        return ""
    side = "below" if load < maxwell else "above"
    return f", under {written(load, 'Pa')} normal stress, {side} Maxwell's load {written(maxwell, 'Pa')}"
