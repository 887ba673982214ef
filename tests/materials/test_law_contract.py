"""What solvers and scenes rely on: schema, tables, derived numbers, and behaviour on bad input."""

import numpy as np
import pytest
import taichi as ti
from parameter_sets import W1, A, B, changed
from pydantic import TypeAdapter, ValidationError

from snowmpm.materials import (
    LAWS,
    AnticrackCamClay,
    CohesiveCamClay,
    Elastic,
    Law,
    Material,
    MaterialPoint,
    ModifiedCamClay,
    StressUpdate,
    pack,
    unpack,
)
from snowmpm.materials.parameters import named
from snowmpm.materials.precision import working_precision
from snowmpm.materials.stress_update import _update_kernel

ELASTIC = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
EXAMPLES = [ELASTIC, A, B, W1]
SLAB = {
    "kind": "cohesive_cam_clay",
    "density": 250.0,
    "youngs_modulus": 3e6,
    "poisson_ratio": 0.3,
    "critical_slope": 1.2,
    "cohesion": 0.3,
    "hardening": 1.0,
    "p0": 2e4,
}


def test_material_is_chosen_by_kind():
    adapter = TypeAdapter(Material)
    assert adapter.validate_python(SLAB) == CohesiveCamClay(**SLAB)
    assert {
        "elastic": Elastic,
        "modified_cam_clay": ModifiedCamClay,
        "cohesive_cam_clay": CohesiveCamClay,
        "anticrack_cam_clay": AnticrackCamClay,
    }.items() <= LAWS.items()
    for law in EXAMPLES:
        assert adapter.validate_python(law.model_dump()) == law
        assert LAWS[law.kind] is type(law)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("density", -1.0),
        ("density", float("nan")),
        ("youngs_modulus", 0.0),
        ("youngs_modulus", float("inf")),
        ("poisson_ratio", 0.5),
        ("poisson_ratio", -1.0),
        ("critical_slope", 0.0),
        ("cohesion", -0.1),
        ("cohesion", 1.1),
        ("hardening", -1.0),
        ("hardening", 1e-9),
        ("p0", -1.0),
        ("p0", "much"),
        ("poison_ratio", 0.3),
        ("kind", "camclay"),
    ],
)
def test_bad_parameters_are_refused_by_name(key, value):
    with pytest.raises(ValidationError) as error:
        TypeAdapter(Material).validate_python({**SLAB, key: value})
    assert key in str(error.value)


def test_laws_cannot_be_changed():
    with pytest.raises(ValidationError):
        A.p0 = 1.0


@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: law.kind)
def test_derived_numbers(law):
    E, nu = law.youngs_modulus, law.poisson_ratio
    modulus = E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))  # oedometric
    assert law.wave_speed() == pytest.approx(np.sqrt(modulus / law.density), rel=1e-14)
    assert len(law.initial_state()) == len(law.STATE)
    assert all(isinstance(x, float) for x in (*law.parameters(), *law.initial_state()))
    fields = law.outputs(np.tile(np.array(law.initial_state()), (5, 1)))
    assert set(fields) == set(law.OUTPUTS) and all(field.shape == (5,) for field in fields.values())
    if "p0" in fields:
        np.testing.assert_allclose(fields["p0"], law.p0, rtol=1e-13)
        np.testing.assert_allclose(fields["damage"], 0.0, atol=1e-13)


@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: law.kind)
def test_initial_stress_is_stored_and_read_back(law):
    rng = np.random.default_rng(2)
    stress = 1e3 * rng.normal(size=(50, 3, 3))
    stress += stress.transpose(0, 2, 1) - 4e3 * np.eye(3)
    law = law if law is ELASTIC else changed(law, p0=1e6)
    update = StressUpdate(law)
    result = update(pack(law.h_from_stress(stress)), update.initial_state(50), np.zeros((50, 3, 3)))
    np.testing.assert_allclose(unpack(result.stress), stress, atol=1e-9 * law.bulk_modulus * 1e-3)
    state = np.tile(np.array(law.initial_state()), (50, 1))
    assert (law.yield_of_invariants(2e3, 3e3, state) < 0.0).all()
    if law is not ELASTIC:
        assert (law.yield_of_invariants(2e6, 0.0, state) > 0.0).all()


def test_parameters_change_without_compiling():
    StressUpdate(A)(np.zeros((1, 6)), [A.initial_state()], np.zeros((1, 3, 3)))
    compiled = _update_kernel.cache_info().misses
    for law in (changed(A, p0=1e3), changed(A, hardening=0.0), B):  # B is the same function with beta = 0
        StressUpdate(law)(np.zeros((1, 6)), [law.initial_state()], np.zeros((1, 3, 3)))
    assert _update_kernel.cache_info().misses == compiled


