"""Thickness by altitude and slope, and friction by kind of ground, against numbers of their sources."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.region import friction, thickness
from snowmpm.region.spec import FrictionClass, read_region
from snowmpm.region.thickness import Thickness


@pytest.mark.parametrize(("slope", "factor"), [(25.0, 1.0), (28.0, 1.0), (30.0, 0.895), (35.0, 0.713), (40.0, 0.596),
                                               (45.0, 0.516), (50.0, 0.457)])
def test_slope_factor_of_the_guideline(slope, factor):
    assert thickness.slope_factor(slope) == pytest.approx(factor, abs=1.1e-3)


def test_thickness_by_altitude():
    given = Thickness(three_day_snow=1.5, wind=0.2)
    level = np.cos(np.radians(28.0))
    assert thickness.guideline(given, 2000.0, 28.0) == pytest.approx(1.5 * level + 0.2)
    assert thickness.guideline(given, 1500.0, 28.0) == pytest.approx(1.25 * level + 0.1)
    assert thickness.guideline(given, 3000.0, 28.0) == pytest.approx(2.0 * level + 0.2)
    assert thickness.guideline(Thickness(three_day_snow=0.2), 0.0, 30.0) == thickness.THINNEST


def classes():
    found = []
    for kind, mu in (("flat", 0.14), ("open", 0.155), ("channelled", 0.21), ("gully", 0.27)):
        for volume, more in ((0.0, 0.05), (60_000.0, 0.0)):
            for above, low in ((-500.0, 0.02), (1500.0, 0.0)):
                found.append(FrictionClass(terrain=kind, above=above, volume=volume, mu=mu + more + low,
                                           xi=2000.0 + 10 * mu))
    return found


def shares_of(**given):
    found = np.zeros((4, 1, 1))
    for name, value in given.items():
        found[friction.KINDS.index(name)] = value
    return found


@pytest.mark.parametrize(("kind", "mu"), [("flat", 0.14), ("open", 0.155), ("channelled", 0.21), ("gully", 0.27)])
def test_numbers_of_a_kind(kind, mu):
    z = np.full((1, 1), 2000.0)
    assert friction.numbers(classes(), 80_000.0, z, shares_of(**{kind: 1.0}))[0][0, 0] == pytest.approx(mu)
    assert friction.numbers(classes(), 0.0, z, shares_of(**{kind: 1.0}))[0][0, 0] == pytest.approx(mu + 0.05)
    assert friction.numbers(classes(), 30_000.0, z, shares_of(**{kind: 1.0}))[0][0, 0] == pytest.approx(mu + 0.025)
    assert friction.numbers(classes(), 8e4, z - 1000.0, shares_of(**{kind: 1.0}))[0][0, 0] == pytest.approx(mu + 0.02)


def test_numbers_between_kinds_and_bands():
    z = np.full((1, 1), 1500.0)
    mu, xi = friction.numbers(classes(), 8e4, z, shares_of(open=0.5, channelled=0.5))
    assert mu[0, 0] == pytest.approx(0.5 * (0.155 + 0.21) + 0.01)
    assert 2001.5 < xi[0, 0] < 2002.2


@pytest.mark.parametrize(("bend", "slope", "kind"), [(0.0, 35.0, "open"), (-0.08, 35.0, "open"), (0.08, 35.0, "gully"),
                                                     (0.0, 5.0, "flat"), (0.08, 5.0, "flat")])
def test_kinds_by_curvature_and_slope(bend, slope, kind):
    """A valley across the slope whose contours have the curvature `bend` [1/m]: even and convex ground is open."""
    n, cell = 60, 5.0
    x = cell * (np.arange(n) - n / 2)
    xx, yy = np.meshgrid(x, -x)
    steep = np.tan(np.radians(slope))
    found = friction.kinds(steep * (yy + 0.5 * bend * xx**2), cell)[:, n // 2, n // 2]
    assert found.sum() == pytest.approx(1.0)
    assert friction.KINDS[int(found.argmax())] == kind


def test_kinds_between():
    n, cell = 60, 5.0
    x = cell * (np.arange(n) - n / 2)
    _, yy = np.meshgrid(x, -x)
    flat, open_, *_ = friction.kinds(np.tan(np.radians(8.0)) * yy, cell)[:, n // 2, n // 2]
    assert flat == pytest.approx(0.5, abs=0.02) and open_ == pytest.approx(0.5, abs=0.02)


def test_card_times_a_factor():
    assert friction.of_card("voellmy_avaframe", 1e4, 1.0)["mu"] == 0.155
    assert friction.of_card("voellmy_avaframe", 1e4, 1.2)["mu"] == pytest.approx(0.186)
    assert friction.of_card("samos_at_auto", 30_000.0, 1.0)["mu"] == 0.17


@pytest.mark.parametrize(("more", "says"), [
    ('classes = [{ terrain = "open", mu = 0.2, xi = 2000.0 }]', "needs one of card and classes"),
    ('wrong = 3', "wrong"),
])
def test_refused_friction(region_file, more, says):
    with pytest.raises(InputError, match=says):
        read_region(region_file(more))


def test_classes_must_be_complete(region_file, tmp_path):
    path = region_file()
    path.write_text(path.read_text().replace('card = "voellmy_avaframe"',
                                             'classes = [{ terrain = "open", mu = 0.2, xi = 2000.0 }]'))
    with pytest.raises(InputError, match="has none for terrain channelled, gully, flat"):
        read_region(path)
