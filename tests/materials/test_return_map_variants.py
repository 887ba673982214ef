"""Variants of the Cam-Clay update: their orders on the reference paths, their surfaces, other hardening laws."""

import numpy as np
import pytest
from cam_clay_reference import Reference
from parameter_sets import W1, W2, A, B, C, changed, isotropic, oedometer, simple_shear, undrained
from scipy.optimize import brentq

from snowmpm.materials import MaterialPoint

P_START = 27000.0
YIELD = {"oedometer": 8.4239814756e-3, "undrained": 3.5601966e-3, "shear": 6.1664512e-3}  # set A, printed digits


def path(kind, steps):
    """F of set A from yield on, in n steps after the elastic part, which is one step."""
    if kind == "oedometer":
        return oedometer(np.linspace(YIELD[kind], 0.05, steps + 1))
    if kind == "undrained":
        return undrained(A, P_START, np.linspace(YIELD[kind], 0.01, steps + 1))
    return simple_shear(A, P_START, np.linspace(YIELD[kind], 0.05, steps + 1))


REFERENCE = {  # p, q, z by an ODE integrator to 1e-12
    "oedometer": (69510.7124853, 46264.64683663, None),
    "undrained": (21362.319, 25367.157, None),
    "shear": (15248.422, 32174.465, 0.016700343),
}


@pytest.mark.parametrize("kind", REFERENCE)
@pytest.mark.parametrize(("return_map", "order"), [("implicit", 1), ("frozen", 1), ("substepped", 2)])
def test_order(kind, return_map, order):
    law = changed(A, return_map=return_map, substep_tolerance=1e6)  # one substep a step
    p, q, z = REFERENCE[kind]
    counts, errors = np.array([25, 50, 100, 200]), []
    for steps in counts:
        found = MaterialPoint(law).drive(path(kind, steps))
        errors.append(max(abs(found.p[-1] / p - 1.0), abs(found.q[-1] / q - 1.0)))
    measured = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order - 0.1 < measured < order + 0.35, (measured, errors)
    assert errors[-1] < {1: 2e-3, 2: 1e-5}[order]
    if z is not None:
        assert found.state[-1, 0] == pytest.approx(z, rel={1: 2e-3, 2: 1e-5}[order])


def test_modified_euler_has_the_error_of_an_independent_one():
    # Relative error of q at x = 0.05 with N plastic substeps of equal size, of a separate program
    q = REFERENCE["oedometer"][1]
    for steps, error in ((10, 4.0e-4), (100, 2.7e-6), (1000, 2.6e-8)):
        law = changed(A, return_map="substepped", substep_tolerance=1e6)
        found = MaterialPoint(law).drive(path("oedometer", steps))
        # That program leaves the drift in; here the return takes it out, at the same order
        assert abs(found.q[-1] / q - 1.0) < 2.0 * error


def test_tolerance_sets_the_error_of_one_large_step():
    errors = []
    for tolerance in (1e-2, 1e-4, 1e-6):
        found = MaterialPoint(changed(A, return_map="substepped", substep_tolerance=tolerance)).drive(
            oedometer(np.array([0.05]))
        )
        errors.append(abs(found.q[-1] / REFERENCE["oedometer"][1] - 1.0))
        # Some tens of substeps, each with its own error of at most the tolerance (of p₀, half of the q here)
        assert errors[-1] < 20.0 * tolerance
        assert 2 < found.iterations[-1] <= 1010
    assert errors[2] < 1e-2 * errors[0]
    # Backward Euler in the same one step
    assert abs(MaterialPoint(A).drive(oedometer(np.array([0.05]))).q[-1] / REFERENCE["oedometer"][1] - 1.0) > 0.02


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_which_variants_end_on_the_new_surface(precision):
    for return_map, limit in (("implicit", 1e-9), ("substepped", 1e-9), ("frozen", None)):
        found = MaterialPoint(changed(A, return_map=return_map), precision).drive(path("oedometer", 20))
        y = A.yield_of_invariants(found.p, found.q, found.state) / A.p0_at(found.state[:, 0]) ** 2
        if limit:
            assert y.max() < (limit if precision == "f64" else 1e-5)
        else:
            # p₀ grew by 4 % a step after the return to the old surface: inside by about as much, never on it
            assert -0.2 < y[2:].max() < -1e-3


@pytest.mark.slow
@pytest.mark.parametrize("law", [pytest.param(W1, id="W1"), pytest.param(W2, id="W2")])
def test_weak_layer_variants_agree_at_small_steps(law):
    F = oedometer(np.linspace(0.0, 0.4 if law is W1 else 0.05, 4001)[1:])
    reference = MaterialPoint(law).drive(F)
    for return_map in ("frozen", "substepped"):
        found = MaterialPoint(changed(law, return_map=return_map)).drive(F)
        assert (found.iterations >= 0).all()
        assert (np.diff(found.dissipation) >= -1e-12).all()
        assert found.state[-1, 1] == reference.state[-1, 1] == 1.0  # collapsed
        scale = np.abs(reference.kirchhoff).max()
        # First-order differences of 4000 steps, largest where the bonds break
        assert np.abs(found.kirchhoff - reference.kirchhoff).max() < 0.01 * scale


