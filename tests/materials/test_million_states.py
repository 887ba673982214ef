"""Every law at random states and steps, up to principal logarithmic strains of 5: what may never fail anywhere.

Twenty thousand states a law and precision by default; a million with `pytest -m slow`. Hypothesis hunts for parameters
and trial states that break the Cam-Clay return map.
"""

import numpy as np
import pytest
from frictional_laws import LAWS as FRICTIONAL
from frictional_laws import hencky, stress_of, stretches
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from parameter_sets import W1, W2, A, B, C, changed, random_rotations
from return_maps import returned, violation
from round_off import representable

from snowmpm.materials import Elastic, Hypoplastic, StomakhinSnow, StressUpdate, pack, unpack

EXPONENTIAL = changed(C, hardening=1.0, hardening_law="exponential")
STOMAKHIN = StomakhinSnow(
    density=400.0, youngs_modulus=1.4e5, poisson_ratio=0.2, hardening=10.0, critical_compression=0.025,
    critical_stretch=0.0075,
)  # fmt: skip
SAND = Hypoplastic(density=1850.0, youngs_modulus=2e7, poisson_ratio=0.2, friction_angle=30.0)
LAWS = {
    "elastic": Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3),
    "modified Cam-Clay": B,
    "cohesive Cam-Clay": A,
    "cohesive Cam-Clay, exponential": EXPONENTIAL,
    "cohesive Cam-Clay, frozen": changed(A, return_map="frozen"),
    "cohesive Cam-Clay, substepped": changed(A, return_map="substepped"),
    "weak layer 1": W1,
    "weak layer 2": W2,
    "Stomakhin": STOMAKHIN,
    "hypoplastic": SAND,
    **FRICTIONAL,
}
DT = 1e-3
CHUNK = 100_000
SIZES = (1e-4, 1e-3, 0.05, 5.0)  # as many steps of each
RATE_SIZES = (1e-5, 1e-4, 1e-3, 0.01)  # stiffness grows with pressure: stresses grow e-fold in 0.003 of compression
ASSOCIATED = ("modified", "cohesive Cam-Clay", "von Mises")


def is_rate(law):
    return isinstance(law, Hypoplastic)


def random_steps(law, n, rng):
    """h, state, A and size of n steps from what two earlier ones left: on the surface, inside, or separated."""
    double = StressUpdate(law)
    h, state = np.zeros((n, 6)), double.initial_state(n)
    if is_rate(law):
        h = pack(law.h_from_stress(-rng.uniform(1e3, 1e5, n)[:, None, None] * np.eye(3)))
    reach = (0.1 if is_rate(law) else 1.0) * 10.0 ** -rng.uniform(0.0, 3.0, (n, 1))
    squeeze = np.expm1(-0.02 * rng.random((n, 1)) * reach)[:, :, None] * np.eye(3)
    before = double(h, state, squeeze, DT)
    before = double(before.h, before.state, stretches(n, 0.01 * reach, 3, rng), DT)
    size = rng.choice(RATE_SIZES if is_rate(law) else SIZES, n)
    A = np.empty((n, 3, 3))
    for s in np.unique(size):
        A[size == s] = stretches(int((size == s).sum()), s, 3, rng)
    # Numbers of float32, the same for both precisions
    return (*(a.astype(np.float32).astype(float) for a in (before.h, before.state, A)), size)


