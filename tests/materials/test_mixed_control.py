"""Mixed control of a material point: closed forms, control by stress against that by strain, what cannot be reached."""

import numpy as np
import pytest
from parameter_sets import SETS, W1, A, B, C, diagonal, isotropic

from snowmpm.compiler import ti
from snowmpm.materials import AnticrackCamClay, Elastic, LoadingError, LoadingStage, MaterialPoint, MixedControl
from snowmpm.materials.loading_stage import deformation_of
from snowmpm.materials.symmetric import COMPONENTS, PAIRS

ELASTIC = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
LATERAL = ("xx", "yy")


def column(rows, component, name="cauchy"):
    return np.array([getattr(row, name)[COMPONENTS.index(component)] for row in rows])


def test_controlled_strains_make_the_deformation_they_say():
    strain = np.array([0.1, -0.2, 0.3, 0.5, -0.7, 1.1])
    F = deformation_of(strain)
    assert np.linalg.det(F) == pytest.approx(np.exp(0.2), rel=1e-14)
    np.testing.assert_array_equal(np.tril(F, -1), 0.0)
    # Simple shear of an isotropically compressed sample, F = (I + γ e1⊗e2) F0, in any order
    sheared = deformation_of([-0.1, -0.1, -0.1, 3.0, 0.0, 0.0])
    expected = (np.eye(3) + 3.0 * np.eye(3)[:, [0]] @ np.eye(3)[[1]]) @ (np.exp(-0.1) * np.eye(3))
    np.testing.assert_allclose(sheared, expected, rtol=1e-15)


@pytest.mark.parametrize("stretch", [1e-6, 0.2, -0.3])
@pytest.mark.parametrize("steps", [1, 10])
def test_uniaxial_stress_gives_back_young_and_poisson(stretch, steps):
    # Hencky elasticity: τ_zz = E ε_zz and ε_xx = −ν ε_zz at any strain
    rows = MixedControl(ELASTIC).follow_stages([LoadingStage({"zz": stretch}, dict.fromkeys(LATERAL, 0.0), steps)])
    lateral = -ELASTIC.poisson_ratio * stretch
    # The lateral stress is zero to 1e-11 of the axial one; F carries round-off of 1e-16
    np.testing.assert_allclose(rows[-1].strain, [lateral, lateral, stretch, 0, 0, 0], rtol=1e-10, atol=1e-15)
    assert rows[-1].kirchhoff[2] == pytest.approx(ELASTIC.youngs_modulus * stretch, rel=1e-10, abs=1e-8)


def test_plane_strain_under_lateral_stress():
    # ε_yy = 0, σ_xx = 0: τ_zz = E / (1 − ν²) ε_zz and τ_yy = ν τ_zz
    row = MixedControl(ELASTIC).follow_stages([LoadingStage({"zz": -0.05}, {"xx": 0.0}, 5)])[-1]
    nu = ELASTIC.poisson_ratio
    stiffness = ELASTIC.youngs_modulus / (1.0 - nu**2)
    np.testing.assert_allclose(row.kirchhoff[1:3], [-0.05 * nu * stiffness, -0.05 * stiffness], rtol=1e-10)


@pytest.mark.parametrize("name", ["A", "B", "C"])
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_lateral_stress_is_held(name, precision):
    law = SETS[name]
    pressure = 0.4 * law.p0
    control = MixedControl(law, precision)
    start = control.consolidated(pressure)
    stage = LoadingStage({"zz": -0.3}, dict.fromkeys(LATERAL, -pressure), 100)
    for rows in (control.follow_stages([stage], start),
                 control.follow_stages([stage, LoadingStage({"zz": -0.29}, stage.stress, 50)], start)[100:]):
        for component in LATERAL:
            held = column(rows, component) / -pressure - 1.0
            # f64: 1e-11 of the largest stress. f32: 1e-5 of it, and 1e-8 of the stiffness, 0.04 Pa of 1200 Pa
            assert np.abs(held).max() < (1e-9 if precision == "f64" else 2e-4)
        assert not any(row.corrections > 10 for row in rows)


