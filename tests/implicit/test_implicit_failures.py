"""Steps that cannot be solved: cut in parts, then said with place and time; the last good checkpoint stays."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import SimulationError
from snowmpm.scenes.schema import Scene

SOIL = {"kind": "von_mises", "density": 1000.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "yield_stress": 2e3}


def scene(end_time, floor="stick", push="-100*t"):
    """A block of soil on a floor, pushed along it more and more [m/s2]."""
    return Scene.model_validate({
        "name": "pushed", "dimension": 2, "end_time": end_time, "gravity": 0.0,
        "output": {"interval": 0.1, "checkpoint_interval": 0.1},
        "solver": {"dx": 0.1, "implicit": {"time": "quasi_static", "iterations": 3}},
        "materials": {"soil": SOIL},
        "forces": [{"kind": "acceleration", "value": [push, "0"]}],
        "domain": {"min": [-1.0, 0.0], "max": [1.0, 1.0], "boundary": {"z_min": floor}},
        "bodies": [{"name": "block", "material": "soil", "shape": {"kind": "box", "min": [-0.2, 0.0],
                                                                   "max": [0.2, 0.4]}}]})


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """Folder of a run that fails, and what it said."""
    folder = tmp_path_factory.mktemp("broken")
    with pytest.raises(SimulationError) as failed:
        snowmpm.run(scene(1.0, push="-10*t"), folder)
    return folder, str(failed.value)


def test_a_load_that_cannot_be_borne_is_said(broken):
    """It yields at its foot from about 3 m/s2 on, in pure shear from sigma_y / sqrt(3) = rho h a."""
    first, second = broken[1].splitlines()
    assert "was not solved, with 1/1024 of the loads either" in first and "worst near [" in first
    assert "lower solver.implicit.dt" in second and "last checkpoint" in second
    at = float(first.split("t = ")[1].split(" s")[0])
    assert 0.5 * SOIL["yield_stress"] / np.sqrt(3.0) / (1000.0 * 0.4) < 10.0 * at < 10.0
    run = snowmpm.Run(broken[0])
    assert run.times[-1] == pytest.approx(at) and np.isfinite(run.frame(len(run) - 1).points).all()


@pytest.mark.slow
def test_what_was_reached_stays(broken, tmp_path):
    """The run up to there is that which ends there, and goes on from its checkpoint, to fail where it did."""
    run = snowmpm.Run(broken[0])
    whole = snowmpm.run(scene(float(run.times[-1]), push="-10*t"), tmp_path)
    assert whole.frame(len(whole) - 1).points.tobytes() == run.frame(len(run) - 1).points.tobytes()
    with pytest.raises(SimulationError) as again:
        snowmpm.run(scene(1.0, push="-10*t"), broken[0], resume=True)
    assert str(again.value).splitlines()[0] == broken[1].splitlines()[0]


def test_a_mechanism(tmp_path):
    """A block that slides on a smooth floor has no balance under a push along it."""
    with pytest.raises(SimulationError) as failed:
        snowmpm.run(scene(0.1, floor="slip", push="-1"), tmp_path)
    assert "was not solved" in str(failed.value) and "nothing holds" in str(failed.value)
    assert len(str(failed.value).splitlines()) == 2 and "last checkpoint" in str(failed.value)
