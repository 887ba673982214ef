"""From the records of a campaign to its table, maps, sensitivities and convergence, for one variant at a time."""

import io

import numpy as np

from snowmpm.campaigns import convergence, design, probability, sensitivity, stack
from snowmpm.campaigns.distributions import Choices, Drawn
from snowmpm.campaigns.members import ONLY
from snowmpm.campaigns.table import frame_of, rows_of, write_tables
from snowmpm.campaigns.work import REFERENCE
from snowmpm.draft import write_text
from snowmpm.quantities.saw import MEASURED, PREDICTED
from snowmpm.quantities.table import NUMBERS

SENSITIVITY, CONVERGENCE = "sensitivity.csv", "convergence.csv"


def write_answers(plan, records):
    """Write everything that follows from the records: tables, maps, sensitivities, convergence."""
    write_tables(plan, records)
    for variant in plan.variants:
        if stack.write_stack(plan, variant, records):
            _write_maps(plan, variant, records)
            _write_csv(plan, variant, CONVERGENCE, convergence_table(plan, variant, records))
        _write_csv(plan, variant, SENSITIVITY, sensitivity_table(plan, variant, records))


def _write_csv(plan, variant, name, table):
    text = io.StringIO()
    table.to_csv(text, index=False, lineterminator="\n")
    write_text(_file(plan, variant, name), text.getvalue())


def _file(plan, variant, name):
    return plan.folder / (name if variant == ONLY else f"{variant}_{name}")


def written(plan, variant, name):
    """A table that `write_answers` wrote (pandas); empty where there is none yet."""
    import pandas

    try:
        return pandas.read_csv(_file(plan, variant, name), keep_default_na=False, na_values=["", "nan"])
    except (FileNotFoundError, pandas.errors.EmptyDataError):
        return pandas.DataFrame()


def table(plan, records):
    """The table of all runs (`snowmpm.campaigns.table`)."""
    return frame_of(rows_of(plan, records))


def counting(plan, variant, records):
    """Positions of the runs of a variant that count for shares of runs: those done, and of a saltelli design those of
    its base, which alone are independent."""
    members = [member for member in plan.members if member.variant == variant]
    last = 2 * plan.file.runs if plan.file.design == "saltelli" else len(members)
    return np.array([k for k, member in enumerate(members[:last])
                     if records.get(member.hash, {}).get("status") == "done"], int)


def samples_the_parameters(file):
    """Whether shares of the runs of a `CampaignFile` are probabilities: its design is a sample of its distributions."""
    return file.design in (*design.RANDOM, "saltelli")


def _write_maps(plan, variant, records):
    whole = stack.open_stack(plan.folder, variant)
    rows = counting(plan, variant, records)
    random = samples_the_parameters(plan.file)
    about = {"campaign": plan.file.name, "scene": plan.file.scene, "design": plan.file.design,
             "meaning": "probability" if random else "share of the runs of a design that is no sample"}
    return probability.write_maps(plan.folder, variant, whole, plan.file.maps, rows, about)


def convergence_table(plan, variant, records):
    """Convergence of the probability of the first limit of depth, and of pressure (pandas)."""
    import pandas

    whole, rows = stack.open_stack(plan.folder, variant), counting(plan, variant, records)
    if whole is None or not len(rows):
        return pandas.DataFrame()
    limits = [(name, min(plan.file.maps[name])) for name in ("depth", "pressure")
              if plan.file.maps[name]]
    return pandas.DataFrame(convergence.convergence(whole, limits, rows, whole.attrs["cell"]))


def sensitivity_table(plan, variant, records):
    """Sensitivities of all numbers (pandas). Parameters count by their shares: a choice by the middle of its own."""
    import pandas

    file = plan.file
    members = [member for member in plan.members if member.variant == variant]
    names = [name for name, one in file.parameters.items() if not isinstance(one, Drawn)]
    if not names or not members:
        return pandas.DataFrame()
    u = np.array([[_share(file.parameters[name], member.values[name]) for name in names] for member in members])
    found = [records.get(member.hash, {}) for member in members]
    done = [record.get("numbers", {}) if record.get("status") == "done" else {} for record in found]
    wanted = dict.fromkeys(name for numbers in done for name in numbers if name not in CONSTANT)
    numbers = {name: np.array([row.get(name, np.nan) for row in done], float) for name in wanted}
    whole = len(members) == len(plan_rows(plan))
    kind = file.design if file.design != "saltelli" or whole else "random"
    independent = not file.correlated and len(names) == len(file.parameters)
    return pandas.DataFrame(sensitivity.sensitivities(kind, u, numbers, names, independent, file.seed))


CONSTANT = ("final", "flow_depth", "moving_share", "momentum_share", "runout_x", "runout_y", "runout_z",
            "deposit_reach_x", "deposit_reach_y", "deposit_reach_z", "thalweg_dry", "thalweg_climb", "steps", "dt")
"""Numbers that no share of variance is looked for."""

FIRST = ("runout", "travel_angle", "affected_area", "largest_flow_speed", "largest_flow_pressure")
"""What an engineer asks for before all else."""
MAIN = (*FIRST, *(one.name for one in NUMBERS if one.name not in FIRST))
SAW = tuple(one.name for one in (*MEASURED, *PREDICTED))


def is_saw_test(table):
    """Whether the runs of a table are saw tests."""
    return SAW_LENGTH in table


SAW_LENGTH = "saw_crack_length"
"""A number that every saw test has."""


def plan_rows(plan):
    """Runs of the variant with the most of them."""
    by_variant = {}
    for member in plan.members:
        by_variant.setdefault(member.variant, []).append(member)
    return max(by_variant.values(), key=len)


def _share(parameter, value):
    """Share of a value: where it lies in its distribution."""
    if isinstance(parameter, Choices):
        return float(parameter.shares()[list(parameter.values).index(value)])
    return parameter.share(value)


def summary(table):
    """[(number, 5 %, median, 95 %)] of the runs that are done, of the numbers of hazard mapping or of a saw test, else
    of all that are no parameters."""
    done = table[table.status == "done"] if "status" in table else table
    main = [*(name for name in table.columns if name.startswith(REFERENCE)), *(SAW if is_saw_test(table) else MAIN)]
    names = [name for name in main if name in table and name not in CONSTANT]
    names = names or list(table.columns)[list(table.columns).index("status") + 1 if "status" in table else 0 :]
    names = [name for name in names if table[name].dtype == float and name not in CONSTANT]
    found = []
    for name in names:
        values = done[name].to_numpy(float)
        values = values[np.isfinite(values)]
        if len(values):
            found.append((name, *np.quantile(values, (0.05, 0.5, 0.95)).tolist()))
    return found
