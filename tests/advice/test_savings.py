"""`snowmpm check` says what a scene pays for and what it could do without, by costs that were measured."""

import csv
from pathlib import Path

import numpy as np
import pytest

from snowmpm import load_scene
from snowmpm.advice.report import advise
from snowmpm.measured import costs
from snowmpm.scenes.schema import Scene

SNOW = {"kind": "cohesive_cam_clay", "density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3,
        "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0, "p0": 2e4}
FIGURES = Path(__file__).parents[1] / "benchmarks" / "figures"


def slab(dimension=3, solver=None, output=None, snow=None, sides=None, body=None, **tables):
    """A slab across a channel with smooth walls, on a plane that dips along x: plane strain."""
    across = [[-0.4, 0.4]] if dimension == 3 else []
    lower, upper = ([0.0, *(a[k] for a in across), z] for k, z in ((0, -3.0), (1, 3.0)))
    upper[0] = 6.0
    walls = {"y_min": "slip", "y_max": "slip"} if dimension == 3 else {}
    shape = {"kind": "layer", "bottom": 0.0, "top": 0.8, "region": {"x": [1.0, 4.0]}}
    return Scene.model_validate({
        "name": "slab", "dimension": dimension, "end_time": 1.0, "solver": {"dx": 0.1, **(solver or {})},
        "output": {"interval": 0.5, **(output or {})}, "terrain": {"kind": "plane", "angle": 20.0},
        "domain": {"min": lower, "max": upper, "boundary": {**walls, **(sides or {})}},
        "materials": {"snow": {**SNOW, **(snow or {})}},
        "bodies": [{"name": "slab", "material": "snow", "shape": shape, **(body or {})}], **tables})


def savings(scene):
    return {saving.key: saving for saving in advise(scene).savings}


def test_a_scene_in_plane_strain_is_seen():
    found = savings(slab(solver={"dx": 0.05, "cfl": 0.4}))["dimension"]
    assert found.share > 0.8  # 32 particles across become one, and each is cheaper; calls of kernels stay
    assert "dimension" not in savings(slab(dimension=2))


@pytest.mark.parametrize("changes", [
    dict(sides={"y_min": "open"}), dict(body={"velocity": [0.0, 0.1, 0.0]}),
    dict(body={"shape": {"kind": "layer", "top": 0.8, "region": {"x": [1.0, 4.0], "y": [-0.3, 0.0]}}}),
    dict(gravity=[0.0, 1.0, -9.81]),
    dict(obstacles=[{"name": "post", "shape": {"kind": "box", "min": [5.0, -0.1, -3.0], "max": [5.3, 0.1, 3.0]}}])])
def test_what_changes_across_needs_three_dimensions(changes):
    assert "dimension" not in savings(slab(**changes))


def test_an_obstacle_through_the_whole_width_does_not():
    wall = {"name": "wall", "shape": {"kind": "box", "min": [5.0, -0.5, -3.0], "max": [5.3, 0.5, 3.0]}}
    assert "dimension" in savings(slab(obstacles=[wall]))


@pytest.mark.parametrize(("key", "needless", "needed"), [
    ("solver.precision", dict(solver={"precision": "f64"}), {}),
    ("solver.particles_per_cell", dict(solver={"particles_per_cell": 16}), {}),
    ("solver.cfl", dict(solver={"cfl": 0.1}), dict(solver={"cfl": 0.7})),
    ("solver.dt", dict(solver={"dt": 2e-5}), {}),
    ("output.interval", dict(output={"interval": 1e-3}), {}),
    ("materials.snow.return_map", dict(snow={"return_map": "substepped"}, output={"interval": 5.0}), {}),
])
def test_what_is_not_needed_is_named(key, needless, needed):
    found = savings(slab(2, end_time=10.0, **needless))[key]
    assert found.seconds > 0.0 and found.says and 0.0 < found.share < 1.0
    assert key not in savings(slab(2, end_time=10.0, **needed))


def test_flows_in_space_do_with_four_particles_a_cell():
    found = savings(slab(3, end_time=10.0))["solver.particles_per_cell"]
    assert found.overrides == {"solver.particles_per_cell": 4} and found.share > 0.15
    for needed in (dict(solver={"particles_per_cell": 4}), dict(gravity=0.0), dict(end_time=0.1)):
        assert "solver.particles_per_cell" not in savings(slab(3, **{"end_time": 10.0, **needed}))


def test_no_crack_is_measured_with_fewer_particles():
    assert "solver.particles_per_cell" not in savings(load_scene("pst"))


def test_a_cubic_kernel_costs_half_as_much_again_in_3d():
    assert 0.1 < savings(slab(solver={"kernel": "cubic"}))["solver.kernel"].share < 0.5
    assert "solver.kernel" not in savings(slab())


def test_following_an_output_interval_saves_what_is_said():
    advice = advise(slab(2, output={"interval": 1e-3}))
    said = next(saving for saving in advice.savings if saving.key == "output.interval")
    longer = float(said.says.split()[0])
    after = advise(slab(2, output={"interval": longer}))
    assert advice.facts["run_time"] - after.facts["run_time"] == pytest.approx(said.seconds, rel=0.05)
    assert not any(saving.key == "output.interval" for saving in after.savings)


def test_payments_add_up():
    advice = advise(slab(2))
    shares = [payment.share for payment in advice.payments if payment.share is not None]
    assert sum(shares) == pytest.approx(1.0, abs=1e-9) and min(shares) >= 0.0
    assert sum(payment.seconds or 0.0 for payment in advice.payments) == pytest.approx(advice.facts["run_time"])


def test_costs_are_those_of_the_benchmarks():
    """A step of the benchmark's own case without its grid, from the table that is shipped."""
    with open(FIGURES / "mpm_step.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["case"] in ("half2", "half3") and row["threads"] == "1"
                and row["particles"] in ("250047", "250000") and row["transfer"] == "apic"]
    seen = 0
    for row in rows:
        scheme = costs.Scheme(int(row["case"][-1]), row["precision"], row["basis"], row["gradient"])
        # The last row of a case is the one kept; cubic shape is the sum of what both add
        assert costs.transfers(scheme) == pytest.approx(float(row["ns"]) - float(row["update_grid"]), rel=0.1)
        seen += 1
    assert seen >= 8 and np.isfinite(list(costs.table().values())).all()
