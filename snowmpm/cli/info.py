"""`snowmpm info`: what is in a run file, and where it comes from."""

from snowmpm.cli.options import RunPath
from snowmpm.cli.table import print_facts

LONG = ("scene", "crs")
"""What of the provenance is text of many lines."""


def info(run: RunPath):
    """Say what a run file holds, and where it comes from.

    Frames, fields, history, provenance; also of a run that goes on or was killed.
    """
    from snowmpm.io import Run

    opened = Run(run)
    print_facts(str(opened.path), _contents(opened))
    if opened.summary:
        print_facts("summary", {name: value for name, value in opened.summary.items() if name != "hazard"})
    print_avalanche(opened)
    _print_impacts(opened)
    print_facts("provenance", {name: value for name, value in opened.provenance.items() if name not in LONG})


def print_avalanche(run):
    """The numbers of hazard mapping, of a run that has them."""
    from snowmpm.hazard import unit_of

    if run.hazard:
        numbers = run.hazard["numbers"]
        print_facts("avalanche", {f"{name} [{unit_of(name)}]": value for name, value in numbers.items()})


def _print_impacts(run):
    from snowmpm.io.impact import impact

    found = {name: impact(obstacle) for name, obstacle in run.obstacles.items()}
    width = "/m" if run.dimension == 2 else ""
    for name, one in found.items():
        if one:
            print_facts(f"impact on {name}", {
                "arrival [s]": one.arrival, "early peak [Pa]": one.peak, "of the peak [s]": one.peak_time,
                "steady part [Pa]": one.steady, f"impulse [N s{width}]": one.impulse,
                "front [m]" if width else "front [m2]": one.area})


def _contents(run):
    times = run.times
    facts = {"dimension": run.dimension, "complete": run.complete, "frames": len(run)}
    if len(run):
        facts["time [s]"] = f"{times[0]:g} to {times[-1]:g}"
        facts["particles"] = f"{run.n_points(0)} at first, {run.n_points(len(run) - 1)} at last"
    facts["origin [m]"] = [float(x) for x in run.origin]
    facts["fields"] = [_with_unit(run, name) for name in run.field_names]
    facts["history"] = [_with_unit(run, name) for name in run.history]
    if run.terrain is not None:
        facts["terrain"] = f"{len(run.terrain.vertices)} vertices, {len(run.terrain.facets)} facets"
    if run.maps:
        facts["maps"] = [f"{name} [{raster.units}]" for name, raster in run.maps.items()]
    if run.saw_test:
        test = run.saw_test
        facts["saw test"] = f"{len(test['time'])} rows, {len(test['x'])} bins, crack {test['tip'][-1]:.3g} m long"
    if run.obstacles:
        facts["obstacles"] = [f"{name} ({len(one.time)} rows of loads)" for name, one in run.obstacles.items()]
    return facts


def _with_unit(run, name):
    unit = run.units.get(name, "")
    return f"{name} [{unit}]" if unit else name
