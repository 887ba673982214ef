"""What must hold for every law: checks that take a law, and random steps of it that they share.

Steps are up to principal logarithmic strains of 5, from states that two earlier steps left: on the surface, inside, or
separated. A law that stores its stress is driven by steps of 1 % at most.
"""

import functools
import math

import numpy as np
import pytest
from frictional_laws import hencky, stress_of, stretches
from parameter_sets import random_rotations
from pydantic import ValidationError
from round_off import representable

from snowmpm.materials import StressUpdate, pack, unpack

DT = 1e-3
SIZES = (1e-4, 1e-3, 0.05, 5.0)  # as many steps of each
RATE_SIZES = (1e-5, 1e-4, 1e-3, 0.01)  # stiffness grows with pressure: stresses grow e-fold in 0.003 of compression
PRECISIONS = ("f64", "f32")
COUNT = 20_000


class Steps:
    """Steps of a law: h (n, 6), state and A before, size of each step, and `result(precision)`."""

    def __init__(self, law, n, seed):
        self.law, self.rng = law, np.random.default_rng(seed)
        rate, update = law.STORED == "stress", StressUpdate(law)
        h, state = np.zeros((n, 6)), update.initial_state(n)
        if rate:
            h = pack(law.h_from_stress(-self.rng.uniform(1e3, 1e5, n)[:, None, None] * np.eye(3)))
        reach = (0.1 if rate else 1.0) * 10.0 ** -self.rng.uniform(0.0, 3.0, (n, 1))
        squeeze = np.expm1(-0.02 * self.rng.random((n, 1)) * reach)[:, :, None] * np.eye(3)
        before = update(h, state, squeeze, DT)
        before = update(before.h, before.state, stretches(n, 0.01 * reach, 3, self.rng), DT)
        self.size = self.rng.choice(RATE_SIZES if rate else SIZES, n)
        A = np.empty((n, 3, 3))
        for s in np.unique(self.size):
            A[self.size == s] = stretches(int((self.size == s).sum()), s, 3, self.rng)
        # Numbers of float32, the same for both precisions
        self.h, self.state, self.A = (a.astype(np.float32).astype(float) for a in (before.h, before.state, A))
        self.result = functools.cache(lambda precision: StressUpdate(law, 3, precision)(self.h, self.state, self.A, DT))
        self.small = self.size < 1.0

    def trial_strain(self):
        """Hencky strain (n, 3, 3) of the trial states."""
        f = np.eye(3) + self.A
        return hencky(f @ (np.eye(3) + unpack(self.h)) @ f.transpose(0, 2, 1))

    def stress_scale(self, stress):
        """Size of each stress (n, 3, 3), at least one that the law can feel [Pa]."""
        return np.abs(stress).max(axis=(1, 2)) + 1e-4 * self.law.wave_speed() ** 2 * self.law.density


@functools.lru_cache(maxsize=2)
def steps_of(law, n=COUNT, seed=0):
    """`Steps`, shared by the checks of a law, which should run one after the other."""
    return Steps(law, n, seed)


# ---- states ---------------------------------------------------------------------------------------------------------


def finite_and_converged(law, n=COUNT, seed=0):
    steps = steps_of(law, n, seed)
    for precision in PRECISIONS:
        result = steps.result(precision)
        for array in (result.h, result.stress, result.state, result.dissipation):
            assert np.isfinite(array).all()
        # Left out are only steps to a strain that float32 cannot represent; they leave everything as it was
        made = result.iterations >= 0
        if law.STORED == "strain":
            assert made[representable(np.eye(3) + steps.A, np.eye(3) + unpack(steps.h), precision)].all()
        assert made.mean() > (0.8 if precision == "f32" else 1.0 - 1e-9)
        if law.integration != "frozen":  # whose state at the start may lie outside of the surface, to which it returns
            np.testing.assert_array_equal(result.h[~made], steps.h[~made])
        if law.integration != "substepped" and law.STORED == "strain":
            assert result.iterations.max() <= 25
        assert (result.iterations > 0).mean() > 0.02 if law.YIELDS else not result.iterations[made].any()


