"""--fast and --accurate: what they change in a scene, and that the package's measurements keep what they promise."""

import numpy as np
import pytest

from snowmpm.advice.along_front import LEAST_CELLS, coarsest, faster, more_accurate, thinnest
from snowmpm.advice.report import advise
from snowmpm.advice.weak_layers import tuned_to_grid
from snowmpm.errors import InputError
from snowmpm.scenes import library, load_scene
from snowmpm.scenes.loader import with_overrides
from snowmpm.setup.build import build
from snowmpm.study import presets
from snowmpm.study.measurement import read

LARGE = {"crown_and_flanks", "mast", "pst", "slab_release_resolved"}
"""Scenes that take longest to fill with particles."""


@pytest.fixture(scope="module")
def table():
    return presets.gains(read(presets.DATA))


def test_the_table_holds_every_move(table):
    assert [gain.move for gain in table] == list(presets.MOVES)
    assert all(len(gain.error) == len(presets.PROBLEMS) for gain in table)


def median_work(table):
    """work(move): typical particle-steps over those of the program's own choice."""
    return lambda move: float(np.median(next(gain for gain in table if gain.move == move).work))


def test_the_speed_that_is_promised_was_measured(table):
    """Of a scene of the program's own choice in which nothing limits the grid."""
    work = median_work(table)
    assert work(presets.fastest(table, work).move) <= 1.0 / presets.FASTER


@pytest.mark.xfail(strict=True, reason="0.56: half the grid spacing, against steps that leave less error than before")
def test_the_accuracy_that_is_promised_was_measured(table):
    assert presets.most_accurate(table, median_work(table)).typical <= presets.LESS_ERROR


@pytest.mark.parametrize("name", ["column_collapse_2d", "flow_warm_plug", "impact_wall_2d"])
def test_a_change_is_a_valid_scene_and_says_what_it_does(name):
    scene = load_scene(name)
    for change, words in ((faster(scene), "times faster"), (more_accurate(scene), "times the time")):
        moved = load_scene(name, change.overrides)
        assert moved.model_dump() != scene.model_dump()
        for key, value in change.overrides.items():
            assert key in change.lines[0] and f"{value:g}" in change.lines[0] if isinstance(value, float) else True
        assert words in change.lines[1] and "times the error" in change.lines[1]


def test_fast_is_coarser_and_accurate_is_finer():
    scene = load_scene("flow_warm_plug")
    fast, accurate = faster(scene).overrides, more_accurate(scene).overrides
    assert fast["solver.dx"] > scene.solver.dx
    assert accurate.get("solver.dx", scene.solver.dx) <= scene.solver.dx


WITHOUT_WEAK_LAYER = {"bodies.1.material": "slab", "events": []}


def cells_of_the_thinnest(scene):
    return thinnest(scene) / scene.solver.dx


def test_the_grid_does_not_outgrow_the_thinnest_layer():
    for dx in (0.05, 0.1):
        scene = load_scene("slab_release_2d", {"solver.dx": dx, **WITHOUT_WEAK_LAYER})
        change = faster(scene)
        moved = load_scene("slab_release_2d", {"solver.dx": dx, **WITHOUT_WEAK_LAYER, **change.overrides})
        assert cells_of_the_thinnest(moved) >= LEAST_CELLS * (1.0 - 1e-3)
        assert (cells_of_the_thinnest(moved) < 1.0) == any("of a cell" in line for line in change.lines)


def test_a_layer_that_allows_nothing_is_named():
    thin = thinnest(load_scene("slab_release_2d"))
    scene = load_scene("slab_release_2d", {"solver.dx": thin / LEAST_CELLS, **WITHOUT_WEAK_LAYER})
    assert coarsest(scene) == pytest.approx(1.0)
    change = faster(scene)
    assert "solver.dx" not in change.overrides and "thinnest part" in change.lines[-1]


