"""Gravity over time and damping in motion, against closed forms, with the energies that the audit books."""

import numpy as np
import pytest

from tests.components.forcing_and_damping.forced_block import METHODS, SNOW, centre, mean_velocity, run, stage

G = 9.81


@pytest.mark.parametrize("method", METHODS)
def test_fall_in_gravity_that_grows(method):
    """v = -int g, exact; the work of gravity is the kinetic energy."""
    sim = stage(method, gravity={"value": G, "ramp": 0.4})
    row = run(sim, 0.4)
    assert mean_velocity(sim)[1] == pytest.approx(-0.5 * G * 0.4, rel=1e-12)
    assert row["kinetic_energy"] > 100.0
    assert -row["potential_energy"] == pytest.approx(row["kinetic_energy"], rel=0.02)
    assert abs(row["energy_remainder"]) < 0.02 * row["kinetic_energy"]
    assert row["momentum_residual"] < 1e-12
    # Twice the time: constant gravity since the end of the ramp
    start, speed = centre(sim)[1], -mean_velocity(sim)[1]
    row = run(sim, 0.8)
    assert start - centre(sim)[1] == pytest.approx(speed * 0.4 + 0.5 * G * 0.16, rel=0.01)
    assert abs(row["energy_remainder"]) < 0.01 * row["kinetic_energy"]


def test_work_of_gravity_converges():
    """The remainder of a fall in changing gravity is the scheme's, of first order in dt."""
    left = [abs(run(stage(gravity={"value": G, "ramp": 0.4}, solver={"dx": 0.1, "dt": dt, "precision": "f64"}),
                    0.4)["energy_remainder"]) for dt in (4e-4, 2e-4)]
    assert left[0] / left[1] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("method", METHODS)
def test_stress_under_a_column_follows_gravity(method):
    """A confined elastic column, loaded slowly against its waves (period 0.03 s) and its damping (lag c / omega^2 < 1
    ms): the reaction of the ground is M g(t), tilted gravity presses on the side."""
    height = 0.8
    sides = {"x_min": "slip", "x_max": "slip", "z_min": "slip"}
    sim = stage(method, shape={"kind": "box", "min": [0.0, 0.0], "max": [0.4, height]},
                domain={"min": [0.0, 0.0], "max": [0.4, 1.2], "boundary": sides}, damping={"coefficient": 25.0},
                material={**SNOW, "youngs_modulus": 4e6},
                gravity={"times": [0.0, 0.3, 0.6], "values": [0.0, G, 0.5 * G], "tilts": [0.0, 0.0, 30.0]})
    mass = sim.solver.particles.mass
    for time in (0.15, 0.3, 0.6):
        run(sim, time - 0.04)
        before = sim.solver.impulse - sim.solver._loaded
        row = run(sim, time)
        mean = (sim.solver.impulse - sim.solver._loaded - before) / 0.04
        gravity = sim.model.gravity.mean(time - 0.04, time)
        np.testing.assert_allclose(mean, -mass * gravity, atol=0.03 * mass * G)
        fields = sim.particles
        depth = height - fields["position"][:, 1]
        deep = (depth > 0.3) & (depth < 0.7)
        expected = 400.0 * depth[deep] * sim.model.gravity.at(time)[1]
        assert np.mean(fields["stress"][deep, 1] / expected) == pytest.approx(1.0, abs=0.03)
    # Walls at rest without friction do no work
    remainder = row["energy_remainder"] + row["contact_work"]
    assert abs(remainder) < 0.05 * (row["elastic_energy"] + row["damping_work"])


@pytest.mark.parametrize("transfer", ["apic", "pic", "flip", "sph"])
def test_free_motion_decays_exponentially(transfer):
    """v = v0 exp(-c t) at any dt; what is lost is the damping work."""
    ends = []
    for dt in (1e-3, 2.5e-4):
        method = "sph" if transfer == "sph" else "mpm"
        chosen = {"method": method, "dx": 0.1, "dt": dt, "precision": "f64"}
        chosen |= {} if method == "sph" else {"transfer": transfer}
        sim = stage(method, velocity=[3.0, 1.0], damping={"coefficient": 5.0, "start": 0.1, "stop": 0.35},
                    solver=chosen)
        energy = sim.audit()["kinetic_energy"]
        row = run(sim, 0.4)
        left = np.exp(-5.0 * 0.25)
        np.testing.assert_allclose(mean_velocity(sim), left * np.array([3.0, 1.0]), rtol=1e-9)
        assert row["damping_work"] == pytest.approx(energy * (1.0 - left**2), rel=1e-6)
        assert abs(row["energy_remainder"]) < 1e-6 * energy
        assert row["momentum_residual"] < 1e-9
        ends.append(centre(sim))
    np.testing.assert_allclose(*ends, rtol=0.01)


@pytest.mark.parametrize("method", METHODS)
def test_speed_of_a_damped_fall(method):
    """v = g / c (1 - exp(-c t)), exact at any dt; work of gravity, damping and motion close, but for the half
    step that velocities are ahead of places (symplectic Euler)."""
    left = []
    for dt in (1e-3, 5e-4):
        sim = stage(method, gravity={"times": [0.0, 1.0], "values": [G, G]}, damping={"coefficient": 20.0},
                    solver={"method": method, "dx": 0.1, "dt": dt, "precision": "f64"})
        row = run(sim, 0.5)
        assert mean_velocity(sim)[1] == pytest.approx(-G / 20.0 * (1.0 - np.exp(-10.0)), rel=1e-9)
        left.append(abs(row["energy_remainder"]) / row["damping_work"])
    assert left[0] < 2e-3 and left[1] < 0.55 * left[0]


def test_damping_ends_at_rest():
    """Once slower than rest_speed damping is over for good: a later push goes on undamped."""
    push = {"kind": "acceleration", "value": [10.0, 0.0], "start": 0.6, "stop": 0.7}
    sim = stage(velocity=[1.0, 0.0], damping={"coefficient": 10.0, "rest_speed": 0.1}, forces=[push])
    run(sim, 0.5)
    speed = mean_velocity(sim)[0]
    assert 0.09 < speed < 0.1
    run(sim, 0.9)
    assert mean_velocity(sim)[0] == pytest.approx(speed + 1.0, rel=1e-9)
