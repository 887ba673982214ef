"""Laws of ground friction under MPM: a stiff block on a plane, against closed forms and the laws themselves."""

import numpy as np
import pytest
from scipy.optimize import brentq

import snowmpm
from snowmpm.errors import InputError
from snowmpm.ground import LAWS
from snowmpm.ground.states import stresses
from snowmpm.scenes import Scene
from snowmpm.stepping import basal_friction
from snowmpm.stepping.basal_friction import BasalFriction

G, DENSITY, THICK = 9.81, 250.0, 1.0
VOELLMY = {"law": "voellmy", "mu": 0.25, "xi": 200.0}
STICKY = {"law": "coulomb", "mu": 0.2, "tau0": 300.0}


def scene(friction, angle, speed, length=12.0, dimension=2, dx=0.25, **changes):
    """A block as long as `length`, 1 m thick, that slides down a plane of `angle` degrees."""
    a, reach = np.radians(angle), 80.0

    def point(x, z, y=0.0):
        return [x, z] if dimension == 2 else [x, y, z]

    across = {} if dimension == 2 else {"y": [0.0, 3.0]}
    sides = {} if dimension == 2 else {"boundary": {"y_min": "slip", "y_max": "slip"}}
    return Scene.model_validate({
        "name": "block", "dimension": dimension, "end_time": 8.0,
        "solver": {"method": "mpm", "dx": dx, "precision": "f64", "transfer": "apic"},
        "domain": {"min": point(0.0, -reach * np.tan(a) - 5.0), "max": point(reach, 10.0, 3.0), **sides},
        "terrain": {"kind": "plane", "angle": angle, "friction": friction}, "initial": {"stress": "geostatic"},
        "materials": {"stiff": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.2}},
        "bodies": [{"name": "block", "material": "stiff", "velocity": point(speed * np.cos(a), -speed * np.sin(a)),
                    "shape": {"kind": "layer", "bottom": 0.0, "top": THICK,
                              "region": {"x": [3.0, 3.0 + length], **across}}}], **changes})


def terminal(spec, angle):
    """Speed [m/s] at which the law's shear stress is the pull of the weight."""
    snowmpm.start()
    law, a = LAWS[spec["law"]](**spec), np.radians(angle)

    def excess(v):
        state = [DENSITY, DENSITY * G * THICK * np.cos(a), v, THICK]
        dry, rate = stresses(type(law), [law.parameters(G)], [state])[0]
        return dry + rate * v - DENSITY * G * THICK * np.sin(a)

    return brentq(excess, 1e-3, 200.0)


def speed(simulation):
    """Mean speed [m/s]."""
    return float(np.linalg.norm(simulation.particles["velocity"].mean(axis=0)))


def run_to(simulation, time):
    while simulation.time < time - 1e-9:
        simulation.step(time)


def test_the_terminal_speed_of_voellmy_is_the_closed_one():
    assert terminal(VOELLMY, 30.0) == pytest.approx(
        np.sqrt(200.0 * THICK * (np.sin(np.radians(30.0)) - 0.25 * np.cos(np.radians(30.0)))), rel=1e-9)


@pytest.mark.parametrize("spec", [
    VOELLMY,
    pytest.param({"law": "samos_at", "mu": 0.155, "R": 0.3}, marks=pytest.mark.slow),
    pytest.param({"law": "frictional_viscous", "mu": 0.3, "exponent": 2.0, "viscosity": 2.0}, marks=pytest.mark.slow),
    pytest.param({"law": "mu_i", "mu_s": 0.38, "mu_2": 0.8, "I_0": 0.3, "grain_diameter": 0.05,
                  "grain_density": 900.0}, marks=pytest.mark.slow),
    pytest.param({"law": "bingham", "yield_stress": 300.0, "viscosity": 60.0}, marks=pytest.mark.slow)],
    ids=lambda spec: spec["law"])
def test_a_stiff_block_slides_at_the_terminal_speed(spec):
    """Within 1 %, from the speed itself on."""
    expected = terminal(spec, 30.0)
    simulation = snowmpm.Simulation(scene(spec, 30.0, expected))
    run_to(simulation, 5.0)
    assert speed(simulation) == pytest.approx(expected, rel=0.01)


def test_the_way_to_the_terminal_speed():
    """v_inf tanh(t / T + atanh(v_0 / v_inf)) of a Voellmy block, from 60 % of it."""
    limit, a = terminal(VOELLMY, 30.0), np.radians(30.0)
    scale = limit / (G * (np.sin(a) - 0.25 * np.cos(a)))
    simulation = snowmpm.Simulation(scene(VOELLMY, 30.0, 0.6 * limit))
    run_to(simulation, 3.0)
    assert speed(simulation) == pytest.approx(limit * np.tanh(3.0 / scale + np.arctanh(0.6)), rel=0.02)


