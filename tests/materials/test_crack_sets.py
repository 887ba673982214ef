"""Two cracks in a particle, cracks that make way for new ones, and cracks in material that yields."""

import law_suite
import numpy as np
import pytest
from law_suite import CHECKS, STATES, admissible, steps_of
from pydantic import ValidationError

from snowmpm.materials import CohesiveCamClay, CohesiveCrack, DruckerPrager, Elastic, StressUpdate, unpack
from snowmpm.materials.crack_excess import crack_excess
from snowmpm.materials.crack_planes import DAMAGE, NORMAL, OPENING, PER_CRACK

ELASTIC = {"density": 250.0, "youngs_modulus": 4e6, "poisson_ratio": 0.2}
CRACK = {**ELASTIC, "strength": 2e3, "fracture_energy": 0.1, "shear_ratio": 1.3, "friction_angle": 20.0,
         "length": 0.02}  # fmt: skip
SAND = {"kind": "drucker_prager", "friction_angle": 30.0, "cohesion": 3e3}
SNOW = {"kind": "cohesive_cam_clay", "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0, "p0": 1e4}
X, Y, SHEAR = np.diag([1.0, 0.0]), np.diag([0.0, 1.0]), np.array([[0.0, 0.0], [1.0, 0.0]])
M, LAME = 4e6 * 0.8 / (1.2 * 0.6), 4e6 * 0.2 / (1.2 * 0.6)
MU = np.tan(np.radians(20.0))


def cracking(**changes):
    return CohesiveCrack(**{**CRACK, **changes})


def follow(law, increments):
    """`Updated` of one point in plane strain along a path: A (steps, 2, 2)."""
    update = StressUpdate(law, 2)
    return update.integrate(np.zeros((1, 4)), update.initial_state(1), np.asarray(increments)[None])


def stretch(direction, strain, steps):
    """Equal logarithmic steps along an axis."""
    return np.repeat(np.expm1(strain / steps) * direction[None], steps, axis=0)


# ---- two cracks ------------------------------------------------------------------------------------------------------

HALF = 0.5 * 1e-4 / 0.02  # half of what opens a crack of CRACK, over its length
CROSSWISE = np.concatenate([stretch(X, HALF, 100), stretch(Y, HALF, 100), stretch(X + Y, 4.0 * HALF, 400)])


def test_a_second_crack_opens_across_the_first_and_takes_the_energy_too():
    law = cracking(cracks=2)
    path = follow(law, CROSSWISE)
    state, stress = path.state[0], path.stress[0]
    first, second = state[:, :PER_CRACK], state[:, PER_CRACK:]
    np.testing.assert_allclose(unpack(first[-1, NORMAL:]), np.diag([1.0, 0.0, 0.0]), atol=1e-9)
    np.testing.assert_allclose(unpack(second[-1, NORMAL:]), np.diag([0.0, 1.0, 0.0]), atol=1e-9)
    assert first[-1, DAMAGE] == second[-1, DAMAGE] == 1.0
    assert (second[first[:, NORMAL] < 0.5] == 0.0).all()
    assert path.dissipation.sum() * law.length == pytest.approx(2.0 * law.fracture_energy, rel=1e-9)
    # While both open, each bears what its own damage left, in material that both unload
    opening = np.flatnonzero((np.diff(first[:, DAMAGE]) > 0.0) & (np.diff(second[:, DAMAGE]) > 0.0)) + 1
    assert len(opening) > 50
    left = law.strength * (1.0 - np.stack([first[:, DAMAGE], second[:, DAMAGE]], axis=1))
    np.testing.assert_allclose(stress[opening, :2], left[opening], atol=1e-9 * law.strength)
    strain = np.cumsum(np.log1p(CROSSWISE[:, [0, 1], [0, 1]]), axis=0)
    strain -= np.stack([first[:, OPENING], second[:, OPENING]], axis=1) / law.length
    both = second[:, NORMAL + 1] > 0.5
    np.testing.assert_allclose(stress[both, :2], (strain @ [[M, LAME], [LAME, M]])[both], atol=1e-6 * law.strength)
    assert law.outputs(state[-1])["cracks"] == 2.0
    # A single crack lets the other direction bear more than the strength
    assert follow(cracking(), CROSSWISE).stress[0, :, 1].max() > 3.0 * law.strength


def test_a_crack_without_cohesion_makes_way_where_that_is_chosen():
    """Drawn to 2.5 times the opening of a crack: the particle cracks anew, and takes the energy twice and a half."""
    pull = stretch(X, 2.5 * 2.0 * HALF, 1000)
    once, again = follow(cracking(), pull), follow(cracking(reset=True), pull)
    assert once.dissipation.sum() * 0.02 == pytest.approx(0.1, rel=1e-9)
    law, state = cracking(reset=True), again.state[0, -1]
    assert state[PER_CRACK] == 2.0 and 0.0 < state[DAMAGE] < 1.0 and law.outputs(state)["cracks"] == 3.0
    begun = follow(law, stretch(X, 1.2 * 2.0 * HALF, 480)).state[0, -1]
    assert begun[PER_CRACK] == 1.0
    third = state[DAMAGE] * (2.0 - state[DAMAGE])  # share of G_f that a crack of this damage has taken
    assert again.dissipation.sum() * 0.02 == pytest.approx((2.0 + third) * 0.1, rel=1e-9)
    np.testing.assert_allclose(once.stress[0, :300], again.stress[0, :300], atol=1e-9)


# ---- around them, a law ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bulk", [SAND, pytest.param(SNOW, marks=pytest.mark.slow)], ids=lambda bulk: bulk["kind"])
def test_material_yields_under_pressure_and_cracks_in_tension_with_its_energy(bulk):
    """Compressed beyond yield, unloaded, drawn apart: the law around it, then the fracture energy, to 1 %."""
    law = cracking(bulk=bulk)
    alone = type(law.bulk).model_validate(law.bulk.model_dump())
    press = stretch(X, -0.02, 100)
    expected = follow(alone, press)
    back = float(np.linalg.solve([[M]], [expected.stress[0, -1, 0]])[0])
    pull = stretch(X, -back + 3.0 * HALF, 1200)
    path = follow(law, np.concatenate([press, pull]))
    first = law.first_of_bulk
    np.testing.assert_allclose(path.stress[0, :100], expected.stress[0], rtol=1e-10, atol=1e-7)
    np.testing.assert_allclose(path.state[0, :100, first:], expected.state[0], rtol=1e-10, atol=1e-14)
    assert expected.iterations[0, -1] > 0 and not path.state[0, :100, :first].any()
    strain = np.cumsum(np.log1p(np.concatenate([press, pull])[:, 0, 0]))
    force, length = path.stress[0, :, 0] / np.exp(strain), law.length * np.exp(strain)
    drawn = np.arange(len(force)) >= 100 + np.argmax(path.stress[0, 100:, 0] > 0.0)
    assert path.stress[0, drawn, 0].max() == pytest.approx(law.strength, rel=0.01) and path.state[0, -1, DAMAGE] == 1.0
    assert np.trapezoid(force[drawn], length[drawn]) == pytest.approx(law.fracture_energy, rel=0.01)


def test_faces_slide_while_the_material_yields():
    """Both conditions hold at the end of every step, and the path does not hang on its steps."""
    law = cracking(bulk=SAND)
    opened = np.concatenate([stretch(X, 3.0 * HALF, 60), stretch(X, -3.0 * HALF - 0.008, 60)])
    ends = []
    for steps in (25, 100):
        path = follow(law, np.concatenate([opened, np.repeat((0.05 / steps) * SHEAR[None], steps, axis=0)]))
        stress, state = path.stress[0, -1], path.state[0, -1]
        assert (path.iterations >= 0).all() and state[DAMAGE] == 1.0 and state[OPENING] == 0.0
        full = unpack(stress)
        assert abs(crack_excess(law, full, state)) < 1e-9 * np.abs(stress).max()
        assert abs(law.bulk.yield_function(full, state[law.first_of_bulk :])) < 1e-9 * np.abs(stress).max()
        assert abs(stress[3]) == pytest.approx(-MU * stress[0], rel=1e-9)
        sheared = path.state[0, 120:, law.first_of_bulk]
        assert sheared[-1] > sheared[0] + 1e-4
        ends.append(np.append(stress / 1e4, state[law.first_of_bulk] * 100.0))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.02, atol=0.02)


