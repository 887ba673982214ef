"""Refusal, before the first step, of runs that would take too long or fill the disk; the message gives the cost."""

import math
import shutil
from pathlib import Path

from snowmpm.advice.budget import Budget
from snowmpm.advice.facts import MOST_PAIRED, SceneFacts
from snowmpm.amounts import large, long_time
from snowmpm.errors import InputError
from snowmpm.handover.outlook import legs

LONGEST = 30 * 86400.0
"""Expected run time beyond which a run is refused [s]: a month."""
SECONDS_A_BODY = 2e-3
"""Approximate time of reading, building and checking one body."""


def refuse_unaffordable(simulation, folder, threads=1, option="--accept-cost"):
    """Raise InputError, with the cost, for a simulation that would take longer than LONGEST, or more than the free disk
    space of `folder`.

    simulation: `Simulation`, at its start or resumed from a checkpoint: only the rest of the run counts. option: the
    command-line option that accepts the cost.
    """
    scene, left = simulation.scene, max(0.0, 1.0 - simulation.time / simulation.scene.end_time)
    for facts in _facts(simulation):
        cost = unaffordable(Budget(facts, threads), folder, left)
        if cost:
            raise InputError(f"{scene.source}: {cost}; {option} runs it all the same")


def _facts(simulation):
    """`SceneFacts` of each method of the run, or of a resumed one of that which is at work."""
    relay, solver = simulation.relay, simulation.solver
    scene = simulation.scene
    if not (scene.switch or scene.zone) or relay.index or (scene.zone and solver.steps):
        return [SceneFacts(relay.scene, relay.model, solver)]
    return [SceneFacts(leg.scene, leg.model, leg.solver, leg.begin, leg.end) for leg in legs(relay.model, solver)]


def unaffordable(budget, folder, left=1.0):
    """Cost and reason, in words, of an unaffordable run; None for others. left: remaining share of the run."""
    scene, seconds, disk, free = budget.facts.scene, left * budget.total, left * budget.run_file, _free_disk(folder)
    wanted = []
    if seconds > LONGEST:
        wanted.append(f"about {long_time(seconds)}")
    if disk > free:
        wanted.append(f"{large(disk)} of disk, of which {large(free)} are free")
    if not wanted:
        return None
    return (f"end_time = {scene.end_time:g}, output.interval = {scene.output.interval:g}: would take"
            f" {' and '.join(wanted)}:\n{budget.n} particles, {budget.facts.steps:.3g} steps of"
            f" {scene.end_time / budget.facts.steps:.3g} s, {budget.frames:.3g} frames")


def many_bodies(scene):
    """Warning for a scene with so many bodies that building takes long; None for others."""
    n = len(scene.bodies)
    if n <= MOST_PAIRED:
        return None
    return (f"{n} bodies: to build them takes about {long_time(SECONDS_A_BODY * n)}; how they lie to each other is not"
            " looked at")


def _free_disk(folder):
    there = next(parent for parent in (Path(folder).resolve(), *Path(folder).resolve().parents) if parent.exists())
    usage = shutil.disk_usage(there)
    return usage.free if usage.total else math.inf  # no such folder: the writer reports it
