"""Which layer of a saw test bears how much: said before anything moves, and enough of it in the library's scenes."""

import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.cli.app import app
from snowmpm.errors import SimulationError
from snowmpm.saw_test.strength import load_of_end, loads, overloaded

WEAK = {"materials.weak_layer": {"card": "gaume_weak_layer"}}
"""Bears 390 Pa of shear on 30 degrees, where the slab puts 638 Pa on it."""


def scene(slope_angle, **changes):
    return snowmpm.load_scene("pst_2d", {"saw_test.slope_angle": slope_angle, **changes})


def test_loads_are_those_of_an_infinite_slope():
    found = {load.layer: load for load in loads(scene(30.0))}
    assert list(found) == ["weak_layer"]  # the slab is elastic: nothing is too much for it
    weight = 9.81 * (250.0 * 0.5 + 100.0 * 0.05)
    assert found["weak_layer"].normal == pytest.approx(weight * np.cos(np.radians(30.0)))
    assert found["weak_layer"].shear == pytest.approx(weight * 0.5)
    mirrored = {load.layer: load for load in loads(scene(-30.0))}
    assert mirrored["weak_layer"].share == pytest.approx(found["weak_layer"].share)


def test_strength_lies_on_the_yield_surface_of_every_layer():
    """A base and a slab that yield are looked at too, each under what lies above its foot."""
    soft = {"kind": "cohesive_cam_clay", "density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3,
            "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0, "p0": 3e3}
    found = loads(scene(40.0, **{"materials.slab": soft, "saw_test.base": {"material": "slab", "thickness": 0.2}}))
    assert [load.layer for load in found] == ["base", "weak_layer", "slab"]
    assert found[0].normal > found[1].normal > found[2].normal
    law = snowmpm.load_scene("pst_2d", {"materials.slab": soft}).materials["slab"]
    sideways = law.lateral_pressure * found[2].normal
    stress = -np.diag([sideways, sideways, found[2].normal])
    stress[0, 2] = stress[2, 0] = found[2].strength
    assert abs(law.yield_function(stress, np.array(law.initial_state()))) < 1e-6 * law.p0**2


@pytest.mark.parametrize("name", ["pst", "pst_2d"])
def test_library_scenes_stand_from_0_to_45_degrees(name):
    for angle in np.linspace(-45.0, 45.0, 13):
        changed = snowmpm.load_scene(name, {"saw_test.slope_angle": float(angle)})
        assert not overloaded(changed)
        assert all(load.share < 0.9 for load in loads(changed))


@pytest.mark.parametrize(("angle", "share"), [(30.0, 1.64), (45.0, 2.04)])
def test_a_layer_that_is_too_weak_is_named_before_it_is_settled(angle, share):
    too_steep = scene(angle, **WEAK, **{"initial.stress": "geostatic", "saw_test.length": 1.5})
    with pytest.warns(UserWarning, match=r"weak_layer \(materials.weak_layer\) bears \d+ Pa of shear under") as told:
        snowmpm.Simulation(too_steep)
    assert f"{share:.2f} times as much" in str(told[0].message)
    caution = next(one for one in advise(too_steep).cautions if one.key == "saw_test.slope_angle")
    caution = next(one for one in advise(too_steep).cautions if one.key == "saw_test.slope_angle")
    assert f"{share:.2f} times as much" in caution.says
    assert "gentler" in caution.advice and "atlas" not in caution.advice


def test_a_layer_that_the_weight_alone_crushes():
    found = overloaded(scene(0.0, **{"materials.weak_layer.p0": 500.0}))
    assert [load.strength for load in found] == [0.0] and "crushes it" in str(found[0])


def test_what_theories_do_not_count_is_said():
    """Forces and damping beside a saw test; a gravity that changes is refused (`tests/scenes/test_saw_test.py`)."""
    beside = scene(0.0, damping={"coefficient": 1.0}, forces=[{"kind": "acceleration", "value": [0.1, 0.0]}])
    caution = next(one for one in advise(beside).cautions if one.key == "forces")
    assert "weight of the slab alone, not forces and damping" in caution.says
    assert not [one for one in advise(scene(0.0)).cautions if "weight of the slab alone" in one.says]


def test_check_says_so():
    shell = CliRunner()
    quiet = shell.invoke(app, ["check", "pst_2d", "--set", "saw_test.slope_angle=45"])
    assert quiet.exit_code == 0 and "bears" not in quiet.output
    loud = shell.invoke(app, ["check", "pst_2d", "--set", "saw_test.slope_angle=45", "--set",
                              "materials.weak_layer.p0=1200"])
    assert loud.exit_code == 0 and "bears" in loud.output and "times as much, before anything is cut" in loud.output
    near = shell.invoke(app, ["check", "pst_2d", "--set", "saw_test.slope_angle=50"])
    assert "to 93% of its shear strength" in near.output and "weakens before the saw comes" in near.output


def test_what_does_not_come_to_rest_is_named(monkeypatch):
    """The run's own message of a scene that does not settle says which body moves."""
    from snowmpm.stepping import settling

    monkeypatch.setattr(settling, "MOST_STEPS", 100)
    with pytest.warns(UserWarning), pytest.raises(SimulationError, match=r'"(slab|weak_layer)" moves most, .* m/s'):
        snowmpm.Simulation(scene(45.0, **WEAK, **{"saw_test.length": 1.5, "solver.dx": 0.05}))


COARSE = {"solver.dx": 0.05, "saw_test.length": 2.0}


@pytest.mark.parametrize("angle", [0.0, 30.0, 45.0, -45.0])
def test_pst_2d_is_whole_at_rest_on_slopes(angle):
    """With its ends as it ships; on 45 degrees its corner has lost 3 % of its strength, nothing else any."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        crack = snowmpm.Simulation(scene(angle, **COARSE)).crack
    assert crack.worn_at_rest[0] < 0.05 and not crack.bins["broken_at_rest"].any()
    assert abs(angle) == 45.0 or crack.worn_at_rest[0] < 1e-6


def test_an_end_normal_to_the_slope_is_worn_and_named():
    """The lower end carries twice as much on 30 degrees: said of the scene, and of the state at rest."""
    normal = scene(30.0, **COARSE, **{"saw_test.ends": "normal"})
    load = load_of_end(normal)
    assert load.normal == pytest.approx(1.9 * loads(normal)[0].normal, rel=0.1) and load.share > 1.0
    with pytest.warns(UserWarning) as told:
        crack = snowmpm.Simulation(normal).crack
    words = [str(one.message) for one in told]
    assert any("the lower end of weak_layer (materials.weak_layer) carries about" in line for line in words)
    assert any("of its strength at x = 0.0" in line for line in words)
    assert crack.worn_at_rest[0] > 0.1 and crack.worn_at_rest[1] < 0.1
    caution = next(one for one in advise(normal).cautions if one.key == "saw_test.ends")
    assert "vertical" in caution.advice
    assert load_of_end(scene(30.0)) is None and load_of_end(scene(0.0, **{"saw_test.ends": "normal"})) is None
    assert load_of_end(scene(20.0, **{"saw_test.ends": "normal"})).share < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("angle", [-45.0, -30.0, 30.0, 45.0])
def test_pst_2d_comes_to_rest_on_slopes(angle):
    """Settled as it ships; only the corner of the column's end has yielded."""
    crack = snowmpm.Simulation(scene(angle)).crack
    assert crack.worn_at_rest[0] < 0.05 and not crack.bins["broken_at_rest"].any()
