"""No run ends well with snow faster than a fall over all of the ground."""

import math

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import SimulationError
from snowmpm.running.fall import EXCESS, THROWN, fall_speed
from snowmpm.scenes import Scene
from snowmpm.setup.build import build
from snowmpm.stepping.abilities import course

SCENE = {
    "name": "pit", "dimension": 3, "end_time": 40.0, "output": {"interval": 10.0},
    "solver": {"method": "depth", "dx": 10.0}, "terrain": {"kind": "dem", "file": "dem.asc", "friction": 0.3},
    "materials": {"snow": {"kind": "elastic", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
    "bodies": [{"name": "release", "material": "snow", "shape": {
        "kind": "layer", "bottom": 0.0, "top": 1.0, "region": {"x": [60.0, 120.0], "y": [60.0, 240.0]}}}],
}


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """Function (depth of a pit across a slope of 35 degrees [m], changes) -> scene."""
    monkeypatch.chdir(tmp_path)

    def made(pit, **changes):
        z = np.tile(1000.0 - np.tan(np.radians(35.0)) * 10.0 * np.arange(60), (30, 1))
        z[:, 25:30] -= pit
        (tmp_path / "dem.asc").write_text("ncols 60\nnrows 30\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
                                          + "\n".join(" ".join(f"{v:.2f}" for v in row) for row in z))
        return Scene.model_validate(SCENE | changes)

    return made


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_run_over_a_pit_that_is_none_fails_and_says_so(scene):
    with pytest.raises(SimulationError, match=r"snow moves at .* m/s at t = .* s, and a fall over all of the ground"):
        snowmpm.run(scene(600.0), "run")
    last = snowmpm.Run("run")
    assert not last.complete and last.times[0] == 0.0


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_even_ground_is_far_from_it(scene):
    run, bound = snowmpm.run(scene(0.0), "run"), fall_speed(build(scene(0.0)))
    fall = np.tan(np.radians(35.0)) * (590.0 - 60.0)
    assert bound == pytest.approx(EXCESS * math.sqrt(2.0 * 9.81 * (fall + 2.0)), rel=0.02)
    assert 20.0 < run.history["max_speed"].max() < bound


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("gravity", [{"value": 9.81, "ramp": 1.0}, [1.0, 0.0, -9.81]])
def test_what_is_driven_has_no_bound(scene, gravity):
    assert fall_speed(build(scene(0.0, solver={"method": "mpm", "dx": 1.0}, gravity=gravity))) == math.inf


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_snow_below_all_ground_has_no_fall_and_no_fault(scene):
    box = {"kind": "box", "min": [60.0, 60.0, 10.0], "max": [80.0, 80.0, 30.0]}
    made = scene(0.0, solver={"method": "mpm", "dx": 5.0},
                 bodies=[{"name": "low", "material": "snow", "shape": box}])
    assert math.isfinite(fall_speed(build(made)))


def test_snow_that_other_snow_throws_is_no_fault():
    """The fastest of flow_cold_dense has 61.4 m/s, of a fall of 36.7."""
    assert fall_speed(build(snowmpm.load_scene("flow_cold_dense"))) == pytest.approx(THROWN * 36.7, rel=0.01)
    assert fall_speed(build(snowmpm.load_scene("flow_cold_dense"))) > 1.5 * 61.4


@pytest.mark.parametrize("card", ["samos_at_medium", "samos_at_large"])
def test_no_block_that_foretells_a_run_is_faster_than_its_fall(scene, card):
    """Steps over several bends of rough ground would give it energy."""
    made = scene(0.0, terrain=SCENE["terrain"] | {"friction": {"card": card}})
    x = np.tile(10.0 * np.arange(60), (30, 1))
    rough = 1000.0 - np.tan(np.radians(35.0)) * np.minimum(x, 300.0) + 8.0 * np.sin(x / 15.0)
    with open("dem.asc", "w") as file:
        file.write("ncols 60\nnrows 30\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
                   + "\n".join(" ".join(f"{v:.2f}" for v in row) for row in rough))
    model = build(made)
    blocks = course(model.solver(), 100.0, 10.0)
    assert 10.0 < blocks.speed < fall_speed(model)  # 61.7 m/s; 153 and 8770 before
