"""The audit in words: remarks to read before trusting a run."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.parameters import at_rest, method_of
from snowmpm.io.published import experiments
from snowmpm.io.status import cautions
from snowmpm.quantities.powder import DILUTE

MOMENTUM, ENERGY, SPARED = 1e-4, 0.15, 0.05
"""Thresholds of the warnings: shares of momentum, of the energy that was stored and turned over, and of the lines of
contact between two rows of the history."""
PARTED, TORN = 0.05, 0.1
"""Shares of the snow beside emptied cells: of columns in plan, which then no longer push each other, and of particles.
At a border, and between single grains, some always is: up to 9 % in scenes whose results do not depend on it."""
G = 9.81
STILL = 0.25
"""Share of the speed of a fall through half a cell, sqrt(g dx), below which snow that was cut has not been released:
what a cut alone sets in motion reached 0.08 of it."""
RELEASING = {"cut": "cut", "remove": "removal"}
"""Kinds of events that are meant to release snow, in words."""


def remarks(run):
    """Unusual values in the history of a `Run`, one line each."""
    history = {name: values for name, values in run.history.items() if len(values)}
    yield from cautions(run)
    yield from experiments(run)
    density = run.hazard.get("numbers", {}).get("largest_cloud_density_experiment", 0.0)
    if density > DILUTE:
        yield (f"The powder layer reached {density:.0f} kg/m3. Its equations hold for a dilute cloud, up to"
               f" {DILUTE:g} kg/m3 or so.")
    for doubt in run.summary.get("friction_doubts", ()):
        yield f"Friction class {doubt}: another class, or a calibration, fits."
    if _last(history, "momentum_residual") > MOMENTUM:
        yield f"The momentum balance is open by {_last(history, 'momentum_residual'):.2g} of what was exchanged."
    if _last(history, "unconverged") > 0.0:
        yield (f"{_last(history, 'unconverged'):.0f} stress updates did not converge, or had a strain that cannot be"
               " represented; those steps were left out.")
    yield from _settled_by_rule(history)
    # Stored energy counts too: in a run at rest the energy turned over is noise, and any share of it is large
    turned = sum(abs(_last(history, name)) for name in ("plastic_work", "contact_work"))
    turned += sum(_most(history, name) for name in ("kinetic_energy", "elastic_energy"))
    method = method_of(run, last=True)
    in_plan = bool(method and method.capabilities.plan)
    taken = _last(history, "energy_remainder")
    turned += abs(taken)
    # Depth-averaged flow loses energy in its bores, as it should; the work of loads is not counted
    counted = not in_plan and not at_rest(run) and not any(event.get("kind") == "load" for event in _events(run))
    if counted and turned > 0.0 and abs(taken) > ENERGY * turned:
        did = "took" if taken > 0.0 else "added"
        yield (f"The scheme itself {did} {abs(taken) / turned:.1%} of the energy that was stored and turned over: a"
               " finer grid, or a transfer with less damping, changes less.")
    yield from _released_nothing(run, history)
    parted = _last(history, "parted_share")
    if in_plan and parted > PARTED:
        yield (f"{parted:.1%} of the snow lies beside cells in plan that are empty between columns: there the flow is"
               " stretched, and its columns no longer push each other; more solver.particles_per_cell closes it.")
    elif not in_plan and parted > TORN:
        yield (f"{parted:.1%} of the snow lies beside cells that are empty between occupied ones: there it is thinner"
               " than the grid resolves (numerical fracture).")


def _settled_by_rule(history):
    """Lines of contact of implicit steps for which no state was found."""
    lines, spared = (np.asarray(history.get(name, ()), float) for name in ("contact_lines", "contact_spared"))
    if len(lines) < 2 or len(spared) != len(lines):
        return
    gained = np.diff(lines)
    share = np.where(gained > 0.0, np.diff(spared) / np.maximum(gained, 1.0), 0.0)
    if np.nanmax(share) > SPARED:
        time = np.asarray(history["time"], float)[1:][np.nanargmax(share)]
        yield (f"No state of contact was found for {spared[-1]:.0f} of {lines[-1]:.0f} lines of nodes on surfaces, up"
               f" to {np.nanmax(share):.0%} of them before t = {time:g} s: they slid, or were open. Shorter steps"
               " (solver.implicit.dt), or method mpm for an impact.")


def _released_nothing(run, history):
    """Cuts and removals after which no snow went anywhere."""
    time, speed = (np.asarray(history.get(name, ()), float) for name in ("time", "max_speed"))
    dx, events = run.provenance.get("dx"), _events(run)
    if not len(time) or len(speed) != len(time) or not isinstance(dx, int | float):
        return
    limit = STILL * np.sqrt(G * dx)
    for event in events:
        start = event.get("start", 0.0)
        after = time > start
        if event.get("kind") not in RELEASING or not after.any() or _last(history, "front_distance") != 0.0:
            continue
        fastest = float(np.nanmax(speed[after]))
        if fastest < limit:
            yield (f"The {RELEASING[event['kind']]} at {start:g} s released nothing: after it no snow was faster than"
                   f" {fastest:.2g} m/s. `snowmpm check` says whether the weak layer has the cells that it needs; else"
                   " a longer cut, or a weaker layer, lets it go.")


def _events(run):
    """Tables of the events of a run; none of a file that does not hold its scene."""
    try:
        return run.scene.get("events") or ()
    except InputError:
        return ()


def _last(history, name):
    values = history.get(name)
    return float(values[-1]) if values is not None and np.isfinite(values[-1]) else 0.0


def _most(history, name):
    values = np.asarray(history.get(name, ()), float)
    return float(values[np.isfinite(values)].max(initial=0.0))
