"""Hypothesis hunts for parameters and trial states that break the Cam-Clay return map."""

import numpy as np
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from parameter_sets import A, changed
from return_maps import returned, violation

MOST_COMPRESSION = 56.0
"""Trial pressure over K of the smallest b = I + h that float64 can hold, whose eigenvalues are 1e-16: -1.5 ln 1e-16."""
finite = {"allow_nan": False, "allow_infinity": False}


@settings(max_examples=400, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(
    slope=st.floats(0.05, 3.0), beta=st.floats(0.0, 1.0), hardening=st.just(0.0) | st.floats(1e-4, 30.0),
    log_p0=st.floats(0.0, 7.0), poisson=st.floats(-0.5, 0.49),
    p=st.floats(-1e9, 1e9, **finite), log_q=st.floats(-3.0, 9.5), zeta_share=st.floats(-2.0, 3.0),
)  # fmt: skip
@example(slope=1.0, beta=1.0, hardening=2.0, log_p0=0.0, poisson=0.0, p=34501284.0, log_q=8.0, zeta_share=0.0)
@example(slope=1.4, beta=1.0, hardening=10.0, log_p0=3.0, poisson=-0.4, p=1e9, log_q=9.5, zeta_share=0.0)
def test_no_parameters_break_the_return_map(slope, beta, hardening, log_p0, poisson, p, log_q, zeta_share):
    law = changed(A, critical_slope=slope, cohesion=beta, hardening=hardening, p0=10.0**log_p0, poisson_ratio=poisson)
    p = min(p, MOST_COMPRESSION * law.bulk_modulus)
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