SOFT_CLAY = changed(B, hardening=25.0, hardening_law="exponential", p0=20e3)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_exponential_hardening_in_closed_form(precision):
    # x = Δz + p/K with p = p₀(0) exp(ξ Δz): exact for backward Euler in any number of steps
    K, p_start, xi = SOFT_CLAY.bulk_modulus, SOFT_CLAY.p0, SOFT_CLAY.hardening
    for x in (0.02, 0.05, 0.1):
        dz = brentq(lambda z, x=x: z + p_start * np.exp(xi * z) / K - x, 0.0, x, xtol=1e-16)
        for steps in (1, 7):
            found = MaterialPoint(SOFT_CLAY, precision).drive(isotropic(np.linspace(0.0, x, steps + 1)[1:]))
            # float32: ln J of 0.1 to 1e-8 a step, times K/p of 40
            assert found.p[-1] == pytest.approx(K * (x - dz), rel=1e-10 if precision == "f64" else 2e-5)
            assert found.state[-1, 0] == pytest.approx(dz, rel=1e-10 if precision == "f64" else 2e-5)
            assert found.p0[-1] == pytest.approx(p_start * np.exp(xi * dz), rel=1e-9 if precision == "f64" else 2e-5)


def test_exponential_hardening_reaches_critical_state_and_may_dilate_for_ever():
    law = changed(C, hardening=5.0, hardening_law="exponential")
    found = MaterialPoint(law).drive(undrained(law, 18000.0, np.linspace(0.0, 1.0, 401)[1:]))
    p0 = found.p0[-1]
    top = law.critical_slope * (1.0 + law.beta) * p0 / (2.0 * np.sqrt(1.0 + 2.0 * law.beta))
    assert found.p[-1] == pytest.approx((1.0 - law.beta) * p0 / 2.0, rel=1e-9)
    assert found.q[-1] == pytest.approx(top, rel=1e-9)
    assert np.log(p0 / law.p0) == pytest.approx(law.hardening * found.state[-1, 0], rel=1e-12)
    # Pulled apart until e^−20 of the strength is left: separated, and it must close before it carries
    t = np.concatenate([np.linspace(0.0, 6.0, 61)[1:], np.linspace(6.0, 3.5, 51)[1:]])
    pulled = MaterialPoint(law).drive(isotropic(-t))
    assert pulled.p[59] == 0.0 and (pulled.iterations >= 0).all()
    closed = 20.0 / law.hardening
    carries = np.flatnonzero((np.arange(len(t)) >= 60) & (pulled.p > 0.0))
    assert t[carries[0]] < closed + 1e-9 < t[carries[0] - 1] + 1e-6


CRITICAL_HARDENING = [  # critical slope, β, limit of ξ of another program (ν = 0.3, p₀ far below K)
    (1.5, 0.3, 3.306), (0.5, 0.0, 31.57), (1.2, 0.3, 3.333), (1.5, 0.5, 2.000), (0.5, 1.0, 1.000), (0.7, 0.2, 5.000),
]  # fmt: skip


@pytest.mark.parametrize(("slope", "beta", "limit"), CRITICAL_HARDENING)
def test_limit_of_unique_softening(slope, beta, limit):
    law = changed(A, critical_slope=slope, cohesion=beta, p0=3e3)
    assert law.critical_hardening() == pytest.approx(limit, rel=2e-3)  # four digits, and p₀/K of 1e-3


def test_limit_of_exponential_softening_is_that_of_its_slope():
    law = changed(A, hardening_law="exponential")
    ratio = law.critical_hardening() / A.critical_hardening()
    assert ratio == pytest.approx(np.hypot(A.bulk_modulus, A.p0) / A.p0, rel=1e-12)  # dp₀/dz of the two laws, over ξ


def test_softening_is_gradual_below_the_limit_and_a_jump_above_it():
    # Isotropic tension until the snow has separated: below the limit the stress goes down with the strain, in steps
    # that shrink with the step of strain; above it snaps from its strength to nothing, however small the step
    for share, gradual in ((0.8, True), (1.5, False)):
        law = changed(C, critical_slope=1.5, p0=3e3)
        law = changed(law, hardening=share * law.critical_hardening())
        strength = law.beta * law.p0
        losses = []
        for steps in (500, 5000):
            t = np.linspace(0.0, 2.0 * max(law.initial_zeta, strength / law.bulk_modulus), steps + 1)[1:]
            p = MaterialPoint(law).drive(isotropic(-t)).p
            assert p[-1] == 0.0 and p.min() < -0.9 * strength
            losses.append(np.diff(p).max() / strength)
        if gradual:
            assert losses[0] < 0.1 and losses[1] < 0.2 * losses[0], losses
        else:
            assert min(losses) > 0.9, losses


def test_no_hardening_keeps_its_surface():
    law = changed(A, hardening=0.0)
    assert law.p0_at(np.array([-1.0, 0.0, 3.0])).tolist() == [law.p0] * 3
    found = MaterialPoint(law).drive(oedometer(np.linspace(0.0, 0.2, 21)[1:]))
    np.testing.assert_allclose(found.p0, law.p0)
    assert found.p.max() <= law.p0 * (1.0 + 1e-9)


def test_reference_itself_reproduces_the_printed_path():
    # The integrator of cam_clay_reference.py against numbers of another program: neither is the project's law
    law = Reference(3e6, 0.3, 1.5, 0.3, 1.0, 30e3)
    gradient = np.diag([-1.0, 0.0, 0.0])
    _, _, p, q, z, _ = law.integrate(lambda t: gradient, 0.1)
    np.testing.assert_allclose((p[-1], q[-1], z[-1]), (125783.70, 83088.755, 0.061686233), rtol=1e-7)