# ---- every law -------------------------------------------------------------------------------------------------------

SETS = {
    "two cracks": cracking(cracks=2),
    "in elastic": cracking(bulk={"kind": "elastic"}),
    "in Drucker-Prager": cracking(bulk=SAND),
    "in Cam-Clay": cracking(bulk=SNOW),
    "two in Drucker-Prager": cracking(cracks=2, bulk=SAND),
}
FEWER = 4000
SINGLE = "as of one crack: at onset the plane is known to round-off over the gap of the principal strains"
F32 = "steps to e^5 end without balance in f32, none in f64"
APEX = "{} of 1010 steps to e^5 end without balance in f64, and {} more are not within 1e-9 of it: the law reads its"
APEX += " strain from tensors whose eigenvalues are up to e^20 apart"
UNREACHED = {
    "two cracks": {"admissible": "4.8e-4 for 1e-5 in f32, none beyond 1e-9 in f64", "float32_follows_float64": SINGLE},
    "in elastic": {"finite_and_converged": F32, "float32_follows_float64": SINGLE},
    "in Cam-Clay": {"finite_and_converged": F32, "admissible": "1e-7 for 1e-9 in 4 steps to e^5",
                    "idempotent": "one step to e^5 is read back less well", "float32_follows_float64": SINGLE},
    **{name: {**dict.fromkeys(("finite_and_converged", "admissible", *more, "idempotent"), APEX.format(*figures)),
              "float32_follows_float64": SINGLE}
       for name, figures, more in (("in Drucker-Prager", (14, 259), ("objective",)),
                                   ("two in Drucker-Prager", (13, 115), ()))},
}
"""By example and check: what is asked and not reached, and why."""


