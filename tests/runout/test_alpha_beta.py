"""Alpha-beta on profiles whose answer is known, and on eight paths of AvaFrame beside its own program."""

import csv
import math

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.runout.alpha_beta import CALIBRATIONS, alpha_beta
from snowmpm.runout.profile import Profile, profile_of
from tests.support.project import ROOT

LINE = np.array([[0.0, 0.0], [3000.0, 0.0]])
CURVE, TOP, END = 2e-4, 1200.0, 2400.0
"""z = TOP - 2 CURVE END s + CURVE s²: level at END."""


def parabola(places):
    s = np.hypot(*places.T)
    return TOP + CURVE * s**2 - 2.0 * CURVE * END * s


def test_a_parabola_has_the_angles_of_its_formula():
    """Its slope is 10 degrees where 2 CURVE (END - s) = tan 10 degrees; a piece has the slope of its middle."""
    profile = profile_of(LINE, parabola, "here", spacing=1.0)
    found = alpha_beta(profile)
    s = END - math.tan(math.radians(10.0)) / (2.0 * CURVE)
    assert found.beta_s == pytest.approx(s, abs=1.6)
    beta = math.degrees(math.atan(2.0 * CURVE * END - CURVE * s))
    assert found.beta == pytest.approx(beta, abs=0.02)
    low = float(parabola(np.array([[END, 0.0]]))[0])
    fit = CALIBRATIONS["austria"]
    assert found.alpha == pytest.approx(fit.k1 * found.beta + fit.k2 * 2.0 * CURVE + fit.k4, abs=1e-6)
    small, norway = alpha_beta(profile, "austria_small"), alpha_beta(profile, "norway")
    fall = max(TOP - low, TOP - float(profile.z[-1]))
    assert small.alpha == pytest.approx(0.933 * found.beta + 0.0088 * fall - 5.02, abs=1e-3)
    assert norway.alpha == pytest.approx(0.96 * found.beta - 1.4, abs=1e-9)
    # The line at alpha meets the parabola where CURVE s = 2 CURVE END - tan(alpha)
    for n, runout in found.runouts.items():
        tangent = math.tan(math.radians(found.alpha + n * found.deviation))
        assert runout == pytest.approx(2.0 * END - tangent / CURVE, abs=0.1), n


def test_run_outs_grow_with_the_deviations():
    found = alpha_beta(profile_of(LINE, parabola, "here"))
    assert found.runouts[1] < found.runouts[0] < found.runouts[-1] < found.runouts[-2]


def test_a_path_may_be_drawn_upwards():
    down, up = (alpha_beta(profile_of(line, parabola, "here")) for line in (LINE, LINE[::-1]))
    assert up.alpha == pytest.approx(down.alpha, abs=1e-9) and up.runouts[0] == pytest.approx(down.runouts[0], abs=1e-6)


def terraced(places):
    """A parabola with a level terrace from 600 to 700 m."""
    s = np.hypot(*places.T)
    passed = np.where(s < 600.0, s, np.where(s < 700.0, 600.0, s - 100.0))
    return TOP + CURVE * passed**2 - 2.0 * CURVE * END * passed


def test_a_terrace_is_taken_for_the_foot_only_with_a_warning():
    profile = profile_of(np.array([[0.0, 0.0], [2400.0, 0.0]]), terraced, "here")
    first = alpha_beta(profile, split=0.0)
    assert first.beta_s == pytest.approx(615.0, abs=10.0) and "steep again" in " ".join(first.doubts)
    assert alpha_beta(profile, split=800.0).beta_s > 1900.0


def test_what_a_path_must_have():
    with pytest.raises(InputError, match="no beta point"):
        alpha_beta(profile_of(np.array([[0.0, 0.0], [1500.0, 0.0]]), parabola, "here"))
    with pytest.raises(InputError, match="must be one of austria, austria_small, norway"):
        alpha_beta(profile_of(LINE, parabola, "here"), "austia")
    with pytest.raises(InputError, match="leaves the ground at 2000, 0"):
        profile_of(LINE, lambda places: np.where(places[:, 0] < 2000.0, parabola(places), np.nan), "here")
    with pytest.raises(InputError, match="has no length"):
        profile_of(np.zeros((3, 2)), parabola, "here")


def test_doubts_are_told():
    short = Profile(*(lambda p: (p.s[:228], p.plan[:228], p.z[:228]))(profile_of(LINE, parabola, "here")))
    assert any("ends before alpha" in doubt for doubt in alpha_beta(short).doubts)
    long = profile_of(3.0 * LINE, lambda places: 3.0 * parabola(places / 3.0), "here", spacing=5.0)
    assert any("is above beta" in doubt for doubt in alpha_beta(long, "austria_small").doubts)


def test_angles_on_paths_of_avaframe():
    """Written by tests/benchmarks/alpha_beta_paths.py, which needs AvaFrame's data; angles of com2AB beside ours."""
    with (ROOT / "tests" / "benchmarks" / "figures" / "alpha_beta_paths.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8
    for row in rows:
        for name in ("beta", "alpha", "alpha_small"):
            assert float(row[name]) == pytest.approx(float(row[f"{name}_com2ab"]), abs=0.01), (row["path"], name)
        assert float(row["runout"]) == pytest.approx(float(row["runout_com2ab"]), abs=10.0)


def cliff(places):
    """35 degrees as far as 1000 m, then level."""
    return -math.tan(math.radians(35.0)) * np.minimum(places[:, 0], 1000.0)


@pytest.mark.parametrize("length", [1200.0, 1500.0, 2000.0, 3000.0, 5000.0])
def test_the_beta_point_does_not_move_with_the_tail_of_a_path(length):
    profile = profile_of(np.array([[0.0, 0.0], [length, 0.0]]), cliff, "here")
    assert alpha_beta(profile).beta_s == pytest.approx(1010.0, abs=1.0)


def test_every_line_of_alpha_meets_the_ground_where_it_first_does():
    """alpha + SD does so before the foot."""
    found = alpha_beta(profile_of(np.array([[0.0, 0.0], [5000.0, 0.0]]), cliff, "here"))
    assert found.runouts[1] is not None and found.runouts[1] <= found.runouts[0]


def test_splits_and_paths_that_are_refused():
    with pytest.raises(InputError, match=r"--split = 3000\.0: must be below the length of the path, 3000 m"):
        alpha_beta(profile_of(LINE, parabola, "here"), split=3000.0)
    with pytest.raises(InputError, match="no alpha"):
        alpha_beta(profile_of(LINE, lambda places: -1e-4 * places[:, 0], "here"))
