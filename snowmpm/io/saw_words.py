"""A saw test in words: set-up and outcome."""

import numpy as np


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
    length, before = found.get("critical_length"), found.get("broken_at_rest") or 0.0
    if length is None and before > 0.0:
        return f"the weak layer had broken over {before:.0%} of the column before the saw began: no critical length"
    if length is None:
        return "no crack runs by itself"
    words = f"critical length {length:.2f} m"
    if found.get("crack_speed"):
        words += f", crack speed {found['crack_speed']:.0f} m/s"
    if found.get("collapse_height"):
        words += f", collapse height {1e3 * found['collapse_height']:.2f} mm"
    if found.get("fracture_energy"):
        words += f", fracture energy {found['fracture_energy']:.2f} J/m²"
    if found.get("runs_to_the_end"):
        return words
    late = test["tip"][test["time"] > 0.9 * test["time"][-1]]
    return words + f", {'still running' if np.ptp(late) > 0.0 else 'arrest'} at {found['crack_length']:.1f} m"