@pytest.mark.parametrize("spec", [VOELLMY, STICKY], ids=lambda spec: spec["law"])
def test_friction_stops_a_block_without_turning_it_back(spec):
    """On level ground: v = v_0 - a t for the dry part, and for Voellmy tan; then it lies still."""
    v0 = 3.0
    dry = spec["mu"] * G + spec.get("tau0", 0.0) / (DENSITY * THICK)
    simulation = snowmpm.Simulation(scene(spec, 0.0, v0, length=6.0))
    k = G / spec["xi"] / THICK if "xi" in spec else 1e-9
    stop = np.arctan(v0 * np.sqrt(k / dry)) / np.sqrt(k * dry)
    times, seen = 0.1 * np.arange(1, int(10.0 * stop) + 12), []
    for time in times:
        run_to(simulation, time)
        seen.append(float(simulation.particles["velocity"][:, 0].mean()))
    seen = np.array(seen)
    before = times < 0.8 * stop
    expected = np.sqrt(dry / k) * np.tan(np.arctan(v0 * np.sqrt(k / dry)) - np.sqrt(k * dry) * times)
    np.testing.assert_allclose(seen[before], expected[before], atol=0.05 * v0)
    assert np.abs(seen[times > stop + 0.5]).max() < 0.02 * v0
    assert seen.min() > -0.02 * v0


@pytest.mark.slow
def test_in_three_dimensions():
    """The same block between walls."""
    expected = terminal(VOELLMY, 30.0)
    simulation = snowmpm.Simulation(scene(VOELLMY, 30.0, expected, length=8.0, dimension=3, dx=0.5))
    run_to(simulation, 1.5)
    assert speed(simulation) == pytest.approx(expected, rel=0.04)
    assert simulation.audit()["momentum_residual"] < 1e-9


def test_a_coefficient_and_coulomb_as_a_law_are_the_same_to_the_bit():
    runs = [snowmpm.Simulation(scene(friction, 30.0, 2.0, length=4.0))
            for friction in (0.3, {"law": "coulomb", "mu": 0.3})]
    for simulation in runs:
        for _ in range(20):
            simulation.step()
    np.testing.assert_array_equal(*(simulation.particles["velocity"] for simulation in runs))


@pytest.mark.parametrize("spec", [VOELLMY, STICKY], ids=lambda spec: spec["law"])
def test_a_continued_simulation_is_the_same_to_the_bit(spec):
    whole, second = (snowmpm.Simulation(scene(spec, 30.0, 5.0, length=4.0)) for _ in range(2))
    for _ in range(31):
        whole.step()
    state = whole.state()
    second.restore(state)
    for simulation in (whole, second):
        for _ in range(30):
            simulation.step()
    np.testing.assert_array_equal(*(simulation.particles["velocity"] for simulation in (whole, second)))


@pytest.mark.parametrize(("spec", "share"), [(VOELLMY, 1.0), (STICKY, 0.5)], ids=["voellmy", "coulomb"])
def test_depths_are_taken_anew_where_the_snow_has_moved(monkeypatch, spec, share):
    """In every step for a law of the speed, else a quarter of a cell later at most; the ways are the same to 1e-3."""
    taken, ends = [], []
    compute = BasalFriction._compute
    monkeypatch.setattr(BasalFriction, "_compute", lambda *given: (taken.append(given), compute(*given)))
    for stale in (0.25, 0.0):
        monkeypatch.setattr(basal_friction, "STALE", stale)
        taken.clear()
        simulation = snowmpm.Simulation(scene(spec, 30.0, 2.0, length=4.0))
        run_to(simulation, 0.5)
        assert len(taken) == simulation.solver.steps or (stale and len(taken) < share * simulation.solver.steps)
        ends.append(simulation.particles["position"][:, 0].mean())
    assert ends[0] == pytest.approx(ends[1], abs=1e-3 * (ends[1] - 5.0))


def test_sph_refuses_them():
    with pytest.raises(InputError, match=r"terrain\.friction\.law") as refused:
        snowmpm.Simulation(scene(VOELLMY, 30.0, 0.0, solver={"method": "sph", "dx": 0.25}))
    assert len(str(refused.value).splitlines()) <= 2


def test_what_a_wall_that_slips_holds_back_has_no_friction():
    """Gravity pulls a block off the ground that holds it, so that friction of 0.5 must not slow it."""
    given = scene(0.5, 0.0, 5.0, length=4.0, end_time=0.3, gravity=[0.0, 9.81])
    given = given.model_copy(update={"terrain": given.terrain.model_copy(update={"contact": "slip"})})
    simulation = snowmpm.Simulation(given)
    run_to(simulation, 0.3)
    assert simulation.particles["position"][:, 1].max() < 1.1
    assert speed(simulation) == pytest.approx(5.0, abs=0.05)
