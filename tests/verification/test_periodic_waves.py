"""Standing waves in a periodic square (M6): order of displacement and stress, and the gates at 32 cells."""

import numpy as np
import pytest

from snowmpm.study.problems.periodic_waves import LAMBDA, LAW, StandingWaves, wave_errors
from snowmpm.study.problems.schemes import APIC, EVERY, PIC


def test_the_motion_is_in_balance():
    """ρ a = dP/dX + ρ b along each axis, P = τ / F, by differences."""
    motion, t, d = StandingWaves(0.05), 0.0037, 1e-4
    X = np.random.default_rng(2).uniform(0.0, 1.0, (20, 2))
    u = [motion.displacement(X, t + s * d * 0.01) for s in (-1, 0, 1)]
    acceleration = (u[0] - 2 * u[1] + u[2]) / (0.01 * d) ** 2
    for axis in range(2):
        step = d * np.eye(2)[axis]
        nominal = [(motion.kirchhoff(X + s * step, t) / motion.stretch(X + s * step, t))[:, axis] for s in (-1, 1)]
        # τ_i hangs on the other axis' stretch too, which P_i,i holds fixed
        force = (nominal[1] - nominal[0]) / (2 * d) / LAW.density + motion.body_force(X, t)[:, axis]
        np.testing.assert_allclose(acceleration[:, axis], force, rtol=0, atol=1e-5 * np.abs(force).max())
    assert LAMBDA + 2 * LAW.shear_modulus == pytest.approx(LAW.wave_speed() ** 2 * LAW.density)


# Least order of the displacement from 16 to 32 cells; largest errors of displacement and stress at 32
GATES = [
    (1.0, 3e-3, 2e-2), (2.7, 9e-3, 1.6e-2), (2.4, 6e-3, 2e-2), (2.1, 8e-3, 2e-2),  # quadratic: apic, pic, flip, aflip
    (1.7, 4e-3, 2.5e-2), (2.7, 8e-3, 2.5e-2), (2.4, 6.5e-3, 2.8e-2), (2.0, 8.5e-3, 2.8e-2),  # gradient "shape"
    (2.4, 1.5e-3, 3e-3), (2.4, 2e-2, 2e-2), (2.5, 7.5e-3, 1.2e-2), (2.0, 1e-2, 1.3e-2),  # cubic
    (2.3, 2.1e-3, 3.8e-3), (2.5, 1.8e-2, 1.8e-2), (2.5, 1e-2, 1.5e-2), (2.1, 1.1e-2, 1.4e-2),  # gradient "shape"
]


@pytest.mark.parametrize(("scheme", "per_axis", "gate"), [
    *((scheme, 2, gate) for scheme, gate in zip(EVERY, GATES, strict=True)), (APIC, 3, (1.5, 1e-3, 1.2e-2))],
    ids=[f"{scheme}-{per_axis}" for scheme, per_axis in [*((scheme, 2) for scheme in EVERY), (APIC, 3)]])
def test_order_and_gate(scheme, per_axis, gate):
    """Quadrature by the particles stops the second order of quadratic APIC: three per cell and axis go further than
    two; the smooth cubic ones do not feel it yet. What FLIP and PIC damp in a step of dx falls faster than dx^2 here.
    The whole tables: tests/benchmarks/order_tables.py."""
    order, displacement, stress = gate
    coarse, fine = (wave_errors(scheme, cells, per_axis=per_axis) for cells in (16, 32))
    assert np.log2(coarse.displacement / fine.displacement) > order
    assert fine.displacement < displacement and fine.stress < stress


def test_pic_damps():
    assert wave_errors(PIC, 16).displacement > 10 * wave_errors(APIC, 16).displacement
