"""The straight-line form of a law (`Law.vector_update`) against its `update`, alone and in packs of particles."""

from types import SimpleNamespace

import numpy as np
import pytest
from frictional_laws import stretches
from law_examples import EXAMPLES, STRAIGHT
from parameter_sets import A, changed

from snowmpm.compiler import ti
from snowmpm.materials import StressUpdate, pack
from snowmpm.materials.law import REDO
from snowmpm.materials.packs import LANES, held_numbers, read_lane, update_lane, update_pack, write_lane
from snowmpm.materials.parameters import named
from snowmpm.materials.precision import working_precision

LAWS = {
    **{name: EXAMPLES[name] for name in STRAIGHT},
    "exponential Cam-Clay": changed(EXAMPLES["exponential Cam-Clay"], hardening=3.0),
    "faint Cam-Clay": changed(A, p0=10.0, hardening=10.0),
}
ELASTIC = EXAMPLES["elastic"]
NEVER_YIELD = ("elastic", "neo-Hookean", "St. Venant-Kirchhoff")
LEFT_TO_UPDATE = {"modified Cam-Clay": 0.15, "faint Cam-Clay": 0.02, "weak layer 2": 0.05, "DP softening": 0.5}
"""Largest share of ordinary steps that are beyond the straight line, where it is not 1 %: those that are many times the
elastic range ask for more Newton steps, and a cohesion that softens asks for an exponential."""
DT = 1e-3
N = 3001  # not a whole number of packs

every_law = pytest.mark.parametrize("name", LAWS)
both_precisions = pytest.mark.parametrize("precision", ["f32", "f64"])
both_dimensions = pytest.mark.parametrize("dimension", [2, 3])
each_by_default = pytest.mark.parametrize(("precision", "dimension"), [
    ("f32", 3), ("f64", 2), pytest.param("f32", 2, marks=pytest.mark.slow),
    pytest.param("f64", 3, marks=pytest.mark.slow)])
"""Both precisions and both dimensions; every pair of them with the slow tests."""


def steps(law, dimension, sizes, rng):
    """h, state and A of N steps of the given sizes, in random order, from what two earlier ones of up to 2 % left: on
    the surface, on either side of it, inside, or separated. Numbers of float32, the same for both precisions."""
    double = StressUpdate(law, dimension, packed=False)
    reach = 0.02 * 10.0 ** -rng.uniform(0.0, 3.0, (N, 1))
    squeeze = np.expm1(-rng.random((N, 1)) * reach)[:, :, None] * np.eye(dimension)
    before = double(np.zeros((N, 4 if dimension == 2 else 6)), double.initial_state(N), squeeze, DT)
    before = double(before.h, before.state, stretches(N, 0.5 * reach, dimension, rng), DT)
    increments = stretches(N, rng.choice(sizes, (N, 1)), dimension, rng)
    return (a.astype(np.float32).astype(float) for a in (before.h, before.state, increments))


@ti.func
def leave(prm, h, state, A, dt):
    return h, 0.0 * h, state, 0.0, REDO


def straight(law):
    """A law that has its straight-line update only."""
    return SimpleNamespace(
        update=leave, vector_update=law.vector_update, STATE=law.STATE, parameters=law.parameters,
        initial_state=law.initial_state
    )


def assert_same(law, found, expected, precision):
    """Equal but for round-off and for what the last Newton step leaves: 0.02 of the fourth power of STEP_TOLERANCE."""
    unit = 3e-6 if precision == "f32" else 1e-12
    size = 1.0 + np.abs(expected.h).max(axis=1)
    stress_size = law.bulk_modulus * size + np.abs(expected.stress).max(axis=1)
    assert np.abs((found.h - expected.h) / size[:, None]).max() < unit
    assert np.abs((found.stress - expected.stress) / stress_size[:, None]).max() < unit
    assert np.abs((found.dissipation - expected.dissipation) / stress_size).max() < unit
    # The third variable is a rate: a strain over dt
    strains = (found.state - expected.state) * np.array([1.0, 1.0, DT])[: found.state.shape[1]]
    assert np.abs(strains / size[:, None]).max() < unit
    np.testing.assert_array_equal(found.iterations < 0, expected.iterations < 0)
    # A state on the surface to round-off may fall on either side of it
    differ = (found.iterations > 0) != (expected.iterations > 0)
    assert differ.mean() < (0.01 if precision == "f32" else 1e-3)


@each_by_default
@every_law
def test_packs_agree_with_one_by_one(name, precision, dimension):
    law = LAWS[name]
    h, state, A = steps(law, dimension, (1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0), np.random.default_rng(1))
    expected = StressUpdate(law, dimension, precision, packed=False)(h, state, A, DT)
    assert_same(law, StressUpdate(law, dimension, precision)(h, state, A, DT), expected, precision)


