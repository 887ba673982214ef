"""Cracks in a propagation saw test: whether, when and how fast they run (validation cases S2 to S4).

Slab of 0.5 m, 250 kg/m3, 3 MPa, elastic; weak layers W2 and W3 of 50 mm. The load on the flat is 1226 Pa, between the
Maxwell loads of W3 (887 Pa) and W2 (1471 Pa). All in plane strain with two cells through the weak layer, and again with
four where that matters.

Theories of the critical length do not agree with each other, nor do they hold all there is: WEAC's (brittle, elastic
weak layer) has no process zone and no inertia, the others a rigid layer (energy) or its shear alone (strength).
"""

import functools

import numpy as np
import pytest

import snowmpm
from snowmpm.saw_test import theory
from snowmpm.saw_test.prediction import column_of
from tests.verification.test_elastic_saw_test import of_weac

pytestmark = pytest.mark.slow

W2 = {"materials.weak_layer.hardening": 1.0, "materials.weak_layer.p0": 3.0e3}
STRONG_IN_SHEAR = {"materials.weak_layer.critical_slope": 1.8}
"""W3 bears 419 Pa in shear under the slab's weight on 35 degrees, which puts 703 Pa on it; so it bears 900 Pa."""
AS_GIVEN = {"materials.weak_layer": {"card": "gaume_weak_layer"}}
"""W3 without a reference thickness."""
AFTER = 0.03  # s after the crack has come through


@functools.cache
def _crack(items):
    scene = snowmpm.load_scene("pst_2d", {"initial.stress": "geostatic", **dict(items)})
    simulation, end = snowmpm.Simulation(scene), scene.end_time
    while simulation.time < end:
        simulation.step()
        if simulation.crack.rows["tip"][-1] >= scene.saw_test.length - 1e-9:
            end = min(end, simulation.time + AFTER)
    return simulation.crack.values(), simulation.crack.result(), scene


def crack(changes=None, **numbers):
    """Record, result and scene of pst_2d with some keys changed; `numbers` of its saw_test."""
    changes = {**(changes or {}), **{f"saw_test.{name}": value for name, value in numbers.items()}}
    if "materials.weak_layer" in changes:
        changes["materials.weak_layer"] = Frozen(changes["materials.weak_layer"])
    return _crack(tuple(sorted(changes.items())))


class Frozen(dict):
    """A table that may be part of a key."""

    def __hash__(self):
        return hash(tuple(sorted(self.items())))


def brittle_length(scene, slope_angle):
    """Cut [m] at which WEAC's energy release rate is the work of collapse of the weak layer."""
    _, law, thickness = column_of(scene)
    energy = theory.fracture_energy(law, thickness)
    cuts = np.linspace(0.02, 1.0, 50)
    rates = [of_weac(cut, slope_angle, length=4.0)[0] for cut in cuts]
    return float(np.interp(energy, rates, cuts))
