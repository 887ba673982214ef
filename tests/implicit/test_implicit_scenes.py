"""Implicit MPM chosen in a scene: by either spelling, run, resumed, and refused where it cannot."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

SNOW = {"kind": "cohesive_cam_clay", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0, "p0": 2e4}


def tables(solver, **changes):
    return {"name": "block", "dimension": 2, "end_time": 0.2, "gravity": 9.81, "output": {"interval": 0.1},
            "solver": {"dx": 0.1, **solver}, "materials": {"snow": SNOW},
            "domain": {"min": [0.0, 0.0], "max": [1.0, 1.0], "boundary": {
                "x_min": "slip", "x_max": "open", "z_min": "stick", "z_max": "open"}},
            "bodies": [{"name": "one", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0],
                                                                     "max": [0.4, 0.4]}}], **changes}


def scene(solver, **changes):
    return Scene.model_validate(tables(solver, **changes))


REST = {"implicit": {"time": "quasi_static"}}


def test_either_spelling_is_the_same_scene_and_comes_back_from_its_file(tmp_path):
    one, other = scene(REST), scene({"method": "implicit", **REST})
    assert one.solver == other.solver and one.solver.precision == "f64"
    file = tmp_path / "scene.toml"
    file.write_text(one.to_toml(), encoding="utf-8")
    assert snowmpm.load_scene(file).solver == one.solver
    plain = scene({})
    file.write_text(plain.to_toml(), encoding="utf-8")
    assert snowmpm.load_scene(file).solver.method == "mpm"


def test_a_run_at_rest_takes_a_step_a_frame_and_resumes_to_the_bit(tmp_path):
    whole = snowmpm.run(scene(REST), tmp_path / "whole")
    assert whole.times.tolist() == [0.0, 0.1, 0.2]
    assert int(whole.history["particles"][-1]) == 64 and whole.history["momentum_residual"].max() < 1e-8
    snowmpm.run(scene(REST, end_time=0.1), tmp_path / "part")
    resumed = snowmpm.run(scene(REST), tmp_path / "part", resume=True)
    assert np.array_equal(whole.frame(2).points, resumed.frame(2).points)
    assert np.array_equal(whole.frame(2).fields["density"], resumed.frame(2).fields["density"])
    lowered = [whole.frame(i).points[:, 2].mean() for i in range(3)]  # the third axis is up in a run file
    assert lowered[1] < lowered[0] - 1e-5 and lowered[2] == pytest.approx(lowered[1], abs=1e-6)


@pytest.mark.parametrize(("solver", "changes", "named"), [
    ({**REST, "precision": "f32"}, {}, "solver.precision"),
    (REST, {"obstacles": [{"name": "wall", "shape": {"kind": "box", "min": [0.6, 0.0], "max": [0.7, 0.4]},
                           "motion": {"velocity": [-1.0, 0.0]}}]}, "obstacles.0.motion"),
    (REST, {"terrain": {"kind": "plane", "friction": {"law": "voellmy", "mu": 0.2, "xi": 1000.0},
                        "contact": "separate"}}, "terrain.friction.law"),
    ({"implicit": {"time": "newmark"}}, {"water": {"permeability": 1e-9, "split": "monolithic"}, "domain": {
        "min": [0.0, 0.0], "max": [1.0, 1.0], "boundary": {"z_min": "separate"}}}, "domain.boundary.z_min"),
    (REST, {"initial": {"stress": "settle"}}, "initial.stress"),
    (REST, {"damping": {"coefficient": 1.0}}, "damping.coefficient")])
def test_what_it_cannot_is_refused(solver, changes, named):
    with pytest.raises(InputError) as refusal:
        Simulation(scene(solver, **changes))
    assert named in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2


def test_options_are_checked():
    for wrong in ({"time": "backwards"}, {"tolerance": 1.0}, {"iterations": 0}, {"unknown": 1}):
        with pytest.raises(ValueError, match="implicit"):
            scene({"implicit": wrong})
