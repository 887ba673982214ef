"""Stress at the start: it carries the weight, wherever the ground lies in the grid, and nothing rings."""

from pathlib import Path

import numpy as np
import pytest

from snowmpm import Simulation
from snowmpm.errors import InputError, SimulationError
from snowmpm.scenes import library
from snowmpm.scenes.loader import load_scene
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.stop import rests_until
from snowmpm.stepping import settling

G = 9.81
SLAB = {"kind": "elastic", "density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3}
K0 = 0.3 / 0.7
SLOPE = Path(load_scene("slab_release").base_dir) / "slope.stl"


def scene(terrain, depth, stress, *, dimension=2, dx=0.1, region=None, **more):
    """A layer of `depth` [m] on a terrain."""
    shape = {"kind": "layer", "top": depth} | ({"region": region} if region else {})
    initial = stress if isinstance(stress, dict) else {"stress": stress}
    return Scene.model_validate({
        "name": "start", "dimension": dimension, "end_time": 1.0, "solver": {"dx": dx}, "terrain": terrain,
        "materials": {"snow": SLAB}, "bodies": [{"name": "slab", "material": "snow", "shape": shape}],
        "initial": initial, **more})


def incline(angle, offset, contact, stress="geostatic"):
    """A layer of 1 m without ends, gravity tilted by `angle` [degrees], its base `offset` [m] off the nodes."""
    tilt = np.radians(angle)
    sides = {"x_min": "periodic", "x_max": "periodic"}
    return scene({"kind": "plane", "point": [0.0, offset], "contact": contact, "friction": 1.0}, 1.0, stress,
                 gravity=[G * np.sin(tilt), -G * np.cos(tilt)],
                 domain={"min": [0.0, -0.5], "max": [0.8, 2.0], "boundary": sides})


def hill(contact, stress="geostatic"):
    """A layer of 0.5 m over a shoulder, down 35 degrees and through a hollow, both with a radius of 4 m."""
    profile = {"kind": "profile", "points": [[0.0, 4.0], [3.0, 4.0], [8.0, 0.5], [12.0, 0.5]], "fillet": 4.0}
    sides = {"x_min": "symmetric", "x_max": "symmetric"}
    return scene(profile | {"contact": contact, "friction": 1.5}, 0.5, stress,
                 domain={"min": [0.0, -1.0], "max": [12.0, 7.0], "boundary": sides})


def cut_slab(stress, **more):
    """A layer of 1 m on a slope of 35 degrees that ends in the air at both ends."""
    return scene({"kind": "plane", "angle": 35.0, "contact": "stick"}, 1.0, stress, region={"x": [0.0, 4.0]},
                 domain={"min": [-2.0, -6.0], "max": [7.0, 4.0]}, **more)


def largest_speed(simulation, depth, where=None):
    """Largest speed in the first 0.2 s over sqrt(g D); where: positions -> which particles count."""
    largest = 0.0
    while simulation.time < 0.2:
        simulation.step()
        speed = simulation.max_speed
        if where is not None:
            fields = simulation.particles
            speed = np.linalg.norm(fields["velocity"][where(fields["position"])], axis=1).max()
        largest = max(largest, speed)
    return largest / np.sqrt(G * depth)


@pytest.mark.parametrize("contact", ["stick", "separate"])
@pytest.mark.parametrize("angle", [0.0, 35.0])
@pytest.mark.parametrize("offset", [0.0, 0.037, 0.08])
def test_geostatic_layer_rests_wherever_its_base_lies(angle, offset, contact):
    """0.025 % measured at the worst offset; nothing is damped."""
    assert largest_speed(Simulation(incline(angle, offset, contact)), 1.0) < 5e-4


@pytest.mark.parametrize("contact", ["stick", "separate"])
@pytest.mark.parametrize(("stress", "bound"), [("geostatic", 3e-3), ("settle", 1e-3)])
def test_layer_on_curved_ground_rests(contact, stress, bound):
    """0.13 and 0.04 % measured: the columns of `geostatic` know nothing of curvature."""
    assert largest_speed(Simulation(hill(contact, stress)), 0.5) < bound


def test_only_settling_brings_free_ends_to_rest():
    ends = largest_speed(Simulation(cut_slab("geostatic")), 1.0)
    assert 0.01 < ends < 0.05  # the stress that nothing holds there, over rho c
    assert largest_speed(Simulation(cut_slab("settle")), 1.0) < 2e-3


@pytest.mark.parametrize("contact", ["stick", "separate"])
def test_layer_rests_on_the_slope_of_the_library(contact):
    """3-D, 2 m of snow in a gully of 39 degrees with ribs, free ends all around. 0.2 % measured; the middle 0.04 %."""
    ground = {"kind": "mesh", "file": str(SLOPE), "contact": contact, "friction": 1.5}
    simulation = Simulation(scene(ground, 2.0, "settle", dimension=3, dx=1.0,
                                  region={"x": [10.0, 34.0], "y": [3.0, 23.0]}))
    assert largest_speed(simulation, 2.0) < 5e-3


def test_settled_ground_carries_the_weight():
    simulation = Simulation(hill("separate", {"stress": "settle", "tolerance": 5e-4}))
    solver = simulation.solver
    assert simulation.time == 0.0 and solver.impulse == pytest.approx(0.0)
    for _ in range(300):
        simulation.step()
    assert solver.impulse + solver.weight_impulse == pytest.approx(0.0, abs=1e-3 * np.abs(solver.weight_impulse).max())


@pytest.mark.parametrize(("given", "expected"), [({}, K0), ({"lateral_pressure": 0.8}, 0.8)])
def test_lateral_pressure_is_the_elastic_one_or_the_one_given(given, expected):
    fields = Simulation(incline(0.0, 0.0, "stick", {"stress": "geostatic"} | given)).particles
    stress, z = fields["stress"], fields["position"][:, 1]
    assert stress[:, 1] == pytest.approx(-250.0 * G * (1.0 - z), rel=2e-3)  # float32, and J = 1 at the start
    assert stress[:, 0] == pytest.approx(expected * stress[:, 1], rel=1e-4)
    assert stress[:, 2] == pytest.approx(expected * stress[:, 1], rel=1e-4)


def test_what_does_not_settle_says_how_far_it_came(monkeypatch):
    monkeypatch.setattr(settling, "MOST_STEPS", 300)
    sliding = scene({"kind": "plane", "angle": 35.0, "contact": "slip", "friction": 0.2}, 1.0, "settle",
                    region={"x": [0.0, 4.0]}, domain={"min": [-2.0, -6.0], "max": [7.0, 4.0]})
    with pytest.raises(SimulationError, match=r"start: initial.stress = \"settle\": not at rest after 300 steps: "
                                              r"speed \S+ sqrt\(g D\), imbalance \S+ of the weight") as error:
        Simulation(sliding)
    assert "initial.tolerance = 0.002" in str(error.value) and str(error.value).count("\n") == 1


@pytest.mark.parametrize(("changes", "expected"), [
    ({"initial.stress": "none", "initial.lateral_pressure": 0.5},
     'initial.lateral_pressure = 0.5: needs stress = "geostatic" or "settle"'),
    ({"initial.stress": "geostatic", "initial.lateral_pressure": -1.0},
     "initial.lateral_pressure = -1.0: must be >= 0"),
    ({"initial.tolerance": 0.0}, "initial.tolerance = 0.0: must be > 0"),
    ({"bodies.0.velocity": [0.0, 1.0]}, "bodies.0.velocity = [0.0, 1.0]: does not go with initial.stress"),
])
def test_wrong_settings_are_named(changes, expected):
    name = "slab_release_2d"
    assert name in library()
    with pytest.raises(InputError) as error:
        load_scene(name, changes)
    assert expected in str(error.value) and f"{name}.toml" in str(error.value)


PUSH = {"kind": "load", "body": "slab", "ramp": 0.02, "centre": [2.0, -0.5], "radius": 0.5, "force": [0.0, -2e3]}


def pushed(start, **more):
    """A slab at rest that is loaded from `start` [s] on, with a frame every 0.1 s."""
    return cut_slab("settle", output={"interval": 0.1}, events=[PUSH | {"start": start}], **more)


def test_a_settled_scene_begins_at_the_last_frame_before_its_first_event():
    """Until then it rests (the tests above): the same as if the event came at once, and nothing is computed for it."""
    late, soon = Simulation(pushed(0.35)), Simulation(pushed(0.05))
    assert late.time == pytest.approx(0.3) and soon.time == 0.0
    for simulation, until in ((late, 0.5), (soon, 0.2)):
        while simulation.time < until:
            simulation.step(until=until)
    assert late.solver.steps == soon.solver.steps
    x, y = (simulation.particles["position"] for simulation in (late, soon))
    start = soon.model.population.positions
    assert np.abs(y - start).max() > 100.0 * np.abs(x - y).max()  # time itself is rounded otherwise


@pytest.mark.parametrize("more", [
    {"events": []}, {"end_time": 0.35}, {"initial": {"stress": "geostatic"}},
    {"forces": [{"kind": "acceleration", "value": [0.0, 0.1]}]},
    {"gravity": {"value": G, "times": [0.0, 1.0], "values": [G, 0.9 * G]}},
    {"obstacles": [{"name": "hammer", "shape": {"kind": "sphere", "centre": [5.5, 2.5], "radius": 0.2},
                    "motion": {"velocity": [-1.0, 0.0]}}]}])
def test_what_may_move_without_an_event_is_computed_from_time_zero(more):
    spec = pushed(0.35).model_dump(by_alias=True, exclude_unset=True)
    assert rests_until(Scene.model_validate(spec)) == pytest.approx(0.3)
    assert rests_until(Scene.model_validate(spec | more)) == 0.0
