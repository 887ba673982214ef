"""What solvers and scenes rely on: schema, tables, derived numbers, and behaviour on bad input."""

import numpy as np
import pytest
from law_examples import EXAMPLES
from parameter_sets import W1, A, B, changed
from pydantic import TypeAdapter, ValidationError

from snowmpm.compiler import ti
from snowmpm.materials import Elastic, Law, Material, MaterialPoint, StressUpdate, unpack
from snowmpm.materials.parameters import named
from snowmpm.materials.precision import working_precision
from snowmpm.materials.stress_update import _update_kernel

ELASTIC = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
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


@pytest.mark.parametrize("name", [name for name in EXAMPLES if EXAMPLES[name].stiffness is None])
def test_derived_numbers(name):
    law = EXAMPLES[name]
    E, nu = law.youngs_modulus, law.poisson_ratio
    modulus = E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))  # oedometric
    assert law.wave_speed() == pytest.approx(np.sqrt(modulus / law.density), rel=1e-14)
    fields = law.outputs(np.array([law.initial_state()]).reshape(1, -1))
    assert fields.get("p0", [0.0])[0] == pytest.approx(getattr(law, "p0", 0.0), rel=1e-13)


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


def test_material_point_checks_its_path():
    point = MaterialPoint(A)
    flat, inverted, unknown = np.zeros((1, 3, 3)), -np.eye(3)[None], np.full((1, 3, 3), np.nan)
    for F in (np.eye(3), np.tile(np.eye(2), (4, 1, 1)), unknown, inverted, flat):
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
