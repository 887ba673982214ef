"""`snowmpm info`: content and provenance of a run file."""

from snowmpm.cli.options import Json, RunPath
from snowmpm.cli.table import print_facts, print_json
from snowmpm.cli.wording import count, duration, memory, short

LONG = ("scene", "crs")
"""Entries of the provenance that are texts of many lines."""

COST = ("wall_time", "steps", "particle_steps", "ns_per_particle_step", "smallest_dt")
TOLD = ("scene_name", "bodies", "materials", "particles", "wall_time", "complete")
"""Entries of the provenance that other tables show."""


def info(run: RunPath, as_json: Json = False):
    """Print the content and provenance of a run file.

    Frames, fields, history, provenance; also of a run in progress or a killed run.
    """
    from snowmpm.io import Run

    opened = Run(run)
    if as_json:
        print_json(_everything(opened))
        return
    print_facts(_headline(opened), _contents(opened))
    if opened.summary:
        print_facts("\ncost", _cost(opened.summary))
        print_facts("\nat the end", _audit(opened))
    print_avalanche(opened)
    _print_impacts(opened)
    origin = {name: value for name, value in opened.provenance.items() if name not in (*LONG, *TOLD)}
    print_facts("\nmade by", origin)


def print_avalanche(run):
    """Print the numbers of hazard mapping, if the run has them, and whether they are final."""
    from snowmpm.io.published import resolution_of
    from snowmpm.io.status import status_of
    from snowmpm.quantities.resolution import rounded
    from snowmpm.quantities.table import quantity

    if run.hazard:
        status = status_of(run)
        chosen = run.summary.get("friction_class")
        facts = {"friction": f"{chosen}, by the volume of the release"} if chosen else {}
        known = resolution_of(run)
        for name, value in run.hazard["numbers"].items():
            facts[quantity(name).label] = quantity(name).text(rounded(value, known.get(name)), known.get(name))
        print_facts(f"\navalanche, {status.text}", facts)
        print("  (what each of them means: snowmpm maps --definitions)")


def _print_impacts(run):
    from snowmpm.io.impact import impacts
    from snowmpm.quantities.table import quantity

    found = impacts(run)
    for name, one in found.items():
        print_facts(f"\nimpact on {name}", {quantity(number).label: text for number, text in one.texts().items()})
    if found:
        print("  (what each of them means: snowmpm maps --definitions)")


def _headline(run):
    name = run.name
    kind = "3-D" if run.dimension == 3 else "2-D, plane strain"
    state = "complete" if run.complete else "not complete: it goes on, or was stopped"
    return f"{name}: {kind}, {state}"


def _contents(run):
    from snowmpm.io.parameters import method_of, methods_of, succession
    from snowmpm.io.status import cautions, status_of

    times = run.times
    facts = {"file": f"{run.path}, {memory(run.path.stat().st_size)}"}
    if len(run):
        facts["frames"] = f"{count(len(run))}, from {times[0]:g} to {times[-1]:g} s"
        first, last = run.n_points(0), run.n_points(len(run) - 1)
        method = method_of(run)
        name = method.particles if method else "particles"
        facts[name] = count(first) if first == last else f"{count(first)} at first, {count(last)} at last"
    else:
        facts["frames"] = "none yet"
    if methods_of(run):
        facts["methods"] = succession(run)
    facts["bodies"] = list(run.provenance.get("bodies", []))
    facts["materials"] = list(run.provenance.get("materials", []))
    facts["origin [m]"] = [float(x) for x in run.origin]
    # What has no front, as a saw test, may end in motion
    facts["status"] = status_of(run).text if "front" in run.history else " ".join(cautions(run)) or "final"
    facts["fields"] = [_with_unit(run, name) for name in run.field_names]
    facts["history"] = [_with_unit(run, name) for name in run.history]
    if run.terrain is not None:
        facts["terrain"] = f"{count(len(run.terrain.vertices))} vertices, {count(len(run.terrain.facets))} facets"
    if run.maps:
        facts["maps"] = [f"{name} [{raster.units}]" for name, raster in run.maps.items()]
    if run.saw_test:
        test = run.saw_test
        facts["saw test"] = f"{len(test['time'])} rows, {len(test['x'])} bins, crack {test['tip'][-1]:.3g} m long"
    if run.obstacles:
        facts["obstacles"] = [f"{name} ({len(one.time)} rows of loads)" for name, one in run.obstacles.items()]
    return facts


def _cost(summary):
    facts = {}
    if "wall_time" in summary:
        parts = summary.get("wall_time_of", {})
        inner = ", ".join(f"{name} {duration(seconds)}" for name, seconds in parts.items())
        facts["wall time"] = duration(summary["wall_time"]) + (f" ({inner})" if inner else "")
    if "steps" in summary:
        causes = ", ".join(f"{name} {count(n)}" for name, n in summary.get("dt_causes", {}).items())
        facts["steps"] = count(summary["steps"]) + (f" (limited by: {causes})" if causes else "")
    if "smallest_dt" in summary:
        facts["smallest step"] = f"{summary['smallest_dt']:.3g} s"
    if "particle_steps" in summary:
        ns = summary.get("ns_per_particle_step")
        facts["particle-steps"] = short(summary["particle_steps"]) + (f", {ns:.0f} ns each" if ns else "")
    known = {"scene", "complete", "time", "particles", "frames", "last", "hazard", "areas_by_class", "status",
             "wall_time_of", "dt_causes", "methods", *COST}
    made = ("backend", "threads", "precision")
    return {**facts, **{name: value for name, value in summary.items() if name not in known and name not in made}}


def _audit(run):
    """The last row of the history."""
    from snowmpm.quantities.table import RENAMED, quantity, renamed

    last = renamed(run.summary.get("last", {}), RENAMED)
    found = {name: quantity(name, run.units.get(name, ""), run.dimension) for name in last}
    return {found[name].label: found[name].text(value) for name, value in last.items()}


def _everything(run):
    from snowmpm.io.status import status_of

    return {"path": str(run.path), "dimension": run.dimension, "complete": run.complete,
            "status": status_of(run).record(), "times": run.times,
            "particles": [run.n_points(i) for i in range(len(run))], "origin": run.origin, "fields": run.field_names,
            "history": list(run.history), "units": run.units, "maps": list(run.maps),
            "hazard": run.hazard.get("numbers", {}), "obstacles": list(run.obstacles),
            "summary": run.summary, "provenance": run.provenance}


def _with_unit(run, name):
    unit = run.units.get(name, "")
    return f"{name} [{unit}]" if unit else name