def test_two_laws_in_one_kernel_with_a_common_table():
    # What a solver does: rows padded to the longest law, state columns to the largest, the law chosen per particle
    laws = (ELASTIC, A, W1)
    names = [type(law.parameters()) for law in laws]
    width, columns = max(len(law.parameters()) for law in laws), 2
    table = np.zeros((3, width))
    state = np.full((3, columns), 7.0)
    for i, law in enumerate(laws):
        table[i, : len(law.parameters())] = law.parameters()
        state[i, : len(law.STATE)] = law.initial_state()
    before = state.copy()
    stress = np.zeros((3, 6))

    @ti.kernel
    def update_all(table: ti.types.ndarray(), state: ti.types.ndarray(), stress: ti.types.ndarray()):
        for i in range(3):
            numbers = ti.Vector([table[i, k] for k in ti.static(range(width))])
            internal = ti.Vector([state[i, k] for k in ti.static(range(columns))])
            h = ti.Vector.zero(float, 6)
            f = ti.Matrix.zero(float, 3, 3)
            f[0, 0] = -0.1
            for k in ti.static(range(3)):
                if i == k:
                    h, tau, internal, _work, _count = laws[k].update(
                        named(names[k], numbers), h, internal, f, 1.0
                    )
                    for j in ti.static(range(6)):
                        stress[i, j] = tau[j]
            for k in ti.static(range(columns)):
                state[i, k] = internal[k]

    with working_precision("f64"):
        update_all(table, state, stress)
    for i, law in enumerate(laws):
        expected = MaterialPoint(law).drive(np.diag([0.9, 1.0, 1.0])[None])
        np.testing.assert_allclose(unpack(stress[i]), expected.kirchhoff[0], rtol=1e-12, atol=1e-9)
        np.testing.assert_array_equal(state[i, len(law.STATE) :], before[i, len(law.STATE) :])


NAN = np.full((3, 3), np.nan)
ONE_NAN = np.diag([0.0, np.nan, 0.0])
INFINITE = np.diag([np.inf, 0.0, 0.0])
INVERTED = np.diag([-2.5, 0.0, 0.0])
FLAT = np.diag([-1.0, 0.0, 0.0])


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: law.kind)
def test_impossible_steps_are_reported_and_left_out(law, dimension, precision):
    bad = np.array([NAN, ONE_NAN, INFINITE, INVERTED, FLAT, np.zeros((3, 3))])[:, :dimension, :dimension]
    update = StressUpdate(law, dimension, precision)
    h = np.tile(pack(law.h_from_stress(-1e3 * np.eye(3)), dimension), (6, 1))
    state = update.initial_state(6)
    result = update(h, state, bad)
    np.testing.assert_array_equal(result.iterations, [-1, -1, -1, -1, -1, 0])
    # What was before stays: the last row is the same state without a step
    for array in (result.h, result.stress, result.state):
        np.testing.assert_array_equal(array, np.tile(array[-1:], (6, 1)))
    assert np.isfinite(result.stress).all() and not result.dissipation.any()


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: law.kind)
def test_poisoned_state_is_reported(law, precision):
    update = StressUpdate(law, 3, precision)
    result = update(np.full((2, 6), np.nan), update.initial_state(2), np.zeros((2, 3, 3)))
    np.testing.assert_array_equal(result.iterations, -1)


@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: law.kind)
def test_squeezed_almost_flat(law):
    # det f -> 0: a stretch of exp(-5) and beyond in one step; finite, reported if not solved
    A_flat = np.array([np.diag([s - 1.0, 0.0, 0.0]) for s in (1e-2, 1e-4, 1e-6, 1e-12)])
    for precision in ("f32", "f64"):
        update = StressUpdate(law, 3, precision)
        result = update(np.zeros((4, 6)), update.initial_state(4), A_flat)
        assert np.isfinite(result.stress).all() and np.isfinite(result.h).all()
        assert (result.iterations >= -1).all()


def test_material_point_checks_its_path():
    point = MaterialPoint(A)
    for F in (np.eye(3), np.tile(np.eye(2), (4, 1, 1)), NAN[None], -np.eye(3)[None], np.zeros((1, 3, 3))):
        with pytest.raises(ValueError):
            point.drive(F)


def test_material_point_fields():
    F = np.tile(np.eye(3), (20, 1, 1))
    F[:, 0, 0] = np.linspace(1.0, 0.9, 21)[1:]
    path = MaterialPoint(A).drive(F)
    assert path.kirchhoff.shape == path.elastic_strain.shape == (20, 3, 3)
    J = np.linalg.det(F)
    elastic_volume = np.trace(path.elastic_strain, axis1=1, axis2=2)
    np.testing.assert_allclose(elastic_volume + path.plastic_volumetric_strain, np.log(J))
    np.testing.assert_allclose(path.plastic_volumetric_strain, A.initial_zeta - path.state[:, 0], atol=1e-13)
    np.testing.assert_allclose(path.p0, A.p0_at(path.state[:, 0]))
    assert (np.diff(path.dissipation) >= 0.0).all() and path.dissipation[-1] > 0.0
    plane = MaterialPoint(A, dimension=2).drive(F[:, :2, :2])
    np.testing.assert_allclose(plane.kirchhoff, path.kirchhoff, atol=1e-8)
    assert np.isnan(MaterialPoint(ELASTIC).drive(F).p0).all()


def test_law_without_an_update_is_only_a_contract():
    with pytest.raises(NotImplementedError):
        Law(density=1.0, youngs_modulus=1.0, poisson_ratio=0.0).parameters()
