"""Generalised vortex (M7): large shear and rotation, no wall; order in space, and the gate at dx = 1/64 m."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.study.problems.generalised_vortex import FREQUENCY, LAW, Vortex, vortex_errors
from snowmpm.study.problems.schemes import AFLIP, APIC, CLASSICAL, EVERY, FLIP

CUBIC_APIC = replace(APIC, kernel="cubic")


@pytest.mark.parametrize(("radius", "t", "radial", "around"), [
    (0.83, 0.3, 6.54130670264, -2.65566925595), (1.17, 0.5, -0.32523798795, -2.01374668337)])
def test_body_force(radius, t, radial, around):
    """Against values worked out from the equation of motion apart from this code; and the velocity and its gradient
    against differences of the motion."""
    motion, X = Vortex(1.0), np.array([[radius, 0.0]])
    along = motion.position(X, t)[0] / radius
    b = motion.body_force(X, t)[0]
    assert b @ along == pytest.approx(radial, rel=1e-10)
    assert b @ np.array([-along[1], along[0]]) == pytest.approx(around, rel=1e-10)
    d = 1e-6
    near = X + d * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    rate = (motion.position(X, t + d) - motion.position(X, t - d)) / (2 * d)
    np.testing.assert_allclose(motion.velocity(X, t), rate, rtol=0, atol=1e-8)
    x, v = motion.position(near, t), motion.velocity(near, t)
    F, F_rate = (np.stack([y[0] - y[1], y[2] - y[3]], axis=1) / (2 * d) for y in (x, v))
    np.testing.assert_allclose(motion.gradient(X, t)[0], F_rate @ np.linalg.inv(F), rtol=0, atol=1e-7)


def test_stress():
    """From F by differences: tau = lambda tr(eps) 1 + 2 mu eps of a volume that stays; and at rest at the end."""
    motion, X, d = Vortex(1.0), np.array([[0.6, 0.7]]), 1e-6
    near = X + d * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    y = motion.position(near, 0.3)
    F = np.stack([y[0] - y[1], y[2] - y[3]], axis=1) / (2 * d)
    values, axes = np.linalg.eigh(F @ F.T)
    tau = LAW.shear_modulus * (axes * np.log(values)) @ axes.T
    np.testing.assert_allclose(motion.kirchhoff(X, 0.3)[0], tau[[0, 1, 0], [0, 1, 1]], rtol=1e-7)
    assert np.abs(motion.kirchhoff(X, 1.0 / FREQUENCY)).max() < 1e-9 * LAW.shear_modulus


QUICK = (APIC, AFLIP, CUBIC_APIC)
"""Schemes whose order the quick tests measure; the others take a minute."""

ORDERS = [
    (2.0, 0.016), (0.5, 0.13), (1.7, 0.028), (1.55, 0.026),  # quadratic: apic, pic, flip, aflip
    (1.9, 0.018), (0.5, 0.13), (1.7, 0.031), (1.55, 0.029),  # gradient "shape"
    (2.15, 0.016), (0.35, 0.15), (1.95, 0.034), (1.6, 0.03),  # cubic
    (2.15, 0.017), (0.35, 0.15), (2.0, 0.034), (1.6, 0.031),  # gradient "shape"
]
"""Order of the displacement from 16 to 32 cells a metre with 4 particles a cell, and a bound of its error there. All
are of second order but PIC, whose damping goes as dx^2 / dt: of first, not reached before 64 cells (0.7). With
0.99 of FLIP a finer grid, with more steps, damps more of what lies between the nodes. Tables: tests/benchmarks."""


@pytest.mark.parametrize(("scheme", "declared"), [
    pytest.param(scheme, declared, id=str(scheme), marks=[pytest.mark.slow] * (scheme not in QUICK))
    for scheme, declared in zip(EVERY, ORDERS, strict=True)])
def test_order(scheme, declared):
    order, cap = declared
    coarse, fine = (vortex_errors(scheme, cells) for cells in (16, 32))
    assert np.log2(coarse.displacement / fine.displacement) == pytest.approx(order, abs=0.15)
    assert fine.displacement < cap


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "per_axis"), [
    (APIC, 2), (CUBIC_APIC, 2), (FLIP, 2), (AFLIP, 2), (CLASSICAL, 2), (APIC, 3), (CUBIC_APIC, 3)], ids=str)
def test_gate_on_the_fine_grid(scheme, per_axis):
    """M7 asks for 2 % of A R, though points slide past each other by 0.7 of their distance: the root mean square, as in
    M6. The worst particle, 2.9 % off, sits at the rim, whose cells two particles an axis fill unevenly; with three it
    is 0.5 % off."""
    errors = vortex_errors(scheme, 64, per_axis=per_axis)
    assert errors.displacement < (0.02 if per_axis == 2 else 0.004)
    assert errors.largest_displacement < (0.04 if per_axis == 2 else 0.01)
