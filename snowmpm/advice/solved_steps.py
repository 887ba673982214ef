"""Whether steps that are solved for would be cheaper than those of waves, or dearer."""

import numpy as np

from snowmpm import components
from snowmpm.errors import InputError
from snowmpm.measured.explicit_or_implicit import in_words
from snowmpm.methods import METHODS
from snowmpm.scenes.loader import with_overrides
from snowmpm.setup.build import build
from snowmpm.setup.refusals import refuse_beyond

SWINGS = 10.0
"""Slowest swings of a body in the time between two frames, from which on a scene counts as slow."""
SOLVED = next(name for name, entry in METHODS.items() if entry.capabilities.solves)
"""Name of the method whose steps are solved for."""
EXPLICIT = next(name for name, entry in METHODS.items() if entry.relax)
"""Name of the explicit method on the same grid."""


def slowest_swing(facts):
    """Period [s] of a body that swings as a column of its longest extent, or, if slender, as a cantilever."""
    found = 0.0
    for body in range(len(facts.scene.bodies)):
        long, thick = facts.extent(body), min(facts.thickness(body), facts.extent(body))
        found = max(found, 4.0 * long * facts.dx / facts.law(body).wave_speed() * max(1.0, 1.5 * long / thick))
    return found


def slow(facts):
    """Whether a scene is at rest but for forces that change, with frames far longer than its swings, and holds
    together."""
    scene = facts.scene
    if scene.solver.method != EXPLICIT or not scene.forces or scene.events or scene.saw_test or facts.start_speed > 0.0:
        return False
    if any(law.BONDS is not None or not law.tensile_strength > 0.0 for law in facts.model.laws):
        return False
    return bool(scene.output.interval > SWINGS * slowest_swing(facts))


def other_steps(facts):
    """(overrides, facts, what it means, in words) of the other kind of steps for a scene, where it can have them."""
    if found := in_solved_steps(facts):
        overrides, other = found
        swings = facts.scene.output.interval / slowest_swing(facts)
        yield overrides, other, (
            f'"{SOLVED}", with solver.implicit.time = "quasi_static" and precision "f64": a frame lasts {swings:.2g} of'
            f" the slowest swings, so that {other.steps:.0f} balances do for {facts.steps:.0f} steps, if the loads"
            f" change no faster than the frames ({in_words('slow_loading')}; `snowmpm docs implicit`). Lost:"
            " swings and waves")
    if found := in_explicit_steps(facts):
        overrides, other = found
        cells = wave_cells(facts)
        yield overrides, other, (
            f'"{EXPLICIT}", without solver.implicit: {other.steps:.0f} steps of waves are cheaper than'
            f" {facts.steps:.0f} that are solved for, in which a wave crosses {cells:.2g} cells; those pay from about"
            f" {cells * facts.budget.total / other.budget.total:.1g} cells on ({in_words('column')};"
            " `snowmpm docs implicit`)")


def in_solved_steps(facts):
    """Overrides that solve for the steps of a slow scene, with its facts; None where it is not, or cannot be."""
    if not slow(facts):
        return None
    return _other(facts, {"solver.method": SOLVED, "solver.precision": "f64",
                          "solver.implicit": {"time": "quasi_static"}})


def in_explicit_steps(facts):
    """Overrides that follow the waves of a scene in time that solves for its steps, with its facts; None where it is no
    such scene, or cannot be."""
    scene = facts.scene
    if scene.solver.method != SOLVED or scene.solver.implicit.time != "newmark" or _of_implicit(scene):
        return None
    return _other(facts, {"solver.method": EXPLICIT, "solver.implicit": None})


def _of_implicit(scene):
    """Whether a component acts by a key of steps that are solved for."""
    return any(key.startswith("solver.implicit.") for component in components.used(scene)
               for key, _ in component.asked(scene))


def wave_cells(facts):
    """Cells that a wave crosses in a step."""
    return float(facts.end / facts.steps * facts.wave_speed / facts.dx)


def _other(facts, overrides):
    from snowmpm.advice.facts import SceneFacts

    try:
        scene = with_overrides(facts.scene, overrides)
        refuse_beyond(scene)
        model = build(scene)
        other = SceneFacts(scene, model, model.solver())
    except InputError:
        return None
    return (overrides, other) if np.isfinite(other.budget.total) else None
