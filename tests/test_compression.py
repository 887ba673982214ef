"""Stress against strain from what a piston felt, and the stages that are read off it."""

import numpy as np
import pytest

from snowmpm.results.compression import StressStrain, stages

HEIGHT, AREA = 2.0, 3.0  # m, m2
PEAK, PLATEAU, ONSET, END = 0.02, 0.6, 0.4, 0.55  # strain; share of the peak; strain; strain


def foam(strain):
    """A made-up stress [Pa]: straight rise to 1 kPa, fall to the plateau, steep line from ONSET on."""
    rise = 1e3 * strain / PEAK
    fall = np.interp(strain, [PEAK, 2.0 * PEAK, 1.0], [1e3, 1e3 * PLATEAU, 1e3 * PLATEAU])
    return np.where(strain < PEAK, rise, fall) + 4e4 * np.maximum(strain - ONSET, 0.0)


def pressed(speed=0.5, ripple=0.0, n=40_000):
    """A piston that comes down at a speed [m/s] after a pause, and the curve that it feels."""
    time = np.linspace(0.0, 0.1 + END * HEIGHT / speed, n)
    displacement = np.maximum(time - 0.1, 0.0) * speed
    strain = displacement / HEIGHT
    force = AREA * foam(strain) * (1.0 + ripple * np.sin(3000.0 * strain))
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))])
    return StressStrain.of_piston(time, impulse, displacement, HEIGHT, AREA)


def test_mean_stress_of_an_interval_is_the_impulse_over_its_time():
    curve = pressed()
    middle = curve.strain - 0.5 * (curve.strain[1] - curve.strain[0])
    assert curve.strain[-1] == pytest.approx(END)
    smooth = (np.abs(middle - PEAK) > 0.025) & (np.abs(middle - ONSET) > 0.005)  # not where the line has a corner
    np.testing.assert_allclose(curve.stress[smooth], foam(middle)[smooth], rtol=2e-3)


@pytest.mark.parametrize("ripple", [0.0, 0.05])
def test_the_four_stages(ripple):
    found = stages(pressed(ripple=ripple))
    assert found.modulus == pytest.approx(1e3 / PEAK, rel=0.05)
    assert found.peak_strain == pytest.approx(PEAK, abs=0.004)
    assert found.peak_stress == pytest.approx(1e3, rel=0.1)
    assert found.softened == pytest.approx(1e3 * PLATEAU, rel=0.07)
    assert found.plateau == pytest.approx(1e3 * PLATEAU, rel=0.05)
    assert found.densification == pytest.approx(ONSET, abs=0.02)
    assert found.hardening == pytest.approx(4e4, rel=0.1)


def test_a_curve_without_a_drop_has_no_stages():
    strain = np.linspace(0.01, 0.5, 100)
    assert stages(StressStrain(strain, 1e3 * strain)) is None


def test_a_curve_that_does_not_densify_has_no_stages():
    strain = np.linspace(0.001, 0.3, 200)
    assert stages(StressStrain(strain, np.minimum(foam(strain), 1e3 * PLATEAU + 1e-9 * strain))) is None
