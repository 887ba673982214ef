"""The table of a campaign: a row a run, with its parameters and every number of it. Parquet and CSV."""

import io
import itertools

import numpy as np

from snowmpm.campaigns import untrusted
from snowmpm.campaigns.members import ONLY
from snowmpm.campaigns.untrusted import TRUTHS
from snowmpm.campaigns.work import RECORD, read_record
from snowmpm.draft import draft, write_text

FILE, CSV, WORK = FILES = "table.parquet", "table.csv", "work.csv"
MISSING = "missing"
WHY = "_reason"
"""End of the name of a column that says why a number of a saw test has no value."""


OF_OTHERS = ("_resolution", "_spread")
"""Ends of the names of numbers that say to what other numbers are known."""


def rows_of(plan, records):
    """Rows of the runs of a `Plan`, in its order; records: by hash."""
    rows, explained = [], _explained(records)
    for member in plan.members:
        record = records.get(member.hash) or {"status": MISSING, "reason": "", "numbers": {}}
        variant = {} if plan.variants == [ONLY] else {"variant": member.variant}
        rows.append({"run": member.run, **variant, "hash": member.hash, **member.values, "status": record["status"],
                     "reason": record["reason"], **record["numbers"],
                     **{f"{name}{WHY}": record.get("reasons", {}).get(name, "") for name in explained}})
    return rows


def _explained(records):
    """Names of the numbers that some run has no value of, and a reason instead."""
    return sorted({name for record in records.values() for name in record.get("reasons", {})})


def records_of(plan):
    """Records of the runs of a plan that are done, by hash."""
    found = {}
    for member in plan.members:
        if member.hash not in found and (record := read_record(plan.results(member))) is not None:
            taken = set(record["numbers"]) & set(plan.file.parameters)
            if taken:
                raise untrusted.damaged(plan.results(member) / RECORD, f"{min(taken)}: is a parameter, not a result")
            found[member.hash] = record
    return found


def frame_of(rows):
    """The rows as a `pandas.DataFrame`; numbers as float64, truth values as booleans that may be missing."""
    import pandas

    table = pandas.DataFrame(rows)
    for name in TRUTHS:
        if name in table:
            table[name] = table[name].astype("boolean")
    return table


def parts(table, names, along):
    """(words, rows) of each choice of the values of some columns, its rows in the order of the column `along`."""
    for choice in itertools.product(*(list(dict.fromkeys(table[name])) for name in names)):
        own = table[np.logical_and.reduce([table[name] == value for name, value in zip(names, choice, strict=True)])
                    if names else slice(None)]
        yield ", ".join(f"{name} {value}" for name, value in zip(names, choice, strict=True)), own.sort_values(along)


def write_tables(plan, records):
    """Write table.parquet, table.csv and work.csv (who did which run, and in which time); -> the table."""
    import pandas

    table = frame_of(rows_of(plan, records))
    with draft(plan.folder / FILE) as part:
        _as_text(table).to_parquet(part, index=False)
    text = io.StringIO()
    table.to_csv(text, index=False, lineterminator="\n")
    write_text(plan.folder / CSV, text.getvalue())
    work = pandas.DataFrame([{"hash": name, **record.get("work", {})} for name, record in records.items()])
    text = io.StringIO()
    work.to_csv(text, index=False, lineterminator="\n")
    write_text(plan.folder / WORK, text.getvalue())
    return table


def _as_text(table):
    """Columns of mixed values, such as choices of numbers and words, as text, which Parquet demands."""
    mixed = [name for name in table.columns if table[name].dtype == object
             and len({type(value) for value in table[name]}) > 1]
    return table.assign(**{name: table[name].map(str) for name in mixed}) if mixed else table
