"""The runs of a campaign as a table for reading, and as curves over a parameter."""

import math

import numpy as np

from snowmpm.campaigns.answers import is_saw_test, summary
from snowmpm.campaigns.distributions import Choices
from snowmpm.campaigns.table import OF_OTHERS, WHY, parts
from snowmpm.campaigns.work import REFERENCE
from snowmpm.io.saw_theories import FLAT, THEORIES
from snowmpm.quantities.saw import BEFORE, REASONS, THEORY
from snowmpm.quantities.table import quantity

SHOWN = ("runout", "affected_area", "largest_flow_speed", "largest_flow_pressure")
"""Numbers with pictures of their own, of those that a campaign has."""

CLOUD = "largest_cloud_pressure_experiment"
"""Beside them, of a flow with a powder layer."""

SAW_SHOWN = ("saw_critical_length", "saw_crack_speed", "saw_collapse_height", "saw_fracture_energy")
"""Numbers of saw tests that are drawn and listed, in this order."""

PLAIN = ("front_distance", "max_speed", "kinetic_energy", "plastic_work")
"""Numbers of runs that have neither."""

WHOLE = "saw_runs_to_the_end"
MARK = "*"
UNMARKED = f"{MARK} the crack did not come to the end of the column"


def shown_numbers(campaign):
    """Names of the numbers that are drawn."""
    table = campaign.table
    varied = [row[0] for row in summary(table) if row[3] > row[1]]
    first = [*(name for name in table.columns if name.startswith(REFERENCE)),
             *(SAW_SHOWN if is_saw_test(table) else (*SHOWN, CLOUD, *PLAIN))]
    shown = [name for name in dict.fromkeys((*first, *varied)) if name in varied and not name.endswith(OF_OTHERS)]
    return shown[: len(SHOWN) + (CLOUD in shown)]


def numeric_parameters(file):
    """Names of the parameters of a `CampaignFile` whose values are numbers."""
    return [name for name, one in file.parameters.items()
            if not isinstance(one, Choices) or all(isinstance(value, int | float) for value in one.values)]


def theories_of(name):
    """{column: label} of the theories beside a measured number of a saw test."""
    return {f"{BEFORE}{THEORY}{one.predicted}": one.label for one in THEORIES if f"{BEFORE}{one.measured}" == name}


def listed(campaign):
    """Columns of the table for reading: parameters, main numbers; of saw tests with the theories beside."""
    table = campaign.table
    if not is_saw_test(table):
        return [*campaign.file.parameters, *shown_numbers(campaign)]
    known = [name for name in table.columns if name.startswith(REFERENCE)]
    numbers = [*known, *(column for name in SAW_SHOWN for column in (name, *theories_of(name)))]
    known = [name for name in numbers if name in table and table[name].notna().any()]
    return [*campaign.file.parameters, *known, *([WHOLE] if WHOLE in table else [])]


def listing(campaign, most):
    """Lines of the table for reading, with units; of saw tests those that did not run to the end are marked."""
    names, table = listed(campaign), campaign.table
    inputs = set(campaign.file.parameters)
    theories = {column: np.where(_applies(table, column), table[column].to_numpy(float), np.nan)
                for name in SAW_SHOWN for column in theories_of(name) if column in names}
    records = table.assign(**theories)[:most].to_dict("records")
    rows = [[_text(row.get(name), 6 if name in inputs else 4, row.get(f"{name}{WHY}")) for name in names]
            for row in records]
    marks = [MARK if row.get(WHOLE) is False else "" for row in records]
    heads = [_head(campaign, name) for name in names]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = [f"{'  '.join(map(str.rjust, row, widths))} {mark}".rstrip()
             for row, mark in zip((heads, *rows), ("", *marks), strict=True)]
    return lines + ([UNMARKED] if any(marks) else [])


def _head(campaign, name):
    if name in campaign.file.parameters:
        return name
    one = quantity(name, dimension=campaign.dimension)
    unit = "" if one.unit in ("1", "share") else f" [{one.unit}]"
    return f"{name.removeprefix(BEFORE)}{unit}"


def _text(value, digits, reason=""):
    """A value for reading; without one, its reason in short."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    missing = next((short for begin, short in REASONS.items() if str(reason).startswith(begin)), "-")
    if isinstance(value, float):
        return f"{value:.{digits}g}" if math.isfinite(value) else missing
    return missing if value is None or str(value) == "<NA>" else str(value)


def curves(campaign, name):
    """(parameter across, [(label, x, values, whole, is theory)]) of a number of a grid: over the numeric parameter with
    most values, a line for each choice of the others. whole: which runs of saw tests ran to the end, all of others."""
    parameters, table = campaign.file.parameters, campaign.table
    numeric = numeric_parameters(campaign.file)
    across = max(numeric, key=lambda one: table[one].nunique())
    others = [one for one in parameters if one != across]
    lines = []
    for said, own in parts(table, others, across):
        x = own[across].to_numpy(float)
        whole = own[WHOLE].fillna(False).to_numpy(bool) if WHOLE in own else np.ones(len(own), bool)
        lines.append((said or "computed", x, own[name].to_numpy(float), whole, False))
        for column, label in theories_of(name).items():
            if column in own:
                values = np.where(_applies(own, column), own[column].to_numpy(float), np.nan)
                if np.isfinite(values).any():
                    lines.append((f"{label}{', ' if said else ''}{said}", x, values, np.ones(len(own), bool), True))
    return across, lines


def _applies(own, column):
    """Where a theory holds: one of flat ground on gentle slopes only."""
    flat = any(one.flat for one in THEORIES if column.endswith(one.predicted))
    slope = [own[f"{BEFORE}{THEORY}{name}"].to_numpy(float) for name in ("shear_stress", "normal_stress")]
    return slope[0] <= np.tan(np.radians(FLAT)) * slope[1] if flat else np.ones(len(own), bool)
