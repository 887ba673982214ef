"""A Python function in place of a run: the same designs, workers, table and sensitivities, without folders and maps."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.campaigns import answers, cluster, table
from snowmpm.campaigns.conduct import Conductor
from snowmpm.campaigns.members import Member, Plan, samples
from snowmpm.campaigns.spec import CampaignFile
from snowmpm.errors import shown_line
from snowmpm.stages import stage

TOGETHER = 256
"""Values that a worker takes at a time."""


@dataclass(frozen=True)
class Rows:
    """Values of the parameters of several runs, from number `first` on."""

    function: Callable[[dict[str, Any]], Mapping[str, float]]
    first: int
    values: list[dict[str, Any]]


def evaluate(rows):
    """Records of the function at each of the values; an exception is a failed run."""
    return [_record(rows.function, values) for values in rows.values]


def _record(function, values):
    try:
        numbers = {name: float(value) for name, value in function(values).items()}
        return {"status": "done", "reason": "", "numbers": numbers}
    except Exception as error:
        return {"status": "failed", "reason": shown_line(f"{type(error).__name__}: {error}", 300), "numbers": {}}


def evaluate_campaign(function: Callable[[dict[str, Any]], Mapping[str, float]],
                      parameters: Mapping[str, Mapping[str, Any]], site: Any = None, **options: Any) -> tuple[Any, Any]:
    """(table, sensitivities) of a function of the parameters' values -> {name: number} (pandas).

    parameters: as of `snowmpm.campaign`, whose keys may be left out; site: `cluster.Site` to use, else processes of
    this machine are started; options: keys of a campaign's file. Raises InputError.
    """
    data = {"name": "function", "scene": "function", **options,
            "parameters": {name: {"key": name, **one} for name, one in parameters.items()}}
    file = CampaignFile.checked(data, "campaign", Path.cwd())
    members = [Member("base", i, values, {}, str(i)) for i, values in enumerate(samples(file))]
    plan, records = Plan(file, Path.cwd(), members), {}
    if site is None:
        with cluster.site(file.cluster) as own:
            _conduct(own, function, members, records)
    else:
        _conduct(site, function, members, records)
    return table.frame_of(table.rows_of(plan, records)), answers.sensitivity_table(plan, "base", records)


def _conduct(site, function, members, records):
    jobs = [Rows(function, first, [member.values for member in members[first : first + TOGETHER]])
            for first in np.arange(0, len(members), TOGETHER).tolist()]
    with stage("evaluating", len(members), "values") as now:
        for job, outcome in Conductor(site).results(evaluate, jobs):
            for k in range(len(job.values)):
                records[str(job.first + k)] = outcome[k] if isinstance(outcome, list) else {
                    "status": "failed", "reason": str(outcome), "numbers": {}}
            now.done += len(job.values)
