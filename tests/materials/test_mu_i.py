"""μ(I) rheology: the friction really varies with the inertial number, implicitly in the rate of each step."""

import numpy as np
import pytest
from frictional_laws import LAWS
from parameter_sets import changed, diagonal, simple_shear
from pydantic import ValidationError

from snowmpm.materials import DruckerPrager, MaterialPoint, StressUpdate, pack, unpack

LAW = changed(LAWS["mu(I)"], youngs_modulus=1e9)
PRESSURE = 1e4
# γ̇ at which I = I₀
TYPICAL = LAW.inertial_number / LAW.grain_diameter * np.sqrt(PRESSURE / LAW.grain_density)


def friction(inertial):
    """μ(I) as it is printed."""
    return 0.38 + (0.64 - 0.38) / (1.0 + 0.279 / inertial)


def steady_shear(law, rate, dt, precision="f64"):
    """The last of enough steps of simple shear at a rate [1/s] to make it steady, from isotropic pressure."""
    step = rate * dt
    count = int(np.ceil(20.0 * law.limit_friction * PRESSURE / law.shear_modulus / step)) + 20
    path = MaterialPoint(law, precision).drive(simple_shear(law, PRESSURE, step * np.arange(1, count + 1)), dt)
    return path


@pytest.mark.parametrize("inertial", [1e-4, 1e-2, 0.279, 3.0, 100.0])
def test_steady_simple_shear_has_the_friction_of_its_rate(inertial):
    rate = TYPICAL * inertial / LAW.inertial_number
    path = steady_shear(LAW, rate, 1e-6 / rate)
    shear, p = path.kirchhoff[-1, 0, 1], path.p[-1]
    assert p == pytest.approx(PRESSURE, rel=1e-8)
    # Axes lag by elastic shear of 1e-5; the rate of the last step is steady to that too
    assert path.state[-1, 2] == pytest.approx(rate, rel=1e-4)
    assert shear / p == pytest.approx(friction(inertial), rel=1e-4)
    assert path.q[-1] / np.sqrt(3.0) / p == pytest.approx(shear / p, rel=1e-4)


def test_friction_spans_its_range():
    # It is no constant: the error of codes that evaluate I at the wrong time or in the wrong unit
    slow, fast = (steady_shear(LAW, TYPICAL * factor, 1e-6 / TYPICAL / factor) for factor in (1e-4, 1e4))
    ratios = [path.kirchhoff[-1, 0, 1] / path.p[-1] for path in (slow, fast)]
    np.testing.assert_allclose(ratios, [0.38, 0.64], rtol=1e-3)
    assert LAW.friction(0.0, PRESSURE) == 0.38
    assert LAW.friction(TYPICAL, PRESSURE) == pytest.approx(0.5 * (0.38 + 0.64))


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dt", [1e-9, 1e-5, 1e-3, 10.0])
def test_rate_of_the_step_is_implicit(dt, precision):
    # Whatever the step and however far the trial: q = √3 μ(I) p at the rate that took q from its trial value to it
    rng = np.random.default_rng(1)
    shear = np.exp(rng.uniform(np.log(3e-6), np.log(0.3), 2000))
    p_start = np.exp(rng.uniform(np.log(10.0), np.log(1e6), 2000))
    volume = -p_start / LAW.bulk_modulus / 3.0
    A = np.expm1(np.stack([volume + shear / 2.0, volume + shear / 2.0, volume - shear], axis=-1))[:, None] * np.eye(3)
    update = StressUpdate(LAW, 3, precision)
    result = update(np.zeros((2000, 6)), update.initial_state(2000), A, dt)
    stress = unpack(result.stress.astype(float))
    p = -np.trace(stress, axis1=1, axis2=2) / 3.0
    q = np.sqrt(1.5 * ((stress + p[:, None, None] * np.eye(3)) ** 2).sum(axis=(1, 2)))
    flows = (result.iterations > 0) & (p > 1e-3 * q)
    assert flows.sum() > 800
    plastic = shear - q / (3.0 * LAW.shear_modulus)
    inertial = np.sqrt(3.0) * plastic / dt * LAW.grain_diameter * np.sqrt(LAW.grain_density / np.maximum(p, 1e-9))
    # plastic strain is a difference: known to the round-off of the total; where it is small against it, not compared
    eps = 2e-16 if precision == "f64" else 1e-7
    known = flows & (plastic > 1e3 * eps * (shear + 1.0))
    assert known.sum() > 300
    rtol = 1e-3 if precision == "f64" else 3e-2
    np.testing.assert_allclose(q[known] / np.sqrt(3.0) / p[known], friction(inertial[known]), rtol=rtol)
    np.testing.assert_allclose(result.state[known, 2], np.sqrt(3.0) * plastic[known] / dt, rtol=rtol)
    # Exactly on the surface of the rate that the law reports
    value = LAW.yield_function(stress, result.state.astype(float))
    assert (np.abs(value[flows]) / (q + p)[flows]).max() < (1e-9 if precision == "f64" else 1e-5)


