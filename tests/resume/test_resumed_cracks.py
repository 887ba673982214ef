"""Cracks in material that yields, two of them or such that make way: what a checkpoint keeps of them."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_same_runs, run_with_signal

SNOW = {"kind": "cohesive_crack", "density": 250.0, "youngs_modulus": 4e6, "poisson_ratio": 0.2, "strength": 4e3,
        "fracture_energy": 0.5, "friction_angle": 30.0}  # fmt: skip


def torn(changes):
    """Two halves of a block that are thrown apart, and up."""
    halves = [{"name": name, "material": "snow", "shape": {"kind": "box", "min": [low, 0.0], "max": [low + 0.3, 0.3]},
               "velocity": [speed, speed if low > 0.0 else 0.0]} for name, low, speed in (("one", 0.0, -0.4),
                                                                                          ("two", 0.3, 0.4))]
    return Scene.model_validate({
        "name": "torn", "dimension": 2, "end_time": 0.02, "output": {"interval": 0.005, "fields": ["damage", "cracks"]},
        "solver": {"dx": 0.05, "precision": "f64", "f_bar": "whole"},
        "domain": {"min": [-2.0, -2.0], "max": [2.0, 2.0]},
        "materials": {"snow": {**SNOW, **changes}}, "bodies": halves})


@pytest.mark.slow
@pytest.mark.parametrize("changes", [
    {"cracks": 2, "bulk": {"kind": "cohesive_cam_clay", "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0,
                           "p0": 2e4}}, {"reset": True}], ids=["two in snow", "reset"])
def test_resumed_to_the_bit(changes, tmp_path):
    scene, whole, parts = torn(changes), tmp_path / "whole", tmp_path / "parts"
    run = snowmpm.run(scene, whole)
    fields = run.frame(len(run) - 1).fields
    assert np.max(fields["cracks"]) >= 1.0 and np.max(fields["damage"]) > 0.0
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(scene, parts, signal.SIGTERM, 0.008)
    snowmpm.run(scene, parts, resume=True)
    assert_same_runs(whole, parts)