@both_precisions
@every_law
def test_straight_line_serves_ordinary_steps(name, precision):
    law = LAWS[name]
    h, state, A = steps(law, 3, (1e-4, 1e-3, 5e-3), np.random.default_rng(2))
    expected = StressUpdate(law, 3, precision, packed=False)(h, state, A, DT)
    found = StressUpdate(straight(law), 3, precision)(h, state, A, DT)
    left = found.iterations == REDO
    assert left.mean() <= LEFT_TO_UPDATE.get(name, 0.01)
    served = ~left
    chosen = [
        SimpleNamespace(**{field: getattr(result, field)[served] for field in vars(result)})
        for result in (found, expected)
    ]
    assert_same(law, *chosen, precision)
    assert name in NEVER_YIELD or name == "DP softening" or (expected.iterations[served] > 0).mean() > 0.02


@both_precisions
@pytest.mark.parametrize("name", ["elastic", "cohesive Cam-Clay", "weak layer 2", "DP dilating"])
def test_straight_line_leaves_what_is_beyond_it(name, precision):
    # Inside out, not finite, a large strain: REDO, whatever the rest of the answer may be
    law = LAWS[name]
    A = np.array([np.diag(s) for s in ([-2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0])])
    A = np.concatenate([A, [np.diag([0.5, 0.0, 0.0]), np.zeros((3, 3))]])
    h = np.zeros((6, 6))
    update = StressUpdate(straight(law), 3, precision)
    result = update(h, update.initial_state(6), A, DT)
    np.testing.assert_array_equal(result.iterations, [REDO] * 5 + [0])
    poisoned = update(np.full((1, 6), np.nan), update.initial_state(1), np.zeros((1, 3, 3)), DT)
    assert poisoned.iterations[0] == REDO


def test_hardening_beyond_the_series_is_left():
    law = changed(A, p0=1e7)  # asinh(p₀/K) = 2.1: sinh is no short series there
    update = StressUpdate(straight(law), 3)
    assert update(np.zeros((1, 6)), update.initial_state(1), np.zeros((1, 3, 3)), DT).iterations[0] == REDO


def test_packs_of_several_materials():
    # What a solver does: straight line where all of a pack is one material, one by one where it is not
    laws, rng = (ELASTIC, A), np.random.default_rng(3)
    names = [type(law.parameters()) for law in laws]
    n = 3 * LANES + 5
    material = np.zeros(n, np.int32)
    material[:LANES] = 1
    material[LANES : 2 * LANES] = rng.integers(0, 2, LANES)
    material[3 * LANES :] = 1
    table = np.zeros((2, len(A.parameters())))
    for row, law in zip(table, laws, strict=True):
        row[: len(law.parameters())] = law.parameters()
    h = pack(0.01 * rng.uniform(-1.0, 1.0, (n, 1, 1)) * np.eye(3), 2)
    state = np.full((n, 1), A.initial_zeta)
    steps = 0.01 * rng.uniform(-1.0, 1.0, (n, 2, 2))
    stress = np.zeros((n, 4))
    in_line = np.zeros(n, np.int32)

    columns = (("h", 4), ("tau", 4), ("A", 4), ("state", 1), ("held", held_numbers(A.vector_update, 4)))

    @ti.kernel
    def update_all(
        table: ti.types.ndarray(), material: ti.types.ndarray(), h: ti.types.ndarray(), state: ti.types.ndarray(),
        steps: ti.types.ndarray(), stress: ti.types.ndarray(), in_line: ti.types.ndarray(),
    ):  # fmt: skip
        for k in range((n + LANES - 1) // LANES):
            first = k * LANES
            count = ti.min(LANES, n - first)
            blank, count_blank = ti.Vector.zero(ti.f64, LANES), ti.Vector.zero(ti.i32, LANES)
            states = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)} | {
                "work": blank, "iterations": count_blank}
            same = True
            for lane in range(count):
                p = first + lane
                write_lane(states["h"], lane, ti.Vector([h[p, j] for j in ti.static(range(4))]))
                write_lane(states["state"], lane, ti.Vector([state[p, 0]]))
                write_lane(states["A"], lane, ti.Vector([steps[p, j // 2, j % 2] for j in ti.static(range(4))]))
                states["iterations"][lane] = REDO
                same = same and material[p] == material[first]
            for m in ti.static(range(2)):
                if same and material[first] == m:
                    numbers = ti.Vector([table[m, j] for j in ti.static(range(len(A.parameters())))])
                    update_pack(laws[m].vector_update, named(names[m], numbers), 1.0, states)
            for lane in range(count):
                in_line[first + lane] = ti.select(states["iterations"][lane] == REDO, 0, 1)
                for m in ti.static(range(2)):
                    if states["iterations"][lane] == REDO and material[first + lane] == m:
                        numbers = ti.Vector([table[m, j] for j in ti.static(range(len(A.parameters())))])
                        update_lane(laws[m].update, lane, named(names[m], numbers), 1.0, states)
                tau = read_lane(states["tau"], lane)
                for j in ti.static(range(4)):
                    stress[first + lane, j] = tau[j]

    with working_precision("f64"):
        update_all(table, material, h, state, steps, stress, in_line)
    for m, law in enumerate(laws):
        expected = StressUpdate(law, 2, packed=False)(h, state, steps)
        np.testing.assert_allclose(stress[material == m], expected.stress[material == m], atol=1e-12 * law.bulk_modulus)
    assert in_line[:LANES].all() and in_line[2 * LANES : 3 * LANES].all()
    assert not in_line[LANES : 2 * LANES].any() and in_line[3 * LANES :].all()