def test_slow_limit_is_the_plane_strain_cone():
    # sin φ = μ_s: the cone of plane strain, not tan φ
    cone = DruckerPrager(
        **{key: getattr(LAW, key) for key in ("density", "youngs_modulus", "poisson_ratio")},
        friction_angle=float(np.degrees(np.arcsin(0.38))),
        cone="plane_strain",
    )
    F = simple_shear(LAW, PRESSURE, np.linspace(0.0, 0.2, 60)[1:])
    slow = MaterialPoint(LAW).drive(F, dt=1e9)
    np.testing.assert_allclose(slow.kirchhoff, MaterialPoint(cone).drive(F).kirchhoff, rtol=1e-6, atol=1e-2)


def test_elastic_at_rest_and_relaxing_above():
    # Held still: below μ_s nothing changes, above it the stress creeps down to μ_s and never below
    q_rest = np.sqrt(3.0) * 0.38 * PRESSURE
    for q, relaxes in ((0.99 * q_rest, False), (1.5 * q_rest, True)):
        stress = q * np.diag([1.0, 1.0, -2.0]) / 3.0 - PRESSURE * np.eye(3)
        update = StressUpdate(LAW)
        held = update.integrate(
            pack(LAW.h_from_stress(stress))[None], update.initial_state(1), np.zeros((1, 200, 3, 3)), 1e-3
        )
        tau = unpack(held.stress[0])
        found = tau[:, 0, 0] - tau[:, 2, 2]
        assert (held.iterations[0] > 0).any() == relaxes
        if relaxes:
            assert (np.diff(found) <= 1e-9 * q).all() and found[0] < q
            assert found[-1] == pytest.approx(q_rest, rel=1e-3) and found[-1] >= q_rest * (1.0 - 1e-12)
            assert (held.dissipation[0] >= 0.0).all()
        else:
            np.testing.assert_allclose(found, q, rtol=1e-9)


def test_separation():
    t = np.concatenate([[-1e-4], np.linspace(0.0, 0.05, 6)[1:], np.linspace(0.05, -2e-4, 13)[1:]])
    path = MaterialPoint(LAW).drive(diagonal(t / 3.0, t / 3.0, t / 3.0))
    np.testing.assert_allclose(path.p, np.maximum(-LAW.bulk_modulus * t, 0.0), atol=1e-15 * LAW.bulk_modulus * 20)
    np.testing.assert_allclose(path.state[:, 1], np.maximum(t, 0.0), atol=1e-14)


@pytest.mark.parametrize("values", [{"limit_friction": 0.3}, {"grain_diameter": 0.0}, {"grain_density": -1.0}])
def test_impossible_grains_are_refused(values):
    with pytest.raises(ValidationError):
        changed(LAW, **values)
