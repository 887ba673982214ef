"""Runs that would never end, or end in a full disk, are refused before their first step, with what they would cost."""

import math
import shutil
from pathlib import Path

from snowmpm.advice.budget import Budget
from snowmpm.advice.facts import MOST_PAIRED, SceneFacts
from snowmpm.amounts import large, long_time
from snowmpm.errors import InputError

LONGEST = 30 * 86400.0
"""Expected run time beyond which a run is refused [s]: a month."""
SECONDS_A_BODY = 2e-3
"""Of reading, building and checking a body, about."""


def refuse_unaffordable(simulation, folder, threads=1, option="--accept-cost"):
    """Refuse, by an InputError that says what it would cost, a simulation that would take LONGEST, or more disk than
    is free where `folder` lies.

    simulation: `Simulation` as built, at its start or taken up from a checkpoint: what is left of it counts. option:
    how a user accepts the cost.
    """
    scene = simulation.scene
    budget = Budget(SceneFacts(scene, simulation.model, simulation.solver), threads)
    cost = unaffordable(budget, folder, max(0.0, 1.0 - simulation.time / scene.end_time))
    if cost:
        raise InputError(f"{scene.source}: {cost}; {option} runs it all the same")


def unaffordable(budget, folder, left=1.0):
    """What a run that nobody can pay for would take, in words, and why; None of others. left: share of it to come."""
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
    """What to say of a scene of so many bodies that to build it takes long; None of others."""
    n = len(scene.bodies)
    if n <= MOST_PAIRED:
        return None
    return (f"{n} bodies: to build them takes about {long_time(SECONDS_A_BODY * n)}; how they lie to each other is not"
            " looked at")


def _free_disk(folder):
    there = next(parent for parent in (Path(folder).resolve(), *Path(folder).resolve().parents) if parent.exists())
    usage = shutil.disk_usage(there)
    return usage.free if usage.total else math.inf  # a place without files: writing there says so itself
