"""The numbers of a run as tables: CSV for spreadsheets, JSON for programs. Each says whether the run is final."""

import json

from snowmpm.draft import write_table, write_text
from snowmpm.io.parameters import parameters
from snowmpm.io.projection import projection_name
from snowmpm.io.status import status_of
from snowmpm.quantities.table import quantity


def write_numbers(path, run):
    """Write the numbers of hazard mapping of a `Run` as CSV, each with unit and definition; -> its path."""
    status = status_of(run)
    rows = [["status", "whether the run is final", status.text, "", "Complete, at rest, nothing lost over the edge."]]
    for name, value in run.hazard.get("numbers", {}).items():
        one = quantity(name)
        rows.append([name, one.label, value, "1" if one.unit == "share" else one.unit, one.definition])
    return write_table(path, ["name", "label", "value", "unit", "definition"], rows)


def write_areas(path, run):
    """Write the affected area of a `Run` by classes of each map as CSV; -> its path."""
    status = status_of(run)
    rows = [[name, row["class"], row["from"], "" if row["to"] is None else row["to"], quantity(name).unit, row["area"],
             status.final] for name, classes in run.hazard.get("classes", {}).items() for row in classes]
    return write_table(path, ["map", "class", "from", "to", "unit", "area_m2", "final"], rows)


def write_record(path, run, scores=None):
    """Write everything as JSON: status, numbers with units, areas by class, parameters, scores; -> its path."""
    numbers = {name: {"value": value, "unit": quantity(name).unit, "definition": quantity(name).definition}
               for name, value in run.hazard.get("numbers", {}).items()}
    record = {**status_of(run).record(), "run": run.name, "projection": projection_name(run.provenance.get("crs")),
              "parameters": parameters(run), "numbers": numbers, "areas_by_class": run.hazard.get("classes", {}),
              **({"observed": scores} if scores is not None else {})}
    return write_text(path, json.dumps(record, indent=1) + "\n")
