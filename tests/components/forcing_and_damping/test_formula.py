"""Formulas of a scene: what they compute, and that nothing but arithmetic gets through."""

import numpy as np
import pytest

from snowmpm.scenes.formula import LONGEST, compiled


@pytest.mark.parametrize(("text", "expected"), [
    ("2*x + z**2 - 1", 2 * 0.5 + 0.25**2 - 1), ("-x", -0.5), ("min(x, z) + max(x, z)", 0.75),
    ("step(0, 1, x)", 0.5), ("sin(2*pi*t)", np.sin(2 * np.pi * 3.0)), ("vx - vz", 3.0), ("x > z", 1.0),
    ("7 if x < z else 8.5", 8.5), ("floor(t/2)*abs(-2)", 2.0), ("exp(log(4))*sqrt(4)+tanh(0)*cos(0)*tan(0)", 8.0),
])
def test_values(text, expected):
    found = compiled(text, 2)(np.array([0.5]), np.array([0.25]), np.array([1.0]), np.array([-2.0]), 3.0)
    assert np.ravel(found)[0] == pytest.approx(expected, rel=1e-15)


HOSTILE = [
    "__import__('os').system('true')", "x.__class__", "(lambda: 1)()", "[1, 2][0]", "{}", "x if", "", "   ", "'text'",
    "open('a')", "exec('1')", "f'{x}'", "x := 1", "sin(x, x)", "sin(*[x])", "sin(x=1)", "max(x)", "True", "None",
    "1j", "...", "x and z", "not x", "0 < x < 1", "x @ z", "x // z", "x % z", "x << 2", "~x", "1e300", "1e-300",
    "9**" * 30 + "9**9999999999999999", "y", "nan", "inf", "((" * 150 + "x" + "))" * 150, "-" * 350 + "x",
    "x+" * 199 + "x", "x" * (LONGEST + 1), "\0", "x\nz", "import os", "yield x", "await x", "x;z", "os", "step(1, 2)",
    "sin", "(x, z)", "[x for x in [1]]", "globals()", "x[0]", "b'x'",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_text_is_refused(text):
    with pytest.raises(ValueError, match=r"."):
        compiled(text, 2)


def test_a_tower_of_powers_overflows_and_ends():
    """Numbers are floats: no integer grows without bound."""
    with np.errstate(all="ignore"):
        assert np.isinf(compiled("9**9**9**9**9", 2)(0.0, 0.0, 0.0, 0.0, 0.0))
