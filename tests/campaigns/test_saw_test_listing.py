"""Saw tests in a campaign: what is listed, marked and drawn, from a table made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.campaigns.distributions import Choices
from snowmpm.render.campaign_plot import render_curves

pandas = pytest.importorskip("pandas")
ROWS = {"thickness": [0.5, 0.3, 0.4], "status": ["done"] * 3, "mass": [361.0, 229.0, 295.0],
        "saw_critical_length": [0.35, 0.45, 0.4], "saw_crack_length": [3.0, 1.3, 3.0],
        "saw_crack_speed": [38.4, 12.6, 25.0], "saw_runs_to_the_end": [True, False, True],
        "saw_theory_critical_length_energy": [0.40, 0.47, 0.44], "saw_theory_collapse_wave_speed": [31.0, np.nan, 30.0],
        "saw_theory_shear_stress": [0.0, 0.0, 300.0], "saw_theory_normal_stress": [1000.0, 647.0, 860.0]}


@pytest.fixture
def campaign():
    from snowmpm.campaigns.table import frame_of

    values = Choices(key="saw_test.slab.0.thickness", distribution="choices", values=(0.5, 0.3, 0.4))
    rows = [dict(zip(ROWS, row, strict=True)) for row in zip(*ROWS.values(), strict=True)]
    table = frame_of(rows)
    return SimpleNamespace(table=table, dimension=2, file=SimpleNamespace(parameters={"thickness": values}),
                           values=lambda name: table[name].to_numpy(float))


def test_what_is_listed_is_of_the_saw_test(campaign):
    from snowmpm.campaigns.listing import UNMARKED, listing, shown_numbers

    assert shown_numbers(campaign)[:2] == ["saw_critical_length", "saw_crack_speed"]
    head, *rows, last = listing(campaign, 100)
    assert head.split("  ")[0].strip() == "thickness" and "critical_length [m]" in head and "mass" not in head
    assert "theory_critical_length_energy [m]" in head and head.rstrip().endswith("runs_to_the_end")
    assert [row.endswith("*") for row in rows] == [False, True, False] and last == UNMARKED
    assert rows[1].split()[:3] == ["0.3", "0.45", "0.47"]


def test_a_grid_is_a_curve_beside_its_theories(campaign, tmp_path):
    from snowmpm.campaigns.listing import curves

    across, lines = curves(campaign, "saw_critical_length")
    assert across == "thickness" and [line[4] for line in lines] == [False, True]
    np.testing.assert_array_equal(lines[0][1], [0.3, 0.4, 0.5])
    np.testing.assert_array_equal(lines[0][2], [0.45, 0.4, 0.35])
    np.testing.assert_array_equal(lines[0][3], [False, True, True])
    # The collapse wave is one of flat ground: not beside the run on a slope
    np.testing.assert_array_equal(curves(campaign, "saw_crack_speed")[1][1][2], [np.nan, np.nan, 31.0])
    path = render_curves("saw_critical_length", across, lines, tmp_path / "curve.png")
    assert path.stat().st_size > 10_000


def test_parameters_are_no_results(campaign):
    from snowmpm.campaigns.answers import summary

    assert "thickness" not in [row[0] for row in summary(campaign.table)]
    plain = campaign.table[["thickness", "status", "mass"]]
    assert [row[0] for row in summary(plain)] == ["mass"]