def chunks_of(n):
    return [(seed, min(CHUNK, n - seed * CHUNK)) for seed in range((n + CHUNK - 1) // CHUNK)]


def stress_scale(law, stress):
    """Size of each stress, at least one that the law can feel [Pa]."""
    return np.abs(stress).max(axis=(1, 2)) + 1e-4 * law.wave_speed() ** 2 * law.density


counts = pytest.mark.parametrize("n", [20_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
precisions = pytest.mark.parametrize("precision", ["f64", "f32"])
every_law = pytest.mark.parametrize("name", LAWS)


@counts
@precisions
@every_law
def test_finite_converged_admissible_dissipative(name, precision, n):
    law = LAWS[name]
    update = StressUpdate(law, 3, precision)
    n_plastic = 0
    for seed, count in chunks_of(n):
        h, state, A, _ = random_steps(law, count, np.random.default_rng(seed))
        result = update(h, state, A, DT)
        for array in (result.h, result.stress, result.state, result.dissipation):
            assert np.isfinite(array).all()
        # Left out are only steps to a strain that float32 cannot represent; they leave everything as it was
        made, start = result.iterations >= 0, np.eye(3) + unpack(h)
        if not is_rate(law):
            assert made[representable(np.eye(3) + A, start, precision)].all()
        assert made.mean() > (0.8 if precision == "f32" else 1.0 - 1e-9)
        if "frozen" not in name:  # whose state at the start may lie outside of the surface, to which it returns
            np.testing.assert_array_equal(result.h[~made], h[~made])
        if "substepped" not in name and not is_rate(law):
            assert result.iterations.max() <= 25
        n_plastic += (result.iterations > 0).sum()
        stress, new = unpack(result.stress.astype(float)), result.state.astype(float)
        if law.DISSIPATIVE:
            assert result.dissipation.min() >= (0.0 if precision == "f64" else -1e-6 * np.abs(stress).max())
        if "frozen" in name:
            continue  # admissible at the old surface only
        if hasattr(law, "critical_slope"):
            excess = law.yield_function(stress, new) / np.maximum(law.p0_at(new[:, 0]), law.p0) ** 2
        else:
            excess = law.yield_function(stress, new) / stress_scale(law, stress)
        # 1e-9 in double; float32 keeps what the surface depends on to 1e-7, times the slope of hardening
        assert excess.max() < (1e-9 if precision == "f64" else 1e-5)
    assert name == "elastic" or n_plastic > 0.02 * n


@counts
@every_law
def test_idempotent_and_objective(name, n):
    law = LAWS[name]
    update = StressUpdate(law)
    for seed, count in chunks_of(n):
        rng = np.random.default_rng(seed)
        h, state, A, size = random_steps(law, count, rng)
        result = update(h, state, A, DT)
        stress, scale = unpack(result.stress), stress_scale(law, unpack(result.stress))
        Q = random_rotations(count, rng)
        Qt = Q.transpose(0, 2, 1)
        turned = update(pack(Q @ unpack(h) @ Qt), state, Q @ A @ Qt, DT)
        off = np.abs(unpack(turned.stress) - Q @ stress @ Qt).max(axis=(1, 2))
        # Small steps to round-off. Stretches from e^−5 to e^5 spread the eigenvalues of b over e^20: the strain of the
        # smallest is known to 2e-16 e^20 = 1e-7, and the trial stress to that times the modulus
        small = size < 1.0
        lost = off / (np.abs(stress).max(axis=(1, 2)) + law.wave_speed() ** 2 * law.density)
        assert (off / scale)[small].max() < 1e-9 and lost.max() < 1e-6, ((off / scale)[small].max(), lost.max())
        if "frozen" in name or name == "mu(I)":
            continue  # the one has a new surface to return to, the other relaxes as time goes on
        again = update(result.h, result.state, np.zeros((count, 3, 3)), DT)
        off = np.abs(unpack(again.stress) - stress).max(axis=(1, 2)) / scale
        assert off.max() < 1e-8, off.max()


@counts
@pytest.mark.parametrize("name", [name for name in LAWS if name not in ("hypoplastic", "Stomakhin", "mu(I)")])
def test_elastic_inside_and_normal_flow(name, n):
    law = LAWS[name]
    update = StressUpdate(law)
    for seed, count in chunks_of(n):
        h, state, A, size = random_steps(law, count, np.random.default_rng(seed))
        result = update(h, state, A, DT)
        small = size < 1.0
        f = np.eye(3) + A
        trial = hencky(f @ (np.eye(3) + unpack(h)) @ f.transpose(0, 2, 1))
        stress, found = stress_of(law, trial), unpack(result.stress)
        separated = np.abs(unpack(h)).max(axis=(1, 2)) == 0.0  # with a gap to close first
        inside = small & ~separated & (law.yield_function(stress, state) < 0.0)
        assert inside.sum() > 0.001 * count
        assert not result.iterations[inside].any() and not result.dissipation[inside].any()
        np.testing.assert_array_equal(result.state[inside], state[inside])
        np.testing.assert_allclose(found[inside], stress[inside], atol=1e-12 * law.bulk_modulus)
        if not name.startswith(ASSOCIATED) or "frozen" in name or "substepped" in name:
            continue
        plastic = trial - law.hencky_from_stress(found)
        step = np.linalg.norm(plastic, axis=(1, 2))
        clear = small & ~separated & (result.iterations > 0) & (step > 1e-5)
        if hasattr(law, "critical_slope"):
            clear &= law.p0_at(result.state[:, 0]) > 1e-2 * law.p0
        else:
            clear &= np.abs(found).max(axis=(1, 2)) > 0.0
        assert clear.sum() > 0.02 * count
        normal = gradient(law, found[clear], result.state[clear])
        cosine = np.einsum("nij,nij->n", plastic[clear], normal) / (step[clear] * np.linalg.norm(normal, axis=(1, 2)))
        # By central differences of y, good to 1e-6 of an angle where the curvature is that of the whole surface
        assert cosine.min() > 1.0 - 1e-8, cosine.min()


def gradient(law, stress, state):
    """∂y/∂τ by central differences."""
    scale = 1e-5 * np.maximum(np.abs(stress).max(axis=(1, 2)), getattr(law, "p0", 0.0))
    result = np.zeros_like(stress)
    for i in range(3):
        for j in range(3):
            push = np.zeros((3, 3))
            push[i, j] += 0.5
            push[j, i] += 0.5
            ahead, behind = (law.yield_function(stress + s * scale[:, None, None] * push, state) for s in (1.0, -1.0))
            result[:, i, j] = (ahead - behind) / (2.0 * scale)
    return result


finite = {"allow_nan": False, "allow_infinity": False}


@settings(max_examples=400, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(
    slope=st.floats(0.05, 3.0), beta=st.floats(0.0, 1.0), hardening=st.just(0.0) | st.floats(1e-4, 30.0),
    log_p0=st.floats(0.0, 7.0), poisson=st.floats(-0.5, 0.49),
    p=st.floats(-1e9, 1e9, **finite), log_q=st.floats(-3.0, 9.5), zeta_share=st.floats(-2.0, 3.0),
)  # fmt: skip
def test_no_parameters_break_the_return_map(slope, beta, hardening, log_p0, poisson, p, log_q, zeta_share):
    law = changed(A, critical_slope=slope, cohesion=beta, hardening=hardening, p0=10.0**log_p0, poisson_ratio=poisson)
    state = [law.initial_zeta * zeta_share]
    p_new, q_new, new, iterations, yielded = returned(law, p, 10.0**log_q, state=state)
    assert np.isfinite([p_new[0], q_new[0], new[0, 0]]).all()
    assert 0 <= iterations[0] <= 50
    # Relative to the larger of the surface and what round-off of the trial stress leaves
    lost = 1e-12 * (abs(p) + 10.0**log_q) ** 2 / max(law.p0, 1e-4 * law.bulk_modulus) ** 2
    assert violation(law, p_new, q_new, new)[0] < 1e-9 + lost
    # Associated flow: never against the stress
    work = p_new[0] * (p - p_new[0]) / law.bulk_modulus + q_new[0] * (10.0**log_q - q_new[0]) / (3 * law.shear_modulus)
    assert work >= -1e-9 * (abs(p) + 10.0**log_q) ** 2 / law.shear_modulus
    if not yielded[0]:
        assert p_new[0] == p and new[0, 0] == state[0]
