"""Saw tests in `snowmpm compare`: rows of the table, and likely reasons why measurement and theory differ."""

import math

from snowmpm.io.saw_theories import THEORIES, compared
from snowmpm.io.saw_words import SPREADS, in_short, not_to_the_end, unknown
from snowmpm.quantities.quantity import per_width

MEASURED = {"critical_length": "critical length [m]", "crack_length": "crack length at the end [m]",
            "crack_speed": "crack speed [m/s]", "top_speed": "top speed [m/s]",
            "collapse_height": "collapse height [m]", "fracture_energy": "fracture energy [J/m2]"}
LAST = {"plastic_work": "plastic work", "energy_remainder": "numerical remainder"}
SET_UP = {"slope_angle": "slope [degrees]", "slab_thickness": "slab [m]", "weak_layer_thickness": "weak layer [m]",
          "saw_speed": "saw speed [m/s]", "saw_length": "saw to [m]", "notch": "notch [m]"}


def saw_test_rows(tests):
    """(name, texts of each test, numbers of each or None). tests: `render.ComparedSawTest`s."""
    for name, label in SET_UP.items():
        values = [test.run.saw_test.about.get(name) for test in tests]
        yield label, ["-" if value is None else f"{value:g}" for value in values], None
    for name, label in MEASURED.items():
        yield _row(label, [test.found.get(name) for test in tests],
                   spreads=[test.found.get(SPREADS.get(name)) for test in tests],
                   missing=[in_short(test.found, name) for test in tests])
        for theory in THEORIES:
            if theory.measured == name:
                yield _row(f"  {theory.label}", [_predicted(test, theory) for test in tests], aside=True)
    yield "runs to the end", [{True: "yes", False: "no"}.get(test.found.get("runs_to_the_end"), "-")
                              for test in tests], None
    yield "stopped on its way", [{True: "yes", False: "no"}.get(test.found.get("stopped"), "-") for test in tests], None
    yield _row("normal stress on the weak layer [Pa]", [test.run.saw_test.about["normal_stress"] for test in tests])
    yield _row("  Maxwell's load, none runs below [Pa]", [test.found["theory"].get("maxwell_load") for test in tests],
               aside=True)
    joule = per_width("J") if tests[0].run.dimension == 2 else "J"
    for name, label in LAST.items():
        yield _row(f"{label} [{joule}]", [_last(test, name) for test in tests])
    kinetic = [max((v for v in test.run.history.get("kinetic_energy", ()) if v == v), default=None) for test in tests]
    yield _row(f"largest kinetic energy [{joule}]", kinetic)


def remarks_of(tests):
    """One line for each crack that did not come to the end, and for each test and theory that differ much."""
    for test in tests:
        if short := not_to_the_end(test.found, test.run.saw_test):
            yield f"{test.label}: {short}"
        for reason in unknown(test.found):
            yield f"{test.label}: {reason}"
        for one in compared(test.found, test.run.saw_test.about["slope_angle"]):
            if one.remark:
                yield f"{test.label}: {one.remark}"


def _row(label, values, aside=False, spreads=(), missing=()):
    missing = missing or ["-"] * len(values)
    texts = [word if value is None or math.isnan(value) else f"{value:.4g}"
             for value, word in zip(values, missing, strict=True)]
    for i, spread in enumerate(spreads):
        texts[i] += f" ± {spread:.2g}" if spread else ""
    numbers = None if aside or any(value is None for value in values) else values
    return label, texts, numbers


def _predicted(test, theory):
    for one in compared(test.found, test.run.saw_test.about["slope_angle"]):
        if one.theory == theory:
            return one.predicted
    return None


def _last(test, name):
    values = test.run.history.get(name, ())
    return float(values[-1]) if len(values) else None
