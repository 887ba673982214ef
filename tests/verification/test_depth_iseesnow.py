"""D12: the two avalanches of the ISeeSnow study by the depth-averaged method, beside thirteen programs."""

from pathlib import Path

import numpy as np
import pytest

import snowmpm
from tests.support.iseesnow import CASES, of_program, of_run, scene, scene_3d

DATA = Path(__file__).parents[3] / "shared" / "data" / "iseesnow"
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not DATA.is_dir(), reason="without the study's data")]
READ = ("runout", "speed_95", "speed_99", "depth_95", "depth_99", "speed_area", "depth_area")


@pytest.fixture(scope="module", params=CASES)
def found(request, tmp_path_factory):
    """Case, numbers of all programs, and ours on cells of 5 and 2.5 m."""
    case, folder = request.param, tmp_path_factory.mktemp("runs")
    own = [of_run(DATA, case, snowmpm.run(scene(DATA, case, dx), folder / f"{dx:g}")) for dx in (5.0, 2.5)]
    return case, of_program(DATA, case), own


@pytest.mark.parametrize("name", READ)
def test_within_the_range_of_the_programs(found, name, request):
    case, programs, (own, _) = found
    if (case, name) == ("IdealizedTopo", "speed_95"):
        request.applymarker(pytest.mark.xfail(strict=True, reason="38.06 m/s, of the programs at most 37.89"))
    others = [numbers[name] for numbers in programs.values()]
    assert min(others) <= own[name] <= max(others)


def test_run_out_is_nearer_to_the_median_than_half_of_the_programs(found):
    _, programs, (own, _) = found
    others = np.array([numbers["runout"] for numbers in programs.values()])
    away = np.abs(others - np.median(others))
    assert abs(own["runout"] - np.median(others)) <= np.median(away)


def test_half_the_spacing_changes_the_run_out_by_less_than_a_hundredth(found):
    _, _, (coarse, fine) = found
    assert coarse["runout"] == pytest.approx(fine["runout"], rel=0.01)


def test_the_centrifugal_term_shortens_the_run_out(tmp_path):
    """A block stops at 3095 m with it and at 3597 m without."""
    run = snowmpm.run(scene(DATA, "CoulombOnly", solver={"method": "depth", "dx": 5.0, "depth": {
        "centrifugal": False}}), tmp_path)
    without = of_run(DATA, "CoulombOnly", run)["runout"]
    assert 3500.0 < without < 3700.0


def test_mpm_in_three_dimensions_comes_as_far_and_as_fast_as_the_mpm_of_the_study(tmp_path):
    """Coulomb friction, on cells of 3 m; its areas count cells that a program's own maps show."""
    own = of_run(DATA, "CoulombOnly", snowmpm.run(scene_3d(DATA, "CoulombOnly", 3.0), tmp_path))
    study = of_program(DATA, "CoulombOnly")["MPM"]
    assert own["runout"] == pytest.approx(study["runout"], rel=0.02)
    for name in ("speed_95", "speed_99"):
        assert own[name] == pytest.approx(study[name], rel=0.02)
