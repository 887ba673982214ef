"""A run that starts where another one ended."""

import shutil

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.setup.taken_state import KEPT

SAND = {"kind": "cohesive_cam_clay", "density": 250.0, "youngs_modulus": 2e5, "poisson_ratio": 0.3,
        "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0, "p0": 1e3}


def scene_of(folder, method="mpm", **keys):
    data = {"name": "pile", "dimension": 2, "end_time": 0.15, "output": {"interval": 0.05},
            "solver": {"dx": 0.1, "method": method}, "materials": {"snow": SAND},
            "domain": {"min": [-1.0, 0.0], "max": [2.0, 1.5], "boundary": {"z_min": "stick"}},
            "bodies": [{"name": "pile", "material": "snow",
                        "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.8, 0.6]}}], **keys}
    scene = Scene.model_validate(data)
    scene._base_dir = folder
    return scene


@pytest.fixture(scope="module", params=["mpm", "sph"])
def first(request, tmp_path_factory):
    """(folder with a run in `first`, method)."""
    folder = tmp_path_factory.mktemp("taken")
    snowmpm.run(scene_of(folder, request.param), folder / "first")
    return folder, request.param


def by_number(fields, *names):
    order = np.argsort(fields["id"])
    return [fields[name][order] for name in names]


def test_the_first_frame_is_the_last_of_the_other(first):
    folder, method = first
    end = snowmpm.Run(folder / "first")
    stone = {"name": "stone", "material": "snow", "shape": {"kind": "box", "min": [0.3, 0.9], "max": [0.5, 1.1]},
             "velocity": [0.0, -2.0]}
    pile = {"name": "pile", "material": "snow", "shape": {"kind": "box", "min": [0, 0], "max": [1, 1]}}
    scene = scene_of(folder, method, initial={"from": "first"}, bodies=[pile, stone])
    simulation = Simulation(scene)
    fields = simulation.particles
    last = end.frame(len(end) - 1)
    own = fields["body"] == 0
    assert own.sum() == len(last.points) and (~own).sum() > 0
    found = fields["position"][own][np.argsort(fields["id"][own])]
    reference = last.points[:, [0, 2]]
    shift = found.mean(axis=0) - reference.mean(axis=0)  # points of a file count from the corner of the domain
    np.testing.assert_allclose(np.sort(found, axis=0), np.sort(reference + shift, axis=0), atol=1e-5)
    np.testing.assert_allclose(shift, [-1.0, 0.0], atol=1e-5)
    assert fields["J"][own].min() < 0.999 and fields["p"][own].max() > 100.0
    assert (fields["velocity"][~own] == [0.0, -2.0]).all()
    # As if it had never stopped: the other run, taken further
    more = Simulation(scene_of(folder, method, initial={"from": "first"}))
    whole = Simulation(scene_of(folder, method))
    for time in (0.05, 0.1, 0.15):
        while whole.time < time:
            whole.step(until=time)
    for a, b in zip(by_number(whole.particles, "position", "velocity", "stress", "J", "p0"),
                    by_number(more.particles, "position", "velocity", "stress", "J", "p0"), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-6 * np.abs(a).max())
    assert more.time == 0.0


def test_resume_needs_the_other_run_no_more(first, tmp_path):
    folder, method = first
    shutil.copytree(folder / "first", tmp_path / "first")
    scene = scene_of(tmp_path, method, initial={"from": "first"}, end_time=0.1)
    longer = scene_of(tmp_path, method, initial={"from": "first"}, end_time=0.15)
    whole = snowmpm.run(longer, tmp_path / "whole")
    assert whole.provenance["initial_from"]["sha256"] and whole.provenance["initial_from"]["time"] == 0.15
    snowmpm.run(scene, tmp_path / "second")
    shutil.rmtree(tmp_path / "first")
    again = snowmpm.run(longer, tmp_path / "second", resume=True)
    np.testing.assert_array_equal(again.frame(3).points, whole.frame(3).points)
    assert (tmp_path / "second" / KEPT).exists()


@pytest.mark.parametrize(("change", "message"), [
    ({"initial": {"from": "nowhere"}}, "no such run folder"),
    ({"solver": {"dx": 0.05}}, "has solver.dx = 0.1, and this scene 0.05"),
    ({"materials": {"snow": {**SAND, "youngs_modulus": 1e5}}}, "has bulk_modulus = "),
    ({"materials": {"snow": {"kind": "elastic", "density": 250.0, "youngs_modulus": 2e5, "poisson_ratio": 0.3}}},
     "has the law cohesive_cam_clay there, and elastic"),
    ({"terrain": {"kind": "plane"}}, "has another terrain"),
    ({"bodies": [{"name": "heap", "material": "snow", "shape": {"kind": "box", "min": [0, 0], "max": [1, 1]}}]},
     "none of its bodies, pile"),
    ({"bodies": [{"name": "pile", "material": "snow", "velocity": [1, 0],
                  "shape": {"kind": "box", "min": [0, 0], "max": [1, 1]}}]}, "velocity of pile comes from there"),
    ({"domain": {"min": [-1.0, 0.0], "max": [0.5, 1.5]}}, "reaches outside the domain"),
])
def test_what_does_not_fit_is_refused(first, change, message):
    folder, method = first
    change = {key: {**value, "method": method} if key == "solver" else value for key, value in change.items()}
    with pytest.raises(InputError, match=message):
        Simulation(scene_of(folder, method, **{"initial": {"from": "first"}, **change}))


def test_strength_may_differ_and_is_told(first):
    folder, method = first
    materials = {"snow": {**SAND, "cohesion": 0.1}}
    weaker = Simulation(scene_of(folder, method, initial={"from": "first"}, materials=materials))
    assert weaker.model.taken.differences == ["materials.snow.cohesion: 0.3 there, 0.1 here"]


@pytest.mark.parametrize("keys", [{"from": "a", "stress": "geostatic"}, {"from": ""}, {"from": 1}, {"from_run": "a"}])
def test_wrong_keys(keys):
    with pytest.raises(ValueError, match="from"):
        scene_of(".", initial=keys)
