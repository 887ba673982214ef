"""What `snowmpm check` says that weak layers as interfaces and variable lengths of SPH cost, against measured runs
(`tests.support.scene_runs`)."""

import functools
import typing

import pytest

from snowmpm.advice.budget import WITHIN
from snowmpm.cli.options import scene_overrides
from snowmpm.measured import costs
from snowmpm.scenes.numerics import Sph
from tests.support.scene_runs import STEPPING, budget_of, forecast, made, measured, rows

WORDS = "layers thinner than a cell"
"""Of interfaces, in the table of `check`."""
CHOICES = [row for row in rows() if row["settings"] or row["scene"].endswith(".toml")]


def named(row):
    return f"{row['scene']} {row['settings']}".strip()


def budget_of_row(row):
    return _budget(row["scene"], row["settings"])


@functools.cache
def _budget(name, settings):
    return made(name, scene_overrides(settings.split()))


BEYOND = {
    "docs/slope_release.toml": "34 % too cheap: 30 % too few steps",
    "pst_2d": "31 % too cheap: frames of a small scene take 4.4 s for 2.5",
    "column_collapse_2d": "54 % too cheap: launches for its few particles take 1 ms a step for 0.16",
    "column_collapse_3d": "35 % too cheap, not found why"}
"""Scenes whose runs cost more or less than is foretold."""
FEW_STEPS = {"docs/slope_release.toml": "924 for 1318; not found why"}
"""Scenes whose steps are foretold worse than within 15 %."""


def but_for(exceptions):
    """The rows, of which those of `exceptions` {scene: reason} are expected to fail."""
    return [pytest.param(row, id=named(row), marks=pytest.mark.xfail(strict=True, reason=exceptions[row["scene"]])
                         if row["scene"] in exceptions else ()) for row in CHOICES]


@pytest.mark.slow
def test_interfaces_and_lengths_are_in_the_table():
    """In the plane and in space."""
    budgets = [budget_of_row(row) for row in CHOICES]
    assert {one.facts.dim for one in budgets if "interface_layer" in one.step_load.components} == {2, 3}
    assert {one.facts.dim for one in budgets if one.scheme.lengths == "mean"} == {2, 3}


@pytest.mark.slow
@pytest.mark.parametrize("row", but_for(BEYOND))
def test_forecasts_are_right_within_thirty_per_cent(row):
    assert forecast(budget_of_row(row), row) == pytest.approx(measured(row), rel=WITHIN)


@pytest.mark.slow
@pytest.mark.parametrize("row", [row for row in CHOICES if "lengths" not in row["settings"]], ids=named)
def test_a_step_with_an_interface_costs_what_is_foretold(row):
    """Within thirty per cent, output and the number of steps apart."""
    spent = sum(float(row[stage]) for stage in STEPPING) / float(row["steps"])
    machine = costs.reference_speed()[0] / float(row["vector"])
    assert budget_of_row(row).step() == pytest.approx(machine * spent, rel=WITHIN)


@pytest.mark.slow
@pytest.mark.parametrize("row", but_for(FEW_STEPS))
def test_steps_of_measured_runs(row):
    steps = budget_of_row(row).facts.steps_until(float(row["part"]))
    assert steps == pytest.approx(float(row["steps"]), rel=0.15)


def shortened(budget):
    return budget.facts.solver.workload.shortened["interface_layer"]


def test_check_tells_of_the_points_and_their_step():
    """c / t of a layer thinner than a fifth of the cell shortens the step; one as thick as the cell hardly does."""
    coarse, fine = (made("pst_2d", {
        "solver.dx": dx, "initial.stress": "geostatic", "saw_test.weak_layer": {
            "material": "weak_layer", "thickness": 0.05, "interface": 4}}) for dx in (0.25, 0.05))
    told = {budget: next(row for row in budget.payments() if row.what == WORDS) for budget in (coarse, fine)}
    assert f", {24 * 4} points, steps 0." in told[coarse].detail
    assert shortened(coarse) < 0.5 < shortened(fine) < 1.0
    assert all(row.seconds > 0.0 and 0.0 < row.share < 1.0 for row in told.values())


def test_no_interface_costs_nothing():
    budget = budget_of("pst_2d")
    assert "interface_layer" not in budget.stages()
    assert all(row.what != WORDS for row in budget.payments())


@pytest.mark.parametrize("dim", (2, 3))
def test_lengths_that_follow_cost_more(dim):
    """Every choice has its row."""
    names = typing.get_args(Sph.model_fields["lengths"].annotation)
    cost = {name: costs.transfers(costs.Scheme(dim, method="sph", lengths=name)) for name in names}
    assert all(cost[name] > cost["constant"] for name in names if name != "constant")
