"""The crack within a particle: its energy for every length and mode, its published rate equations, faces that part,
close and slide, and its plane."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import solve_ivp

from snowmpm.materials import CohesiveCrack, StressUpdate, unpack
from snowmpm.materials.crack_planes import DAMAGE, NORMAL, OPENING

SNOW = CohesiveCrack(density=250.0, youngs_modulus=4e6, poisson_ratio=0.2, strength=4e3, fracture_energy=0.2,
                     shear_ratio=1.3, friction_angle=35.0, length=0.02)  # fmt: skip
MU = np.tan(np.radians(35.0))
X = np.diag([1.0, 0.0, 0.0])


def follow(law, increments, h=None, state=None):
    """`Updated` along a path of one point: A (steps, 3, 3)."""
    update = StressUpdate(law)
    h = np.zeros((1, 6)) if h is None else h
    return update.integrate(h, update.initial_state(1) if state is None else state, np.asarray(increments)[None])


def cracked_across_x(law):
    """h and state of a particle whose crack across x has just begun: stretched to 0.001 % beyond its strength."""
    strain = law.hencky_from_stress(law.strength * (1.0 + 1e-5) * X)
    path = follow(law, np.diag(np.expm1(np.diag(strain)))[None])
    assert path.state[0, -1, NORMAL] == pytest.approx(1.0)
    return path.h[:, -1], path.state[:, -1]


@pytest.mark.parametrize("length", [0.002, 0.01, 0.04])
def test_a_bar_takes_the_fracture_energy_whatever_the_length_of_its_particle(length):
    """F1: a bar of 0.1 m, one particle of which cracks; the rest is elastic and in series. Force over displacement has
    the area G_f, to 1 %."""
    law, bar = SNOW.model_copy(update={"length": length, "poisson_ratio": 0.0, "fracture_energy": 0.4}), 0.1
    assert length < law.largest_length
    stretches = np.linspace(0.0, 1.3 * law.complete_opening / length, 2001)
    path = follow(law, np.expm1(np.diff(stretches))[:, None, None] * X)
    force = path.stress[0, :, 0] / np.exp(stretches[1:])  # nominal
    displacement = length * np.expm1(stretches[1:]) + (bar - length) * force / law.youngs_modulus
    assert force.max() == pytest.approx(law.strength, rel=0.01) and abs(force[-1]) < 1e-9 * law.strength
    area = np.trapezoid(np.append(0.0, force), np.append(0.0, displacement))
    assert area == pytest.approx(law.fracture_energy, rel=0.01)
    assert path.dissipation.sum() * length == pytest.approx(law.fracture_energy, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 85.0])
def test_every_mode_that_opens_takes_the_fracture_energy(angle):
    """Jump along a line at this angle to the normal, work of the tractions on it; 1 % for strains of a few per cent."""
    law = SNOW
    h, state = cracked_across_x(law)
    turn = np.radians(angle)
    jump = 2.0 * law.complete_opening * np.array([np.cos(turn), np.sin(turn) / law.shear_ratio])
    steps = 4000
    A = np.zeros((steps, 3, 3))
    A[:, 0, 0], A[:, 1, 0] = jump[0] / law.length / steps, jump[1] / law.length / steps
    path = follow(law, A, h, state)
    assert path.state[0, -1, DAMAGE] == 1.0 and np.abs(path.stress[0, -1, [0, 3, 5]]).max() < 1e-9 * law.strength
    middle = 0.5 * (np.vstack([np.zeros(6), path.stress[0, :-1]]) + path.stress[0])
    work = (middle[:, 0] * A[:, 0, 0] + middle[:, 3] * A[:, 1, 0]).sum() * law.length
    # From the onset on: elastic energy of the particle, whose width is held, comes back too
    elastic = 0.5 * law.strength**2 / (law.bulk_modulus + 4.0 / 3.0 * law.shear_modulus) * law.length
    assert path.dissipation.sum() * law.length == pytest.approx(law.fracture_energy, rel=1e-4)
    assert work == pytest.approx(law.fracture_energy - elastic, rel=0.01)


def test_opening_and_slip_follow_their_rate_equations():
    """Eqs. 107-109 with this traction law, along a path that turns from opening to slip: SciPy, small strains."""
    law = SNOW.model_copy(update={"shear_ratio": 0.9})
    M, G = law.bulk_modulus + 4.0 / 3.0 * law.shear_modulus, law.shear_modulus
    K, beta, H = law.strength / law.complete_opening, law.shear_ratio, law.length
    most = 0.6 * law.complete_opening / H

    def rates(strain):
        """Of the strain path: normal and engineering shear strain."""
        turn = 0.5 * np.pi * strain
        return most * np.array([np.cos(turn), np.sin(turn)])

    def slope(s, y):
        t_n, t_s, kappa = y
        T = law.strength - K * kappa
        normal, shear = rates(s)
        # Jump along g = (t_n/T, t_s/(β²T)) λ; consistency of F = √(t_n² + t_s²/β²) − T
        g = np.array([t_n / T, t_s / (beta**2 * T)])
        stiff = np.array([M, G])
        flow = (g @ (stiff * [normal, shear])) / (g @ (stiff / H * g) - K)
        assert flow >= 0.0
        return [M * (normal - flow * g[0] / H), G * (shear - flow * g[1] / H), flow]

    exact = solve_ivp(slope, (0.0, 1.0), [law.strength, 0.0, 0.0], rtol=1e-9, atol=1e-12)
    h, state = cracked_across_x(law)
    off = []
    for steps in (400, 800):
        middle = (np.arange(steps) + 0.5) / steps
        A = np.zeros((steps, 3, 3))
        A[:, 0, 0], A[:, 1, 0] = rates(middle) / steps
        path = follow(law, A, h, state)
        found = path.stress[0, -1, 0], abs(path.stress[0, -1, 3]), law.complete_opening * path.state[0, -1, DAMAGE]
        off.append(np.abs(np.array(found) / [law.strength, law.strength, law.complete_opening]
                          - exact.y[:, -1] / [law.strength, law.strength, law.complete_opening]).max())
    # Strains of 3e-2 turn the plane by as much of a strain; what is left of the step falls with it
    assert off[1] < 0.01 and off[1] < off[0] + 1e-3


def broken(law):
    h, state = cracked_across_x(law)
    path = follow(law, (1.5 * law.complete_opening / law.length) * X[None], h, state)
    assert path.state[0, -1, DAMAGE] == 1.0
    return path.h[:, -1], path.state[:, -1]


def test_faces_touch_when_the_opening_is_gone():
    h, state = broken(SNOW)
    opening, M = state[0, OPENING], SNOW.bulk_modulus + 4.0 / 3.0 * SNOW.shear_modulus
    assert opening == pytest.approx(1.5 * SNOW.complete_opening + SNOW.strength / M * SNOW.length, rel=0.01)
    steps, shrink = 50, opening / SNOW.length
    path = follow(SNOW, np.tile(np.expm1(-2.0 * shrink / steps) * X, (steps, 1, 1)), h, state)
    closing, pressed = path.stress[0, : steps // 2 - 1, 0], path.stress[0, steps // 2 + 1 :, 0]
    assert np.abs(closing).max() < 1e-9 * SNOW.strength and (pressed < 0.0).all() and (np.diff(pressed) < 0.0).all()
    assert path.stress[0, -1, 0] == pytest.approx(-M * shrink, rel=0.01)
    assert path.state[0, -1, OPENING] == 0.0 and not path.dissipation.any()


def test_closed_faces_slide_with_their_friction():
    h, state = broken(SNOW)
    close = np.expm1(-(state[0, OPENING] / SNOW.length + 1e-3))
    A = np.zeros((41, 3, 3))
    A[0, 0, 0], A[1:, 1, 0] = close, 1e-3  # the plane x = const. stays in this shear
    path = follow(SNOW, A, h, state)
    normal, shear = path.stress[0, -1, 0], path.stress[0, -1, 3]
    n = unpack(path.state[0, -1, NORMAL : NORMAL + 6])
    assert n[0, 0] == pytest.approx(1.0, abs=1e-9)
    assert normal < 0.0 and abs(shear) == pytest.approx(-MU * normal, rel=1e-6)
    last = path.dissipation[0, -1]
    assert last == pytest.approx(abs(shear) * 1e-3, rel=0.01)  # all of a step's shear is slip


def test_the_plane_is_that_of_the_first_principal_stress_and_moves_with_the_material():
    law, update = SNOW, StressUpdate(SNOW)
    n = np.array([0.6, 0.48, 0.64])
    stress = law.strength * (1.2 * np.outer(n, n) - np.diag([0.04, 0.07, 0.1]))
    _, vectors = np.linalg.eigh(stress)
    start = update(np.zeros((1, 6)), update.initial_state(1), law.hencky_from_stress(stress)[None])
    np.testing.assert_allclose(unpack(start.state[0, NORMAL:]), np.outer(vectors[:, -1], vectors[:, -1]), atol=1e-3)
    f = np.eye(3) + np.array([[0.02, 0.3, 0.0], [0.0, -0.01, 0.1], [0.05, 0.0, 0.01]])
    moved = update(start.h, start.state, (f - np.eye(3))[None])
    m = np.linalg.solve(f.T, np.linalg.eigh(unpack(start.state[0, NORMAL:]))[1][:, -1])
    np.testing.assert_allclose(unpack(moved.state[0, NORMAL:]), np.outer(m, m) / (m @ m), atol=1e-12)


def test_no_crack_below_the_strength_and_none_in_compression():
    update = StressUpdate(SNOW)
    strains = [SNOW.hencky_from_stress(0.999 * SNOW.strength * X), -0.05 * np.eye(3), np.diag([-0.05, 0.0, 0.0])]
    result = update(np.zeros((3, 6)), update.initial_state(3), np.array(strains))
    # Compressed along one axis only, the others are held: nowhere in tension
    assert not result.state.any() and not result.iterations.any()


def test_particles_that_would_snap_back_are_refused():
    limit = SNOW.largest_length
    assert limit == pytest.approx(2.0 * 0.2 * SNOW.shear_modulus / 1.3**2 / 4e3**2)
    with pytest.raises(ValidationError, match="snaps back"):
        CohesiveCrack(**{**SNOW.model_dump(), "length": 1.01 * limit})
    free = SNOW.model_copy(update={"length": None})
    assert free.on_grid(0.5 * limit).length == 0.5 * limit and SNOW.on_grid(0.5 * limit) is SNOW
    with pytest.raises(ValueError, match="cells below"):
        free.on_grid(1.01 * limit)