def admissible(law, n=COUNT, seed=0):
    if law.integration == "frozen":
        return  # admissible at the old surface only
    steps = steps_of(law, n, seed)
    for precision in PRECISIONS:
        result = steps.result(precision)
        stress, state = unpack(result.stress.astype(float)), result.state.astype(float)
        excess, outputs = law.yield_function(stress, state), law.outputs(state)
        if "p0" in outputs:
            excess = excess / np.maximum(outputs["p0"], law.p0) ** 2
        else:
            excess = excess / steps.stress_scale(stress)
        # 1e-9 in double; float32 keeps what the surface depends on to 1e-7, times the slope of hardening
        assert excess.max() < (1e-9 if precision == "f64" else 1e-5)


def dissipative(law, n=COUNT, seed=0):
    for precision in PRECISIONS if law.DISSIPATIVE else ():
        result = steps_of(law, n, seed).result(precision)
        assert result.dissipation.min() >= (0.0 if precision == "f64" else -1e-6 * np.abs(result.stress).max())


def objective(law, n=COUNT, seed=0):
    steps = steps_of(law, n, seed)
    stress = unpack(steps.result("f64").stress)
    Q = random_rotations(n, np.random.default_rng(seed + 1))
    Qt = Q.transpose(0, 2, 1)
    state = steps.state.copy()
    for first in law.TENSORS:
        state[:, first : first + 6] = pack(Q @ unpack(state[:, first : first + 6]) @ Qt)
    turned = StressUpdate(law)(pack(Q @ unpack(steps.h) @ Qt), state, Q @ steps.A @ Qt, DT)
    off = np.abs(unpack(turned.stress) - Q @ stress @ Qt).max(axis=(1, 2))
    # Small steps to round-off. Stretches from e^−5 to e^5 spread the eigenvalues of b over e^20: the strain of the
    # smallest is known to 2e-16 e^20 = 1e-7, and the trial stress to that times the modulus
    lost = off / (np.abs(stress).max(axis=(1, 2)) + law.wave_speed() ** 2 * law.density)
    assert (off / steps.stress_scale(stress))[steps.small].max() < 1e-9 and lost.max() < 1e-6


def idempotent(law, n=COUNT, seed=0):
    if law.integration == "frozen" or law.RATE_DEPENDENT:
        return  # the one has a new surface to return to, the other relaxes as time goes on
    steps = steps_of(law, n, seed)
    result = steps.result("f64")
    again = StressUpdate(law)(result.h, result.state, np.zeros((n, 3, 3)), DT)
    off = np.abs(unpack(again.stress - result.stress)).max(axis=(1, 2))
    bound = 1e-8 * steps.stress_scale(unpack(result.stress))
    if law.STORED == "strain":
        # The volume is read from det b, whose terms are as large as the product of its diagonal: stretches from e^−5
        # to e^5 that stay elastic are read back to a few thousandths
        b = np.eye(3) + unpack(result.h)
        terms = np.einsum("nii->ni", b).prod(axis=1)
        speed = law.wave_speed() if law.stiffness is None else law.wave_speed_at(result.stress, result.state)
        bound += 4e-16 * terms / np.maximum(np.linalg.det(b), 1e-16 * terms) * speed**2 * law.density
    assert (off < bound).all()


def dt_is_read_where_declared(law):
    steps = steps_of(law)
    slow = StressUpdate(law)(steps.h, steps.state, steps.A, 1e3 * DT)
    assert np.array_equal(slow.stress, steps.result("f64").stress) != law.RATE_DEPENDENT