@pytest.mark.parametrize("name", ["slab_release_2d", pytest.param("slab_release_resolved", marks=pytest.mark.slow)])
def test_a_scene_tuned_to_its_grid_stays_on_it(name):
    """On twice the spacing slab_release_2d stands still: nothing is sold as faster, or more accurate, that is another
    scene."""
    scene = load_scene(name)
    for change in (faster(scene), more_accurate(scene)):
        assert change.overrides == {} and change.ratio == 1.0
        assert "changes nothing" in change.lines[0] and "reference_thickness" in change.lines[1]


def test_a_weak_layer_keeps_the_cells_that_it_needs():
    """With its own reference thickness a layer of four cells may become one of two, and none of less."""
    one = {"materials.weak_layer.reference_thickness": 0.1}
    assert coarsest(load_scene("slab_release_2d", one)) == pytest.approx(2.0, rel=1e-4)
    assert coarsest(load_scene("slab_release_2d", {**one, "solver.dx": 0.1})) == pytest.approx(1.0, rel=1e-4)


@pytest.mark.parametrize("name", ["pst_2d", "column_collapse_2d", "elastic_beam", "whumpf_2d"])
def test_no_proposal_costs_more_for_more_error(name, table):
    typical = {gain.move.name: gain.typical for gain in table}
    scene = load_scene(name)
    fast, accurate = faster(scene), more_accurate(scene)
    assert fast.ratio < 1.0 or not fast.overrides
    found = [float(change.lines[1].split(", ")[1].split()[0]) for change in (accurate,) if change.overrides]
    assert all(error < 1.0 for error in found) and min(typical.values()) < 1.0


def running(advice):
    """Expected run time once it has started [s]."""
    return advice.facts["run_time"] - next(row.seconds for row in advice.payments if row.what == "start")


@pytest.mark.parametrize("name", ["pst_2d", "column_collapse_2d"])
def test_the_time_expected_is_that_of_check(name):
    """Of the scene as it is and as it is moved, from what `check` says of each."""
    scene = load_scene(name)
    change = faster(scene)
    before, after = (running(advise(found)) for found in (scene, load_scene(name, change.overrides)))
    said = float(change.lines[1].split()[1])
    assert said == pytest.approx(before / after, rel=0.2)


def test_what_a_scene_chose_itself_stays():
    scene = load_scene("slab_release_2d", {"solver.kernel": "cubic", "solver.transfer": "flip"})
    assert not {"solver.kernel", "solver.transfer"} & (faster(scene).overrides | more_accurate(scene).overrides).keys()


def test_a_fixed_step_goes_with_the_grid():
    scene = load_scene("flow_warm_plug", {"solver.dt": 1e-5})
    changed = faster(scene).overrides
    assert "solver.cfl" not in changed
    assert changed["solver.dt"] / 1e-5 == pytest.approx(changed["solver.dx"] / scene.solver.dx, rel=1e-3)


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.slow] * (name in LARGE))
    for name in sorted(set(library()) - {"avalanche_depth_averaged", "slushflow"})])
def test_every_scene_of_the_library_is_moved_by_what_is_promised(name):
    scene = load_scene(name)
    change = faster(scene)
    if not change.overrides:
        assert "changes nothing" in change.lines[0] and (tuned_to_grid(scene) or coarsest(scene) < 1.25)
    else:
        assert load_scene(name, change.overrides).model_dump() != scene.model_dump()
        assert float(change.lines[1].split()[1]) > presets.FASTER or "times for sure" in change.lines[-1]
    load_scene(name, more_accurate(scene).overrides)


@pytest.mark.parametrize("scene", [("flow_warm_plug", {"solver.method": "sph"}), ("avalanche_depth_averaged", {})])
def test_other_methods_were_not_measured(scene):
    scene = load_scene(*scene)
    with pytest.raises(InputError, match=r"solver.method.*--fast"):
        faster(scene)


@pytest.mark.parametrize("name", ["block_wall_2d", pytest.param("mast", marks=pytest.mark.slow)])
def test_cells_on_which_a_body_would_be_too_light_are_not_chosen(name):
    """Found on the library: `--fast` took cells on which the scene was refused."""
    scene = load_scene(name)
    change = faster(scene)
    build(with_overrides(scene, change.overrides)).solver()
    assert "too light" in " ".join(change.lines)
