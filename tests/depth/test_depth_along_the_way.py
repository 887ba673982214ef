"""Depth-averaged runs along a line: profiles to compare with, and the thalweg-time diagram."""

import numpy as np
import pytest

import snowmpm
from snowmpm.comparison import profile
from snowmpm.comparison.case import open_cases
from snowmpm.errors import InputError
from snowmpm.io.thalweg_time import ThalwegTime
from snowmpm.render import render_thalweg_time
from snowmpm.scenes import Scene

ANGLE, SPEED, DEPTH = 30.0, 20.0, 1.0


def scene(method="depth", dx=2.0, friction=None, speed=SPEED, **changes):
    """A layer that slides down a plane at one speed, since friction has the angle of the slope."""
    angle = np.radians(ANGLE)
    return Scene.model_validate({
        "name": "sliding", "dimension": 3, "end_time": 3.0, "output": {"interval": 0.5},
        "solver": {"method": method, "dx": dx},
        "domain": {"min": [0.0, 0.0, -90.0], "max": [150.0, 24.0, 10.0],
                   "boundary": {"y_min": "slip", "y_max": "slip"}},
        "terrain": {"kind": "plane", "angle": ANGLE,
                    "friction": float(np.tan(angle)) if friction is None else friction},
        "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "layer", "material": "snow", "shape": {
            "kind": "layer", "top": DEPTH, "region": {"x": [10.0, 50.0], "y": [0.0, 24.0]}},
            "velocity": [speed * np.cos(angle), 0.0, -speed * np.sin(angle)]}], **changes})


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return snowmpm.run(scene(), tmp_path_factory.mktemp("sliding") / "run")


def test_thalweg_time_of_a_sliding_layer(run):
    """Its front goes down the thalweg at its speed in plan, and the spread of its foot; depth and speed are its own,
    and nothing is where no snow is."""
    found = ThalwegTime.of(run)
    plan = SPEED * np.cos(np.radians(ANGLE))
    assert found.depth.shape == (len(run), len(found.s)) == found.speed.shape
    assert found.front[0] == pytest.approx(40.0, abs=2.5)
    gained = found.front[-1] - found.front[0]
    assert plan * 3.0 - 2.0 < gained < (plan + 2.0 * np.sqrt(9.81 * DEPTH)) * 3.0
    middle = np.argmin(np.abs(found.s - 20.0 - plan * 1.5))
    row = np.argmin(np.abs(found.time - 1.5))
    assert found.depth[row, middle] == pytest.approx(DEPTH, rel=0.02)
    assert found.speed[row, middle] == pytest.approx(SPEED, rel=0.02)
    assert np.isnan(found.depth[0, found.s > 45.0]).all() and np.isnan(found.speed[0, found.s > 45.0]).all()


@pytest.mark.slow
def test_thalweg_time_of_particles(tmp_path):
    """MPM: depth from the volume over map cells."""
    domain = {"min": [0.0, 0.0, -40.0], "max": [60.0, 6.0, 10.0], "boundary": {"y_min": "slip", "y_max": "slip"}}
    layer = {"name": "layer", "material": "snow", "velocity": [10.0, 0.0, -5.77], "shape": {
        "kind": "layer", "top": DEPTH, "region": {"x": [5.0, 15.0], "y": [0.0, 6.0]}}}
    made = snowmpm.run(scene("mpm", dx=0.5, end_time=1.0, domain=domain, bodies=[layer]), tmp_path / "run")
    found = ThalwegTime.of(made)
    inner = (found.s > 3.0) & (found.s < 7.0)
    # Vertical depth of a layer 1 m thick normal to the slope
    assert np.nanmedian(found.depth[0, inner]) == pytest.approx(DEPTH / np.cos(np.radians(ANGLE)), rel=0.15)
    assert np.nanmedian(found.speed[0, inner]) == pytest.approx(11.5, rel=0.05)
    assert found.front[-1] > found.front[0] + 5.0


def test_it_is_drawn(run, tmp_path):
    path = render_thalweg_time(run, tmp_path / "thalweg_time.png")
    assert path.stat().st_size > 20000


def test_a_run_without_a_thalweg_is_refused(tmp_path):
    still = snowmpm.run(scene(friction=2.0, speed=0.0, end_time=0.5), tmp_path / "still")
    with pytest.raises(InputError, match="no thalweg"):
        render_thalweg_time(still, tmp_path / "none.png")
    with pytest.raises(InputError):
        render_thalweg_time(still, tmp_path / "none.xyz")


def test_profile_of_columns_is_ground_and_depth(run):
    """Not the heights of columns, which lie at half of their snow: bottom on the plane, top the vertical depth above
    it, ends at the ends of the layer."""
    case = open_cases([run.path])[0]
    found = profile(case, run.frame(0))
    angle = np.radians(ANGLE)
    inner = slice(3, -3)
    np.testing.assert_allclose(found.bottom[inner], -np.tan(angle) * found.s[inner], atol=0.05)
    np.testing.assert_allclose((found.top - found.bottom)[inner], DEPTH / np.cos(angle), rtol=0.02)
    assert found.start == pytest.approx(10.0, abs=1.1) and found.end == pytest.approx(50.0, abs=1.1)
    assert found.back == pytest.approx(10.0, abs=2.5) and found.front == pytest.approx(50.0, abs=2.5)