def elastic_inside(law, n=COUNT, seed=0):
    """Inside the surface of its state a law with a strain of its own follows Hencky's elasticity, and no more."""
    steps = steps_of(law, n, seed)
    strain = steps.trial_strain() if law.STORED == "strain" else None
    if strain is None or np.isnan(law.hencky_from_stress(np.zeros((3, 3)))).any():
        return
    stress, result = stress_of(law, strain), steps.result("f64")
    back = law.hencky_from_stress(stress[:1], steps.state[:1])
    if law.stiffness is not None or not np.allclose(back, strain[:1], rtol=1e-6):
        return  # its stress is another function of the strain
    state = steps.state.copy()
    for first in law.TENSORS:  # which turn with the step
        state[:, first : first + 6] = result.state[:, first : first + 6]
    if law.RATE_DEPENDENT:
        state = np.where([variable.unit == "1/s" for variable in law.STATE], 0.0, state)  # the strength at rest
    apart = np.abs(unpack(steps.h)).max(axis=(1, 2)) == 0.0  # with a gap to close first
    inside = steps.small & ~apart & (law.yield_function(stress, state) < 0.0)
    assert inside.sum() > 0.001 * n
    assert not result.iterations[inside].any() and not result.dissipation[inside].any()
    np.testing.assert_array_equal(result.state[inside], state[inside])
    np.testing.assert_allclose(unpack(result.stress)[inside], stress[inside], atol=1e-12 * law.bulk_modulus)


def normal_where_declared(law, n=COUNT, seed=0):
    if not law.associated:
        return
    steps = steps_of(law, n, seed)
    result, trial = steps.result("f64"), steps.trial_strain()
    stress = unpack(result.stress)
    plastic = trial - law.hencky_from_stress(stress, result.state)
    step = np.linalg.norm(plastic, axis=(1, 2))
    clear = steps.small & (np.abs(steps.h).max(axis=1) > 0.0) & (result.iterations > 0) & (step > 1e-5)
    outputs = law.outputs(result.state)
    clear &= outputs["p0"] > 1e-2 * law.p0 if "p0" in outputs else np.abs(stress).max(axis=(1, 2)) > 0.0
    assert clear.sum() > 0.02 * n
    normal = _gradient(law, stress[clear], result.state[clear])
    cosine = np.einsum("nij,nij->n", plastic[clear], normal) / (step[clear] * np.linalg.norm(normal, axis=(1, 2)))
    # By central differences of y, good to 1e-6 of an angle where the curvature is that of the whole surface
    assert cosine.min() > 1.0 - 1e-8


def _gradient(law, stress, state):
    """∂y/∂τ by central differences."""
    scale = 1e-5 * np.maximum(np.abs(stress).max(axis=(1, 2)), law.p0 if "p0" in law.OUTPUTS else 0.0)
    result = np.zeros_like(stress)
    for i in range(3):
        for j in range(3):
            push = np.zeros((3, 3))
            push[i, j] += 0.5
            push[j, i] += 0.5
            ahead, behind = (law.yield_function(stress + s * scale[:, None, None] * push, state) for s in (1.0, -1.0))
            result[:, i, j] = (ahead - behind) / (2.0 * scale)
    return result


def float32_follows_float64(law):
    steps = steps_of(law)
    single, double = steps.result("f32"), steps.result("f64")
    small = steps.size <= 0.05
    stress = unpack(double.stress)[small]
    off = np.abs(unpack(single.stress.astype(float))[small] - stress).max(axis=(1, 2))
    if law.STORED == "stress":
        # Rounding of f (1e-7) times the growth of stress with strain (1500 and more), and other sub-steps
        assert (off / steps.stress_scale(stress)).max() < 5e-3
    else:
        # The step turns by any angle, so terms of order 1 are rounded to 1e-7, whatever the strain
        stiffness = law.density * law.wave_speed_at(double.stress[small], double.state[small]) ** 2
        assert (off / stiffness).max() < 2e-6


