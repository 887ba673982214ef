"""Scenarios of a campaign side by side: their numbers in one table."""

from snowmpm.campaigns.distributions import Scenarios
from snowmpm.draft import write_table
from snowmpm.errors import shown_line
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import PRESSURES
from snowmpm.quantities.table import quantity

NUMBERS = ("release_volume", "runout", "travel_angle", "reach_of_flow",
           *(f"reach_of_{p / 1e3:g}_kPa" for p in PRESSURES),
           "affected_area", *(f"area_above_{p / 1e3:g}_kPa" for p in PRESSURES), "largest_flow_depth",
           "largest_flow_speed", "largest_flow_pressure", "deposit_area", "deposit_volume", "deposit_mean_depth")
"""Numbers of the table, in its order."""
FILES = ("scenarios.csv", "scenarios.gpkg")
MOST = 40
"""Runs that are put side by side."""


def has(file):
    """Whether a `CampaignFile` has scenarios."""
    return any(isinstance(one, Scenarios) for one in file.parameters.values())


def done(campaign, most=MOST):
    """[(name, `Run`)] of the runs of a campaign with scenarios that are done and were kept, at most so many; [] without
    scenarios."""
    if not has(campaign.file):
        return []
    members = [one for one in campaign.members if campaign.records.get(one.hash, {}).get("status") == "done"]
    return [(_name(campaign, one), campaign.run(one.run)) for one in members[:most]
            if campaign.plan.run(one).is_dir()]


def _name(campaign, member):
    """Scenario of a run, and its other parameters."""
    parameters = campaign.file.parameters
    return ", ".join(shown_line(value if isinstance(parameters[name], Scenarios) else f"{name} {value}", 60)
                     for name, value in member.values.items())


def _rows(found):
    """(number, values) of NUMBERS that some of (name, `Run`) have."""
    numbers = [run.summary.get("hazard") or run.hazard.get("numbers") or {} for _, run in found]
    rows = [(name, [one.get(name) for one in numbers]) for name in NUMBERS]
    return [row for row in rows if any(value is not None for value in row[1])]


def lines(found):
    """The numbers of (name, `Run`) as a table for reading, with units."""
    rows = [["", *(name for name, _ in found)],
            ["final", *("yes" if status_of(run).final else "no" for _, run in found)]]
    rows += [[quantity(name).label, *("-" if value is None else quantity(name).text(value) for value in values)]
             for name, values in _rows(found)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    table = ["  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip() for row in rows]
    return table + [f"{name}: {status.text}" for name, run in found if not (status := status_of(run)).final]


def told(campaign):
    """Lines of the table of a campaign with scenarios, [] of another."""
    found = done(campaign)
    return lines(found) if found else []


def write_numbers(found, path):
    """Write the numbers of (name, `Run`) as CSV; -> the path."""
    rows = [["status", "whether the run is final", "", *(status_of(run).text for _, run in found)]]
    rows += [[name, quantity(name).label, quantity(name).unit, *("" if value is None else value for value in values)]
             for name, values in _rows(found)]
    return write_table(path, ["name", "label", "unit", *(name for name, _ in found)], rows)
