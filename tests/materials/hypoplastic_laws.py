"""Hypoplastic laws of the tests, from published tables, and paths of one point through them."""

import numpy as np
import pytest
from parameter_sets import changed
from scipy.linalg import expm

from snowmpm.materials import StressUpdate, pack
from snowmpm.materials.critical_state_hypoplastic import CriticalStateHypoplastic
from snowmpm.materials.hypoplastic import Hypoplastic
from snowmpm.materials.solid_to_gas import SolidToGas

# Rows of table 1 of Peng et al. (2015): E_i [Pa], nu_i, phi, psi [deg]; printed c1 .. c4; the same to three more digits
ROWS = {
    "oedometer": ((21e6, 0.2, 29.5, 1.0), (-58.3, -178.5, -589.0, -182.7), (-58.333, -178.501, -588.973, -182.727)),
    "collapse": ((20e6, 0.2, 30.0, 1.0), (-55.6, -171.2, -540.9, -170.9), (-55.556, -171.235, -540.905, -170.885)),
    "slope": ((30e6, 0.2, 30.0, 0.0), (-83.3, -264.9, -781.3, -255.2), (-83.333, -264.858, -781.250, -255.155)),
}


def calibrated(row, **others):
    E, nu, phi, psi = ROWS[row][0]
    return Hypoplastic(
        density=1850.0, youngs_modulus=E, poisson_ratio=nu, friction_angle=phi, dilation_angle=psi, **others
    )


OEDOMETER = Hypoplastic.from_coefficients(ROWS["oedometer"][1], density=1850.0)
SAND = Hypoplastic.from_coefficients(ROWS["collapse"][1], density=1850.0)
SLOPE = Hypoplastic.from_coefficients(ROWS["slope"][1], density=1850.0)
DENSITY = {
    "void_ratio": 0.7,
    "least_void_ratio": 0.5,
    "critical_void_ratio_limit": 0.55,
    "critical_void_ratio_drop": 0.25,
    "density_effect": 0.2,
}
DENSE = CriticalStateHypoplastic(density=1800.0, youngs_modulus=20e6, poisson_ratio=0.0, friction_angle=30.0, **DENSITY)
FAST = SolidToGas(**DENSE.model_dump(exclude={"kind"}), collision_time=8e-4)
BASIC = changed(DENSE, density_effect=0.0)  # f_d = 1: the four-parameter law of Wu and Bauer
LAWS = {"linear": SAND, "cohesive": changed(SAND, cohesion=2e3), "critical state": DENSE}
by_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
STRESS = -1e4 * np.array([[1.0, -0.1, 0.05], [-0.1, 0.8, 0.02], [0.05, 0.02, 0.6]])


def followed(law, stress, increments, precision="f64", dimension=3, state=None):
    """Update from a stress (3, 3) [Pa] through increments f − I (n, d, d), one point."""
    update = StressUpdate(law, dimension, precision)
    state = update.initial_state(1) if state is None else np.atleast_2d(state)
    return update.integrate(pack(stress, dimension)[None], state, np.asarray(increments)[None])


def stretching(L, steps, time=1.0):
    """Increments of the constant velocity gradient L over a time."""
    return np.tile(expm(np.asarray(L, float) * time / steps) - np.eye(3), (steps, 1, 1))