@pytest.mark.parametrize("free", ["zz", "xx yy", "xz", "zz xz", "xx yy zz", "xx yy zz xy yz xz"])
@pytest.mark.parametrize("law", [A, C, ELASTIC], ids=["A", "C", "elastic"])
def test_prescribed_stresses_give_back_the_strains_that_made_them(law, free):
    # Away from critical state a hardening law has one strain for a stress: control by stress must find it
    end = np.array([-0.02, -0.03, -0.06, 0.004, -0.006, 0.01])
    control = MixedControl(law)
    there = control.follow_stages([LoadingStage(dict(zip(COMPONENTS, end, strict=True)), {}, 20)])
    stages = []
    for row in there:
        stress = {c: row.cauchy[COMPONENTS.index(c)] for c in free.split()}
        strain = {c: row.strain[k] for k, c in enumerate(COMPONENTS) if c not in stress}
        stages.append(LoadingStage(strain, stress, 1))
    again = control.follow_stages(stages)
    # Stress is met to 1e-11; the tangent of a yielding law is down to a tenth of its stiffness
    np.testing.assert_allclose([row.strain for row in again], [row.strain for row in there], atol=1e-11, rtol=1e-8)
    np.testing.assert_allclose(again[-1].state, there[-1].state, rtol=1e-8)
    assert again[-1].dissipation == pytest.approx(there[-1].dissipation, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("law", [A, B, C, ELASTIC], ids=["A", "B", "C", "elastic"])
@pytest.mark.parametrize("steps", [1, 10])
def test_consolidation_meets_the_pressure(law, steps):
    for pressure in (0.0, 0.3 * 3e3, 2.0 * 3e4):  # elastic, and beyond the preconsolidation pressure
        control = MixedControl(law)
        point = control.consolidated(pressure)
        np.testing.assert_allclose(point.cauchy, [-pressure] * 3 + [0.0] * 3, rtol=1e-10, atol=1e-9 * pressure + 1e-12)
        np.testing.assert_array_equal(point.strain, 0.0)
        # Strains count from here, F from the stress-free state
        moved = control.follow_stages([LoadingStage({"zz": -0.01}, {}, steps)], point)[-1]
        np.testing.assert_allclose(moved.deformation, diagonal(0.0, 0.0, [-0.01])[0] @ point.deformation, rtol=1e-14)


def test_unloading_to_the_start_is_elastic():
    control = MixedControl(A)
    start = control.consolidated(10e3)
    held = dict.fromkeys(LATERAL, -10e3)
    stages = [LoadingStage({"zz": -0.1}, held, 50), LoadingStage({}, {**held, "zz": -10e3}, 20)]
    rows = control.follow_stages(stages, start)
    assert rows[49].iterations > 0 and not any(row.iterations for row in rows[50:])
    np.testing.assert_allclose(rows[-1].cauchy, [-10e3] * 3 + [0.0] * 3, rtol=1e-10, atol=1e-6)
    # Coaxial: the change of logarithmic strain is that of the elastic strain, from the stresses alone
    change = rows[-1].strain[:3] - rows[49].strain[:3]
    tau = rows[-1].kirchhoff[:3] - rows[49].kirchhoff[:3]
    nu = A.poisson_ratio
    np.testing.assert_allclose(change, ((1.0 + nu) * tau - nu * tau.sum()) / A.youngs_modulus, rtol=1e-8)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize(("lateral", "strength"), [(900.0, 728.1), (2000.0, 1200.0)], ids=["dry", "wet"])
def test_stress_beyond_the_strength_names_the_step(precision, lateral, strength):
    # Modified Cam-Clay on q = 3 (p − σ3). Wet side: hardens up to critical state, q = M 3 σ3 / (3 − M). Dry side:
    # softens from where it yields, q² = M² p (p0 − p), that is p = 1142.7 Pa
    control = MixedControl(B, precision)
    start = control.consolidated(lateral)
    step = 0.02 * strength  # so that the strength is met after 50 steps, and passed after 51 or 52
    with pytest.raises(LoadingError, match=r"stress xx = .* Pa cannot be reached; the last") as error:
        stage = LoadingStage({}, {"xx": -lateral, "yy": -lateral, "zz": -lateral - 100 * step}, 100)
        control.follow_stages([stage], start)
    # Critical state is reached in the limit only, and in float32 what is left is lost in round-off 3 % before it;
    # Cauchy stresses are 0.1 % above Kirchhoff's, which the strength is one of
    assert (50 if precision == "f64" else 48) <= error.value.step <= 52
    assert f"step {error.value.step}: " in str(error.value)


def test_tension_beyond_the_apex_is_refused():
    with pytest.raises(LoadingError, match="cannot be reached"):
        MixedControl(A).follow_stages([LoadingStage({}, dict.fromkeys(("xx", "yy", "zz"), 1.2 * A.beta * A.p0), 20)])


def test_pressure_beyond_collapse_is_refused():
    # A weak layer softens from p0 on: a larger pressure is not carried while its bonds last
    with pytest.raises(LoadingError, match=r"pressure of 4000 Pa cannot be applied: step 8"):
        MixedControl(W1).consolidated(4000.0)


class Reluctant(MixedControl):
    """Newton's method gives up on steps longer than `longest`."""

    longest = 0.3

    def _newton(self, point, target, dt, change):
        return None if dt > self.longest else super()._newton(point, target, dt, change)


def test_a_step_that_does_not_converge_is_made_in_parts():
    stage = {"strain": {"zz": -0.1}, "stress": dict.fromkeys(LATERAL, -10e3)}
    coarse = Reluctant(A)
    start = coarse.consolidated(10e3)
    halved = coarse.follow_stages([LoadingStage(**stage, steps=5, duration=5.0)], start)
    fine = MixedControl(A).follow_stages([LoadingStage(**stage, steps=20, duration=5.0)], start)
    for i, row in enumerate(halved):
        np.testing.assert_allclose(row.strain, fine[4 * i + 3].strain, rtol=1e-8)
        assert row.duration == 1.0
        assert row.dissipation == pytest.approx(sum(part.dissipation for part in fine[4 * i : 4 * i + 4]), rel=1e-7)


def test_a_failing_law_is_reported():
    # b = F Fᵀ beyond what f64 can hold
    with pytest.raises(LoadingError, match="step 1: the stress update failed"):
        MixedControl(ELASTIC).follow_stages([LoadingStage({"zz": 600.0}, {}, 1)])


@ti.func
def viscous_update(prm: ti.template(), h, state, A, dt):
    """τ = η (l + lᵀ), η = K."""
    tau = h
    for k in ti.static(range(h.n)):
        i, j = ti.static(PAIRS[k])
        tau[k] = prm.K * (A[i, j] + A[j, i]) / dt
    return h, tau, state, 0.0, 0


class Viscous(Elastic):
    """A law that reads dt only."""

    update = staticmethod(viscous_update)


def test_time_reaches_a_rate_dependent_law():
    law = Viscous(density=250.0, youngs_modulus=1.0, poisson_ratio=0.0)  # K = 1/3
    small = 1e-6  # so that f − I is ln f to 1e-6
    for duration in (0.5, 20.0):
        rows = MixedControl(law).follow_stages([LoadingStage({"xy": small, "zz": -small}, {"xx": 0.0}, 4, duration)])
        for row in rows:
            assert row.kirchhoff[3] == pytest.approx(small / duration / 3.0, rel=1e-5)
            assert row.kirchhoff[2] == pytest.approx(-2.0 * small / duration / 3.0, rel=1e-5)
    # Driven by stress: the strain rate it takes
    rows = MixedControl(law).follow_stages([LoadingStage({}, {"zz": 1e-6}, 1, 10.0)])
    assert rows[-1].strain[2] == pytest.approx(1e-6 * 10.0 / (2.0 / 3.0), rel=1e-4)  # f − I against ln f


def test_material_point_takes_legs_and_an_initial_stress():
    stress = -10e3 * np.eye(3)
    held = dict.fromkeys(LATERAL, -10e3)
    path = MaterialPoint(A).load([LoadingStage({"zz": -0.1}, held, 50)], stress=stress)
    # The initial stress is Kirchhoff's and Cauchy's, since F = I there
    np.testing.assert_allclose(path.cauchy[:, [0, 1], [0, 1]], -10e3, rtol=1e-9)
    again = MaterialPoint(A).drive(path.deformation, stress=stress)
    for name in ("kirchhoff", "p0", "plastic_volumetric_strain", "dissipation", "state"):
        np.testing.assert_allclose(getattr(again, name), getattr(path, name), rtol=1e-8, atol=1e-8)
    assert path.plastic_volumetric_strain[0] == pytest.approx(0.0, abs=1e-15)  # the first step is elastic


@pytest.mark.parametrize("dimension", [2, 3])
def test_drive_from_an_initial_stress(dimension):
    # Elastic: p = p_i + K x and the deviator stays
    stress = np.diag([-6e3, -6e3, -12e3])
    x = np.linspace(0.0, 1e-3, 6)[1:]
    F = isotropic(x) if dimension == 3 else diagonal(-x / 2.0, -x / 2.0, 0.0)[:, :2, :2]
    path = MaterialPoint(A, dimension=dimension).drive(F, stress=stress)
    np.testing.assert_allclose(path.p, 8e3 + A.bulk_modulus * x, rtol=1e-10)
    if dimension == 3:
        np.testing.assert_allclose(path.q, 6e3, rtol=1e-9)
    np.testing.assert_allclose(path.plastic_volumetric_strain, 0.0, atol=1e-14)


def test_a_layer_that_drops_its_load_bears_it_again():
    """A weak layer sheared under 1 kPa collapses: however fine the steps, it is followed to where it bears it again."""
    law = AnticrackCamClay(density=100.0, youngs_modulus=5e5, poisson_ratio=0.3, critical_slope=1.4, cohesion=0.3,
                           p0=2.7e3, hardening=0.15, softening=10.0)
    ends = []
    for steps in (50, 100):
        rows = MixedControl(law).follow_stages(
            [LoadingStage(strain={"xz": 0.05}, stress=dict.fromkeys(("zz",), -1e3), steps=steps)],
            MixedControl(law).consolidated(1e3))
        np.testing.assert_allclose(column(rows, "zz"), -1e3, rtol=1e-9)
        ends.append([rows[-1].strain[2], rows[-1].cauchy[4]])
    assert ends[1][0] < -0.01  # it has collapsed
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.05)


def test_wrong_starts_are_refused():
    with pytest.raises(ValueError, match="outside"):
        MaterialPoint(A).drive(isotropic([0.01]), stress=-2.0 * A.p0 * np.eye(3))
    with pytest.raises(ValueError, match="dimension = 3"):
        MaterialPoint(A, dimension=2).load([LoadingStage({"zz": -0.1})])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"strain": {"zx": 0.1}}, "zx"),
        ({"stress": {"z": 0.1}}, "z: a component is one of xx, yy"),
        ({"strain": {"zz": 0.1}, "stress": {"zz": 0.0}}, "only one"),
        ({"strain": {"zz": float("nan")}}, "zz = nan: must be finite"),
        ({"strain": {"zz": 0.1}, "steps": 0}, "at least one step"),
        ({"strain": {"zz": 0.1}, "duration": 0.0}, "some time"),
    ],
)
def test_wrong_legs_are_refused(values, message):
    with pytest.raises(LoadingError, match=message):
        LoadingStage(**values)
