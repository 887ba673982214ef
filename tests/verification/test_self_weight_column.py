"""An elastic column under its own weight at finite strain (M5): settlement and stress, wherever it stands."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.study.problems.schemes import APIC, FLIP
from snowmpm.study.problems.self_weight_column import (
    CELLS,
    SNOW,
    SOFT,
    column_errors,
    exact_height,
    settled_errors,
)

CUBIC = replace(APIC, kernel="cubic")
FINE = replace(APIC, gradient="shape")


@pytest.mark.parametrize(("scheme", "law"), [(APIC, SNOW), (APIC, SOFT), (CUBIC, SOFT), (FLIP, SOFT)])
def test_settlement_and_stress(scheme, law):
    height, largest, typical = column_errors(law, 10.0, scheme)
    assert height < 0.001  # a tenth of the 1 % that M5 asks for
    assert largest < 0.02 and typical < 0.005


@pytest.mark.parametrize(("law", "offset", "angle"), [
    (SNOW, 1 / 3, None), (SOFT, 1 / 3, None), (SNOW, 0.0, np.pi / 2)])
def test_wherever_the_column_lies_in_the_grid(law, offset, angle):
    height, largest, typical = column_errors(law, 10.0, APIC, offset, angle)
    assert height < 0.002
    assert largest < 0.025 and typical < 0.005  # largest: at the foot of a wall


def turned(degrees, scheme, per_axis=2):
    """Of a column 4 cells wide: mean error of the height of its top, largest of both stresses of each particle, and the
    particle's distance from the nearest wall [cells]."""
    place, height, off = settled_errors(SNOW, 10.0, scheme, angle=np.deg2rad(degrees), per_axis=per_axis)
    wall = np.minimum(np.minimum(place[:, 0], 4.0 - place[:, 0]), place[:, 1])
    return height[place[:, 1] > 0.95 * CELLS].mean(), np.abs(off).max(axis=1), wall


LONGER = "the usual step became 0.9 of the critical one later, for 0.7, and what is missed grows with the step: "
SHORTER = 0.25
"""C of a shorter step."""


def angles(missed, why):
    """30 degrees, and others in the slow part; by the usual step the gates are missed at one of them."""
    failing = pytest.mark.xfail(strict=True, reason=LONGER + why)
    return [30, *(pytest.param(k, marks=[pytest.mark.slow, *([failing] if k == missed else [])])
                  for k in (15, 45, 60, 75))]


@pytest.mark.slow
def test_turned_in_shorter_steps():
    """Where the usual step misses the gates of the two tests below."""
    top, off, wall = turned(75, replace(APIC, cfl=SHORTER))
    assert abs(top) < 0.01 and off[wall > 1.0].max() < 0.06 and np.sqrt((off**2).mean()) < 0.03
    top, off, wall = turned(60, replace(FINE, cfl=SHORTER), 4)
    assert abs(top) < 0.0005 and off[wall > 0.5].max() < 0.02
    assert (off > 0.02).sum() <= 16 and off.max() < 0.2


@pytest.mark.parametrize("degrees", angles(75, "3.07 % of stress on average; 2.59 with C = 0.25"))
def test_turned(degrees):
    """Walls that meet and cut the grid anywhere, by default: 4 particles a cell. Line by line (`wall_contact`), without
    what holds lines together, the stress is off by 0.4 to 1.1 of the pressure at an inner corner, the settlement by 1.2
    to 3.2 %."""
    top, off, wall = turned(degrees, APIC)
    assert abs(top) < 0.01
    assert off[wall > 1.0].max() < 0.06 and np.sqrt((off**2).mean()) < 0.03


@pytest.mark.parametrize("degrees", angles(60, "2.08 % and a particle with 22; 1.47 and 14 with C = 0.25"))
def test_turned_and_well_sampled(degrees):
    """With 16 particles a cell and the gradient of the shape functions: settlement to 0.02 %, stress within 2 % but for
    0 to 13 of 2048 particles, which lie alone in a cell beside a corner; they are off by up to 19 %, with 64 a cell by
    up to 5 %."""
    top, off, wall = turned(degrees, FINE, 4)
    assert abs(top) < 0.0005
    assert off[wall > 0.5].max() < 0.02
    assert (off > 0.02).sum() <= (0 if degrees in (15, 75) else 16) and off.max() < 0.2


@pytest.mark.xfail(strict=True, reason="2 of 2048 particles, in the corner: 12 and 3 %; with 64 particles a cell 4 of "
                                       "8192, up to 5 %; at 15 and 75 degrees none")
def test_stress_of_every_particle_turned_by_thirty_degrees():
    _, off, _ = turned(30, FINE, 4)
    assert off.max() < 0.02


def test_free_standing_and_turned_by_thirty_degrees():
    """nu = 0: no walls are needed. 1 m high, so that it does not buckle under its weight: (L / L_c)³ = 12 S (L / w)² /
    7.84 = 0.85, S = rho g L / E. Along the base too, but for its ends and for the cells that the faces cut."""
    width = 12
    place, height, off = settled_errors(SOFT, 1.0, APIC, angle=np.pi / 6, width=width, free=True)
    assert abs(height[place[:, 1] > 0.95 * CELLS].mean()) < 0.01
    x = np.minimum(place[:, 0], width - place[:, 0])
    inner = (x > 2.0) & (np.hypot(x, place[:, 1]) > 3.0)
    assert inner.sum() > 0.6 * len(place) and place[inner, 1].min() < 0.5
    assert np.abs(off[inner]).max() < 0.02


def test_half_its_height():
    """L = 50 m: every particle crosses cells; the base is squeezed to 0.18."""
    height, largest, typical = column_errors(SOFT, 50.0, CUBIC)
    assert exact_height(SOFT, 50.0, 50.0) == pytest.approx(24.2330658728, rel=1e-10)
    assert height < 0.001 and typical < 0.02 and largest < 0.1
