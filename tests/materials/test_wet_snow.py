"""Snow whose cohesion falls with the water in its pores."""

import numpy as np
import pytest

from snowmpm.materials import DruckerPrager, MaterialPoint, WetSnow

SNOW = {"density": 350.0, "youngs_modulus": 1e6, "poisson_ratio": 0.25, "friction_angle": 25.0, "cohesion": 2e3}
SHEAR = np.tile(np.eye(3), (60, 1, 1))
SHEAR[:, 0, 1] = np.linspace(0.0, 0.03, 60)


def sheared(law):
    """q [Pa] along a simple shear."""
    return MaterialPoint(law, precision="f64").drive(SHEAR).q


def test_dry_snow_is_drucker_prager():
    np.testing.assert_allclose(sheared(WetSnow(**SNOW, water_weakening=23.5)), sheared(DruckerPrager(**SNOW)),
                               rtol=1e-12, atol=1e-9)


def test_water_takes_cohesion():
    """With a = 23.5 and 5 % of water, exp(-1.175) = 0.309 of it is left."""
    law = WetSnow(**SNOW, water_weakening=23.5, liquid_water=0.05)
    weaker = DruckerPrager(**{**SNOW, "cohesion": 2e3 * np.exp(-1.175)})
    np.testing.assert_allclose(sheared(law), sheared(weaker), rtol=1e-11, atol=1e-9)
    assert law.strength_share(np.array([0.0, 0.0295])) == pytest.approx([1.0, 0.5], abs=1e-3)


def test_friction_stays():
    law = WetSnow(**SNOW, water_weakening=1000.0)
    states = np.array([[0.0, 0.0, 0.2]])
    y = law.yield_of_invariants(np.array([1e4]), np.array([law.alpha * 1e4]), states)
    assert y[0] == pytest.approx(0.0, abs=1e-6)
