"""Tables of a run as pandas data frames. Needs pandas, of the extra `xarray`."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.panels import HEAD, panel_rows
from snowmpm.io.saw_theories import further_theories
from snowmpm.io.status import cautions
from snowmpm.quantities.saw import BEFORE
from snowmpm.quantities.table import quantity, units_of

THALWEG_UNITS = {"x": "m", "y": "m", "z": "m", "s": "m", "peak_depth": "m", "peak_speed": "m/s", "peak_pressure": "Pa",
                 "deposit_depth": "m"}
LOADS = {"force": "N", "moment": "N m", "impulse": "N s", "work": "J"}


def require_pandas():
    """The package. Raises InputError, with the command to install it."""
    try:
        import pandas
    except ImportError:
        raise InputError("tables need pandas: pip install 'snowmpm[xarray]'") from None
    return pandas


def table(run, what):
    """Table `what` of a run -> pandas.DataFrame, see `Run.to_pandas`."""
    if what not in TABLES:
        raise InputError.not_in("table", what, list(TABLES))
    found = TABLES[what](run, require_pandas())
    found.attrs["not_final"] = list(cautions(run))
    return found


def history(run, pandas):
    """One row a frame or more; indexed by time."""
    return _frame(pandas, dict(run.history), run.units, "time")


def hazard(run, pandas):
    """Numbers of hazard mapping: value, unit and definition, indexed by name."""
    found = _named(pandas, run, run.hazard.get("numbers"), "numbers of hazard mapping")
    return _defined(found, [_quantity(run, name) for name in found.index])


def thalweg(run, pandas):
    """Along the thalweg, indexed by the distance s."""
    if not run.hazard.get("profile"):
        raise _none(run, "thalweg")
    values = {name: np.asarray(row, float) for name, row in run.hazard["profile"].items()}
    return _frame(pandas, values, THALWEG_UNITS, "s")


def saw_test(run, pandas):
    """Results of a propagation saw test beside theory: value, unit and definition; only for a finished run."""
    found = run.summary.get("saw_test")
    if not found:
        raise _none(run, "measured saw test (it is in the summary, at the end of a run)")
    found = {**found, "theory": {**found.get("theory", {}), **further_theories(run)}}
    reasons = found.pop("reasons", {})
    table = _named(pandas, run, _flat(found), "saw test")
    defined = _defined(table, [_of_saw_test(run, name) for name in table.index])
    return defined.assign(reason=[reasons.get(name, "") for name in defined.index])


def summary(run, pandas):
    """The content of summary.json, one row an entry; nested keys are joined by a dot."""
    if not run.summary:
        raise _none(run, "summary (it is written at the end of a run)")
    table = _named(pandas, run, _flat(run.summary), "summary")
    known = [_of_saw_test(run, name.removeprefix("saw_test.")) if name.startswith("saw_test.") else
             _quantity(run, name.rpartition(".")[2]) for name in table.index]
    table.attrs["units"] = _units(table, known)
    return table


def loads(run, pandas):
    """Loads by the snow on every obstacle, finer than the frames; indexed by obstacle and time."""
    if not run.obstacles:
        raise _none(run, "obstacles")
    width = "/m" if run.dimension == 2 else ""
    frames, units = {}, {}
    for name, one in run.obstacles.items():
        columns = {"time": one.time}
        for load, unit in LOADS.items():
            values = vars(one)[load]
            named = {load: values} if values.ndim == 1 else {f"{load}_{axis}": values[:, k]
                                                             for k, axis in enumerate("xyz")}
            columns |= named
            units |= dict.fromkeys(named, unit + width)
        frames[name] = pandas.DataFrame(columns).set_index("time")
    found = pandas.concat(frames, names=["obstacle"])
    found.attrs["units"] = units
    return found


def panels(run, pandas):
    """A row a panel of the obstacles with panels: place, peak and impulse."""
    found = pandas.DataFrame(panel_rows(run), columns=list(HEAD)).set_index(list(HEAD[:3]))
    found.attrs["units"] = {name: name.rpartition("_")[2] for name in HEAD[3:]} | {"impulse_Pa_s": "Pa s"}
    return found


TABLES = {"history": history, "summary": summary, "hazard": hazard, "thalweg": thalweg, "saw_test": saw_test,
          "loads": loads, "panels": panels}
"""Functions (run, pandas) -> DataFrame by name."""


def _none(run, what):
    return InputError(f"{run.path}: no {what}")


def _frame(pandas, columns, units, index):
    found = pandas.DataFrame(columns).set_index(index)
    found.attrs["units"] = {name: units.get(name, "") for name in columns}
    return found


def _named(pandas, run, values, what):
    if not values:
        raise _none(run, what)
    return pandas.DataFrame({"value": list(values.values())}, index=pandas.Index(list(values), name="name"))


def _quantity(run, name):
    return quantity(name, dimension=run.dimension)


def _of_saw_test(run, name):
    """The quantity of an entry of the summary's saw_test, such as critical_length, saw.notch or theory.maxwell_load."""
    return _quantity(run, BEFORE + name.removeprefix("saw.").replace(".", "_"))


def _defined(table, known):
    """The table with the units and definitions of its rows, `known` quantities."""
    units = _units(table, known)
    found = table.assign(unit=list(units.values()), definition=[one.definition for one in known])
    found.attrs["units"] = units
    return found


def _units(table, known):
    """{row: unit as stored in files}; "" of what the table of quantities does not know."""
    return {row: units_of([one])[one.name] if one.definition else ""
            for row, one in zip(table.index, known, strict=True)}


def _flat(values, before=""):
    rows = {}
    for name, value in values.items():
        rows |= _flat(value, f"{before}{name}.") if isinstance(value, dict) else {f"{before}{name}": value}
    return rows
