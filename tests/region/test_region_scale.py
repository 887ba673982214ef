"""How a region scales: batches of jobs, and the figures of the guide."""

import csv
import re

import numpy as np
import pytest

from snowmpm.region import launch
from tests.benchmarks.region_scale import simulate
from tests.support.project import ROOT


def test_few_workers_get_one_run_at_a_time():
    assert launch.batch_of(2, 2.4) == 1 and launch.batch_of(100, 2.4) == 1
    assert launch.batch_of(10_000, 2.4) > 20 and launch.batch_of(10**6, 0.1) == launch.MOST_BATCH


def test_a_batch_that_came_to_nothing_comes_again_one_by_one():
    todo = launch.Batches(iter(range(5)), 2)
    first = next(todo)
    todo.again(first)
    assert [first, *todo] == [(0, 1), (0,), (1,), (2, 3), (4,)]
    todo.again((9,))
    assert list(todo) == [(9,)]


def test_simulated_workers():
    """Without overhead the work is shared; the scheduler alone bounds what many workers do."""
    assert simulate([3600.0] * 10, 10, 0.0)[0] == pytest.approx(1.0)
    hours, busy = simulate([1.0] * 1000, 10_000, 0.01)
    assert hours * 3600.0 == pytest.approx(11.0, rel=0.01) and busy == pytest.approx(10.0 / 11.0, rel=0.01)


def test_the_table_of_the_guide_is_that_of_the_simulation():
    with (ROOT / "tests" / "benchmarks" / "figures" / "region_scale.csv").open() as file:
        rows = {int(row["workers"]): row for row in csv.DictReader(file)}
    guide = (ROOT / "docs" / "region.md").read_text(encoding="utf-8").partition("## How long, how large")[2]
    told = re.findall(r"^\| ([\d ]+) \| (\d+) \| ([\d.]+) \| (\d+) % \|", guide, re.MULTILINE)
    assert len(told) == len(rows)
    for workers, batch, hours, efficiency in told:
        row = rows[int(workers.replace(" ", ""))]
        assert (int(batch), float(hours)) == (int(row["batch"]), pytest.approx(float(row["hours"]), rel=0.01))
        assert int(efficiency) == round(100 * float(row["efficiency"]))


def test_the_forecast_is_the_mean_of_what_was_measured(region_file, tmp_path):
    from snowmpm.region import forecast, preparing
    from snowmpm.region.spec import read_region

    setting = preparing.make(read_region(region_file()), tmp_path / "out")
    found = forecast.forecast(setting, 2, 1000, np.full(8, 3.0))
    assert found.each == 3.0 and found.seconds == pytest.approx(1500.0 + forecast.START)
    assert forecast.forecast(setting, 2, 4, np.empty(0)).each is None
    own = forecast.forecast(setting)
    assert own.runs == 4 and 0.05 < own.each < 20.0