def of_both(law, n, seed=0):
    """`admissible`, with what the law around the cracks allows in its own units."""
    if "p0" not in law.OUTPUTS:
        return admissible(law, n, seed)
    steps = steps_of(law, n, seed)
    for precision in law_suite.PRECISIONS:
        most = 1e-9 if precision == "f64" else 1e-5
        result = steps.result(precision)
        stress, state = unpack(result.stress.astype(float)), result.state.astype(float)
        assert (crack_excess(law, stress, state) / steps.stress_scale(stress)).max() < most
        p0 = np.maximum(law.outputs(state)["p0"], law.bulk.p0)
        assert (law.bulk.yield_function(stress, state[:, law.first_of_bulk :]) / p0**2).max() < most


@pytest.mark.slow
@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", SETS)
def test_the_suite_of_laws(name, check, request):
    if reason := UNREACHED.get(name, {}).get(check.__name__):
        request.applymarker(pytest.mark.xfail(strict=True, reason=reason, raises=AssertionError))
    check = of_both if check is admissible else check
    check(SETS[name], FEWER) if check.__code__.co_argcount > 1 else check(SETS[name])


MODERATE = (1e-4, 1e-3, 0.05)
"""Strains of steps, far above those of explicit ones."""


@pytest.fixture
def moderate_steps_in_double_precision(monkeypatch):
    """For the suite: of the sizes MODERATE only, in f64."""
    monkeypatch.setattr(law_suite, "SIZES", MODERATE)
    monkeypatch.setattr(law_suite, "PRECISIONS", ("f64",))
    steps_of.cache_clear()
    yield
    steps_of.cache_clear()


@pytest.mark.slow
@pytest.mark.usefixtures("moderate_steps_in_double_precision")
@pytest.mark.parametrize("check", STATES, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", SETS)
def test_the_suite_up_to_strains_of_five_per_cent(name, check):
    """As `test_the_suite_of_laws`, without what single precision and strains of e^5 spoil."""
    (of_both if check is admissible else check)(SETS[name], FEWER)


@pytest.mark.slow
def test_elastic_material_around_a_crack_is_the_crack_alone():
    pure, wrapped = cracking(), cracking(bulk={"kind": "elastic"})
    steps = steps_of(pure, FEWER)
    one, other = steps.result("f64"), StressUpdate(wrapped)(steps.h, steps.state, steps.A)
    scale = steps.stress_scale(unpack(one.stress))
    small = steps.small
    assert (np.abs(one.stress - other.stress).max(axis=1) / scale)[small].max() < 1e-10
    np.testing.assert_allclose(one.state[small, 0], other.state[small, 0], atol=1e-9)


# ---- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("changes", "said"), [
    ({"cracks": 3}, "cracks"),
    ({"cracks": 2, "reset": True}, "reset goes with cracks = 1"),
    ({"bulk": {"kind": "hypoplastic", "friction_angle": 30.0}}, "bulk"),
    ({"bulk": {**SAND, "density": 300.0}}, "bulk.density = 300 must be density of the material, 250"),
    ({"bulk": {**SNOW, "return_map": "substepped"}}, 'bulk.return_map = "substepped" must be "implicit"'),
    ({"bulk": {**SAND, "card": "lube_sand"}}, "bulk.card is not read"),
    ({"bulk": {**SAND, "friction": 1.0}}, "friction"),
    ({"bulk": {**SAND, "kind": "softening_cone", "residual_friction_angle": 20.0, "softening_strain": 0.1,
               "nonlocal_length": 0.5}}, "bulk.nonlocal_length is not computed around cracks"),
])
def test_what_does_not_go_together_is_refused(changes, said):
    with pytest.raises(ValidationError, match=said):
        cracking(**changes)


def test_the_law_around_cracks_has_the_numbers_of_the_material():
    law = cracking(bulk=SAND)
    assert isinstance(law.bulk, DruckerPrager) and law.bulk.youngs_modulus == law.youngs_modulus
    assert CohesiveCrack.model_validate(law.model_dump()) == law
    softer = law.thickened_to(0.1, 0.05)
    assert softer.bulk.youngs_modulus == softer.youngs_modulus == 2e6
    assert law.tensile_strength == 2e3 and cracking(bulk={**SAND, "cohesion": 100.0}).tensile_strength < 200.0
    grid = law.model_copy(update={"length": None}).on_grid(0.01)
    assert grid.length == 0.01 and grid.bulk == law.bulk
    assert {type(cracking(bulk=bulk).bulk) for bulk in (SNOW, {"kind": "elastic"})} == {CohesiveCamClay, Elastic}