def wave_speed_bounds_the_tangent(law):
    """Stress along any axis per strain along it, over a strain of 1e-7 either way, at states of small strain."""
    steps, update = steps_of(law), StressUpdate(law)
    near = np.flatnonzero(steps.small & (steps.size <= 1e-3))[:2000]
    start = steps.result("f64")
    h, state, stress = start.h[near], start.state[near], start.stress[near]
    axis = random_rotations(len(near), np.random.default_rng(5))[:, :, 0]
    bound = law.density * law.wave_speed_at(stress, state) ** 2
    still = update(h, state, np.zeros((len(near), 3, 3)), DT).stress
    for strain in (1e-7, -1e-7):
        moved = update(h, state, strain * axis[:, :, None] * axis[:, None, :], DT).stress
        along = np.einsum("ni,nij,nj->n", axis, unpack(moved - still), axis) / strain
        # Strains of a few per cent turn the tangent by as much; round-off of 1e-13 over 1e-7
        assert (along <= 1.1 * bound + 1e-3 * bound.max()).all()


# ---- contract -------------------------------------------------------------------------------------------------------


def numbers_are_declared_by_name(law):
    numbers = law.parameters()
    assert type(numbers)._fields and all(type(x) is float for x in (*numbers, *law.initial_state()))
    assert np.isfinite(np.asarray(numbers, np.float32)).all()
    assert type(law.model_copy().parameters()) is type(numbers)


def tables_round_trip(law):
    again = type(law).model_validate(law.model_dump())
    assert again == law and again.parameters() == law.parameters()
    assert type(law).model_validate_json(law.model_dump_json()) == law
    assert law.model_dump()["kind"] == type(law).model_fields["kind"].default


def bad_parameters_are_refused_by_name(law):
    table, cls = law.model_dump(), type(law)
    for name, value in table.items():
        if isinstance(value, float):
            for bad in (math.nan, math.inf, -math.inf, "much"):
                with pytest.raises(ValidationError, match=name):
                    cls.model_validate({**table, name: bad})
        if cls.model_fields[name].is_required():
            with pytest.raises(ValidationError, match=name):
                cls.model_validate({key: kept for key, kept in table.items() if key != name})
    for name, bad in (("density", 0.0), ("youngs_modulus", -1.0), ("poisson_ratio", 0.5), ("no_such_number", 1.0)):
        with pytest.raises(ValidationError, match=name):
            cls.model_validate({**table, name: bad})
    with pytest.raises(ValidationError):
        law.density = 1.0


def state_and_outputs_are_as_declared(law):
    assert len(law.initial_state()) == len(law.STATE)
    state = np.tile(np.array(law.initial_state()), (5, 1))
    fields = law.outputs(state)
    assert set(fields) == set(law.OUTPUTS) and all(field.shape == (5,) for field in fields.values())
    if "damage" in fields:
        np.testing.assert_allclose(fields["damage"], 0.0, atol=1e-13)
    free = np.zeros((5, 3, 3))
    assert (law.yield_function(free, state) <= 0.0).all()
    assert law.tensile_strength >= 0.0 and law.wave_speed() > 0.0 and 0.0 <= law.lateral_pressure <= 1.0
    assert not law.elastic_energy(np.zeros((5, 6)), state).any()
    if law.severed_state() is not None:
        severed = np.tile(np.array(law.severed_state()), (5, 1))
        assert severed.shape == state.shape and (law.yield_function(free, severed) <= 0.0).all()


def what_is_stored_is_as_declared(law):
    stress = np.array([-1e3 * np.eye(3), np.diag([-1.2e3, -1e3, -0.9e3])])
    h, state = law.h_from_stress(stress), np.array([law.initial_state()] * 2)
    if law.STORED == "stress":
        np.testing.assert_array_equal(h, stress)
        assert law.stiffness is not None  # nothing else would tell a step how stiff the stress makes it
    else:
        strain = hencky(np.eye(3) + h)
        np.testing.assert_allclose(law.hencky_from_stress(stress, state), strain, atol=1e-12)
        assert np.abs(h).max() < 1.0
    held = law.yield_function(stress, state) <= 0.0
    update = StressUpdate(law)
    read = unpack(update(pack(h), update.initial_state(2), np.zeros((2, 3, 3)), DT).stress)
    np.testing.assert_allclose(read[held], stress[held], atol=1e-9 * law.density * law.wave_speed() ** 2)


