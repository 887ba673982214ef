"""The numbers of a run as tables: CSV for spreadsheets, JSON for programs. Each says whether the run is final."""

import json

from snowmpm.draft import write_table, write_text
from snowmpm.io.impact import impacts
from snowmpm.io.parameters import parameters
from snowmpm.io.projection import projection_name
from snowmpm.io.published import resolution_of, statement
from snowmpm.io.status import LEFT_SHARE, status_of
from snowmpm.quantities.resolution import rounded
from snowmpm.quantities.table import quantity

SCORES = {"area": "m2", "index": "1", "rate": "1", "ratio": "1", "reach": "m", "difference": "m"}
"""Units of scores against an observation, by the end of their names."""


def write_numbers(path, run, asked):
    """Write the numbers of hazard mapping of a `Run` as CSV, each with resolution, unit and definition, and those of
    `snowmpm.gis.asked.Asked`; -> its path."""
    status, known = status_of(run), resolution_of(run)
    rows = [["status", "whether the run is final", status.text, "", "",
             f"Complete, at rest, at most {100.0 * LEFT_SHARE:g} % of the mass lost over the edge."],
            ["statement", "what this is", statement(run), "", "", ""]]
    for name, value in run.hazard.get("numbers", {}).items():
        one, resolution = quantity(name), known.get(name)
        rows.append([name, one.label, rounded(value, resolution), f"{resolution:.2g}" if resolution else "",
                     "1" if one.unit == "share" else one.unit, one.definition])
    for score in asked.scores or ():
        outline = score["outline"].replace(" ", "_")
        rows += [[f"observed.{outline}.{name}", f"{name.replace('_', ' ')}, {score['outline']}", rounded(value), "",
                  SCORES[name.rpartition("_")[2]], ""] for name, value in score.items() if name != "outline"]
    rows += [[f"impact.{obstacle}.{name}", f"{quantity(name).label}, on {obstacle}", one["value"], "", one["unit"],
              one["definition"]] for obstacle, load in _impacts(run).items() for name, one in load.items()]
    rows += [[f"gauge.{name}.{key}", f"{quantity(key).label}, {name}", one["value"], "", one["unit"],
              one["definition"]] for name, numbers in _measured(asked.gauges).items() for key, one in numbers.items()]
    if asked.along:
        rows.append(["path", "path of the numbers path_*", asked.path[0] if asked.path else "thalweg", "", "", ""])
    rows += [[name, quantity(name).label, _digits(name, value), "", quantity(name).unit, quantity(name).definition]
             for name, value in asked.along.items()]
    return write_table(path, ["name", "label", "value", "resolution", "unit", "definition"], rows)


def _digits(name, value):
    """A number as it is written: coordinates and angles to their decimals."""
    decimals = quantity(name).decimals
    return rounded(value) if decimals is None else round(value, decimals)


def write_areas(path, run):
    """Write the affected area of a `Run` by classes of each map as CSV; -> its path."""
    status = status_of(run)
    rows = [[name, row["class"], row["from"], "" if row["to"] is None else row["to"], quantity(name).unit, row["area"],
             status.final] for name, classes in run.hazard.get("classes", {}).items() for row in classes]
    return write_table(path, ["map", "class", "from", "to", "unit", "area_m2", "final"], rows)


def _impacts(run):
    """Loads on the obstacles of a `Run`: {obstacle: {name: {value, unit, definition}}}."""
    return {obstacle: {name: {"value": float(value), "unit": one.units().get(name, quantity(name).unit),
                              "definition": quantity(name).definition} for name, value in one.numbers.items()}
            for obstacle, one in impacts(run).items()}


def _measured(gauges):
    """Numbers of gauges: {gauge: {name: {value, unit, definition}}}; None of what did not happen."""
    found = {}
    for gauge in gauges:
        found[gauge.place.name] = {
            name: {"value": None if value is None else rounded(value), "unit": quantity(name).unit,
                   "definition": quantity(name).definition} for name, value in gauge.numbers.items()}
    return found


def write_record(path, run, asked):
    """Write everything as JSON: status, numbers with units, areas by class, parameters, and what was asked; -> its
    path."""
    known = resolution_of(run)
    numbers = {name: {"value": rounded(value, known.get(name)), "resolution": known.get(name),
                      "unit": quantity(name).unit, "definition": quantity(name).definition}
               for name, value in run.hazard.get("numbers", {}).items()}
    record = {**status_of(run).record(), "statement": statement(run), "run": run.name,
              "projection": projection_name(run.provenance.get("crs")),
              "parameters": parameters(run), "numbers": numbers, "impacts": _impacts(run),
              "areas_by_class": run.hazard.get("classes", {}),
              "path": asked.path[0] if asked.path else "thalweg",
              "along_path": {name: {"value": _digits(name, value), "unit": quantity(name).unit,
                                    "definition": quantity(name).definition} for name, value in asked.along.items()},
              **({"observed": asked.scores} if asked.scores is not None else {}),
              **({"gauges": _measured(asked.gauges)} if asked.gauges else {})}
    return write_text(path, json.dumps(record, indent=1) + "\n")