def impossible_steps_are_reported_and_left_out(law):
    bad = [np.full((3, 3), np.nan), *(np.diag(d) for d in ((0.0, np.nan, 0.0), (np.inf, 0.0, 0.0), (-2.5, 0.0, 0.0),
                                                           (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))]
    for dimension, precision in ((3, "f64"), (3, "f32"), (2, "f64")):
        update = StressUpdate(law, dimension, precision)
        h = np.tile(pack(law.h_from_stress(-1e3 * np.eye(3)), dimension), (6, 1))
        state = update.initial_state(6)
        result = update(h, state, np.array(bad)[:, :dimension, :dimension], DT)
        assert (result.iterations[:5] == -1).all() and result.iterations[5] >= 0
        assert np.isfinite(result.stress).all() and not result.dissipation[:5].any()
        if law.yield_function(-1e3 * np.eye(3), state[0]) < 0.0:
            # What was before stays
            np.testing.assert_array_equal(result.h[:5], h[:5].astype(result.h.dtype))
            np.testing.assert_array_equal(result.state[:5], state[:5].astype(result.state.dtype))
            # The last row is the same state without a step, maybe by the straight-line form: equal to round-off
            unit = 10.0 * np.finfo(result.h.dtype).eps * law.density * law.wave_speed() ** 2
            np.testing.assert_allclose(result.stress[:5], np.tile(result.stress[5:], (5, 1)), rtol=1e-6, atol=unit)


def poisoned_states_are_reported(law):
    for precision in PRECISIONS:
        update = StressUpdate(law, 3, precision)
        result = update(np.full((2, 6), np.nan), update.initial_state(2), np.zeros((2, 3, 3)), DT)
        np.testing.assert_array_equal(result.iterations, -1)


def almost_flat_is_finite(law):
    """Stretches of exp(−5) and beyond in one step: det f -> 0. Reported if not solved."""
    A = np.array([np.diag([s - 1.0, 0.0, 0.0]) for s in (1e-2, 1e-4, 1e-6, 1e-12)])
    for precision in PRECISIONS:
        update = StressUpdate(law, 3, precision)
        result = update(np.zeros((4, 6)), update.initial_state(4), A, DT)
        assert np.isfinite(result.stress).all() and np.isfinite(result.h).all() and (result.iterations >= -1).all()


def plane_strain_is_the_law_in_space(law):
    rng, update = np.random.default_rng(7), StressUpdate(law, 2)
    n = 500
    start = update.initial_state(n), stretches(n, 1e-3 if law.STORED == "stress" else 0.05, 2, rng)
    h = np.tile(pack(law.h_from_stress(-1e3 * np.eye(3))), (n, 1))
    plane = update(h[:, :4], *start, DT)
    A = np.zeros((n, 3, 3))
    A[:, :2, :2] = start[1]
    space = StressUpdate(law)(h, start[0], A, DT)
    unit = 60 * np.finfo(float).eps * law.density * law.wave_speed() ** 2
    scale = unit * (1.0 + np.abs(space.stress).max() / law.bulk_modulus * (1e3 if law.STORED == "stress" else 1.0))
    assert np.abs(space.stress[:, 4:]).max() < scale
    np.testing.assert_allclose(plane.stress, space.stress[:, :4], atol=scale)
    np.testing.assert_allclose(plane.state, space.state, rtol=1e-11, atol=1e-11)


STATES = (finite_and_converged, admissible, dissipative, objective, idempotent, elastic_inside, normal_where_declared)
"""Checks of n random steps: check(law, n, seed)."""

CHECKS = (
    *STATES, dt_is_read_where_declared, float32_follows_float64, wave_speed_bounds_the_tangent,
    numbers_are_declared_by_name, tables_round_trip, bad_parameters_are_refused_by_name,
    state_and_outputs_are_as_declared, what_is_stored_is_as_declared, impossible_steps_are_reported_and_left_out,
    poisoned_states_are_reported, almost_flat_is_finite, plane_strain_is_the_law_in_space,
)  # fmt: skip
"""All checks: check(law)."""
