"""The ladder of a scene: every rung that it can stand on, with its cost and its expected error, and the choice."""

from dataclasses import dataclass

import numpy as np

from snowmpm import components, memory
from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.refinement import refined
from snowmpm.errors import InputError
from snowmpm.handover.outlook import legs
from snowmpm.ladder.questions import FLOW, RELEASE, REST, SAW, STRENGTH
from snowmpm.ladder.rung import Rung
from snowmpm.measured import models
from snowmpm.measured.models import Expected
from snowmpm.methods import METHODS
from snowmpm.scenes.loader import with_overrides
from snowmpm.scenes.stop import ends_at_rest
from snowmpm.setup.build import build
from snowmpm.setup.refusals import refuse_beyond
from snowmpm.strength.reduction import PERIODS, size_of
from snowmpm.study.presets import FASTER

NEAR = 1.25
"""Ratio to the least expected error up to which another counts as about the same."""
LESS = 0.9
"""Share of the time that counts as less."""
LONGEST = 10.0 * 86400.0
"""Processor time beyond which a rung is left out [s]."""
WITHOUT_RUN = 4.0
"""Processor time of a model without a run that was never measured [s]: imports, terrain."""
TRIALS = 8
"""Runs of a search for a factor of safety, about."""
MOST_BUILT = 100_000
"""Particles of a rung that is built for its forecast; the cost of a finer one follows from that of the one before."""

MOST_FIRST = 5_000_000
"""Particles and cells of the ground of the first rung of a method, beyond which it is left out."""


@dataclass(frozen=True)
class Step:
    """A rung of the ladder of one scene. seconds: processor time of the whole command; memory [bytes], None of a model
    without a run; expected: `Expected` error, None where it was measured in too few problems."""

    rung: Rung
    seconds: float
    memory: float | None
    expected: Expected | None

    @property
    def name(self):
        """Of its rung."""
        return self.rung.name


@dataclass(frozen=True)
class Ladder:
    """steps: `Step`s, cheap to dear; refused: {rung: why the scene cannot stand on it}; own: name of the rung that the
    scene itself stands on, or is nearest to."""

    steps: list[Step]
    refused: dict[str, str]
    own: str

    def step(self, name):
        """The `Step` of this name. Raises InputError."""
        found = next((one for one in self.steps if one.name == name), None)
        if found is None:
            why = self.refused.get(name)
            names = "; ".join([*(one.name for one in self.steps), *self.refused])
            raise InputError(f"--rung {name}: {why}" if why else f"--rung {name}: must be one of {names}")
        return found


def ladder_of(scene, ask, only=None, facts=None):
    """`Ladder` of a scene and a question. only: name of the single rung that is wanted; facts: `SceneFacts` of the
    scene, from which the costs of finer grids are then scaled rather than built. Raises InputError as `build` does."""
    scaled = facts is not None
    facts = facts or (SceneFacts(scene, build(scene), None) if only else _facts(scene))  # a formula needs no solver
    steps, refused = [], {}
    if ask.place is not None and not (np.all(ask.place >= facts.model.lower[:2])
                                      and np.all(ask.place <= facts.model.upper[:2])):
        raise InputError(f"--at {ask.place[0]:g},{ask.place[1]:g}: must lie on the ground of {scene.source}, x"
                         f" {facts.model.lower[0]:g} to {facts.model.upper[0]:g}, y {facts.model.lower[1]:g} to"
                         f" {facts.model.upper[1]:g}")
    # Errors are those of snow and nothing else
    besides = components.used(scene)
    unlike = (ask.question.group == FLOW and bool(besides)) or (ask.question.group == REST and any(
        component.solid for component in besides))
    rungs, own_name = _family(ask.question.group)
    own = own_name(facts, ask.question.group)
    before = {own.partition(",")[0]: facts} if scaled else {}
    for rung in rungs(facts, ask):
        if only and rung.name != only:
            refused.setdefault(rung.name, "")
            continue
        expected = None if rung.unlike or unlike else models.expected_of(models.rows_of(ask.question.name, rung.name))
        if rung.changes is None:
            steps.append(Step(rung, models.seconds_of(rung.name) or WITHOUT_RUN, None, expected))
            continue
        if facts.solver is None:
            facts = SceneFacts(scene, facts.model, facts.model.solver())
        method = rung.name.partition(",")[0]
        try:
            changed = with_overrides(scene, rung.changes)
            refuse_beyond(changed)
            near = before.get(method)
            finer = near.dx / changed.solver.dx if near else 0.0
            if changed.switch or changed.zone:
                seconds, size = _cost_of_two(changed)
            elif finer > 1.0 and (scaled or near.budget.n * finer**near.dim > MOST_BUILT) and not rung.trials:
                seconds, size = refined(near, changed.solver.dx)
            elif _pieces(facts, changed) > MOST_FIRST:
                refused[rung.name] = f"more than {MOST_FIRST / 1e6:g} million cells and particles on its coarsest grid"
                continue
            else:
                seconds, size, built = _cost(changed, rung, _end(before, facts))
                before = {method: built} | before if scaled else before | {method: built}
        except InputError as error:
            refused[rung.name] = str(error).splitlines()[0].removeprefix(f"{scene.source}: ")
            continue
        if size > memory.available():
            refused[rung.name] = "needs more memory than there is"
        elif seconds > LONGEST:
            refused[rung.name] = f"takes more than {LONGEST / 86400.0:g} days"
        else:
            steps.append(Step(rung, seconds, size, expected))
    return Ladder(sorted(steps, key=lambda step: step.seconds), refused, own)


def _pieces(facts, scene):
    """Particles of a scene, and cells over its ground in plan, about: what its set-up grows with."""
    dx, model = scene.solver.dx, facts.model
    snow = float(model.population.volumes.sum()) / dx**scene.dimension * 2**scene.dimension
    if METHODS[scene.solver.method].capabilities.plan:
        snow = 0.0
    return snow + (0.0 if scene.terrain is None else float(np.prod((model.upper - model.lower)[:-1])) / dx ** (
        scene.dimension - 1))


def _end(before, own):
    """When the flow is expected to rest [s], by a method that foretells it: that of the scene, or a rung's. None where
    none does, or the scene does not end at rest."""
    known = [facts for facts in (own, *before.values()) if facts.forecast.course is not None]
    return known[0].forecast.end if known and ends_at_rest(own.scene) else None


def _family(group):
    """(rungs(facts, ask), own_name(facts, group)) of a group of questions; imported when it is asked, since each brings
    much that the others need not."""
    if group == FLOW:
        from snowmpm.ladder import flows

        return flows.rungs, flows.own_name
    if group == SAW:
        from snowmpm.ladder import saw_tests

        return saw_tests.rungs, saw_tests.own_name
    from snowmpm.ladder import rest

    return {STRENGTH: rest.strength_rungs, REST: rest.rest_rungs, RELEASE: rest.release_rungs}[group], rest.own_name


def _cost(scene, rung, end):
    """(seconds, bytes, facts) of a scene, which is built. end [s]: when the run is expected to end, None: at its
    end_time."""
    if rung.trials:
        height, gravity = size_of(scene)
        facts = _facts(with_overrides(scene, {"end_time": PERIODS * (height / gravity) ** 0.5}))
        seconds, size = refined(facts, facts.dx)
        return facts.budget.start + TRIALS * (seconds - facts.budget.start), size, facts
    facts = _facts(scene, end)
    return *refined(facts, facts.dx), facts


def _cost_of_two(scene):
    """(seconds, bytes) of a scene whose snow changes its method, or has two."""
    model = build(scene)
    each = [SceneFacts(leg.scene, leg.model, leg.solver, leg.begin, leg.end) for leg in legs(model, model.solver())]
    seconds, size = zip(*(refined(facts, facts.dx) for facts in each), strict=True)
    return sum(seconds) - sum(facts.budget.start for facts in each[1:]), sum(size)


def _facts(scene, end=None):
    model = build(scene)
    return SceneFacts(scene, model, model.solver(), until=end)


def choose(steps, within=None, budget=None):
    """(`Step`, reason in words) of the cheapest rung whose expected error is `within` [-], of those that take at most
    `budget` [s]; without `within`, and where none is within, the cheapest that has about the least expected error. None
    where no rung has an expected error or is affordable."""
    known = [step for step in steps if step.expected and step.expected.tells]
    affordable = [step for step in known if budget is None or step.seconds <= budget]
    if not affordable:
        return None, (f"every rung takes more than {budget:g} s" if known else
                      "all errors that were measured reach a factor of two" if any(step.expected for step in steps) else
                      "no error was measured for such a scene")
    good = [step for step in affordable if within is not None and step.expected.error <= within]
    if good:
        return min(good, key=lambda step: step.seconds), "the cheapest that is within"
    least = NEAR * min(step.expected.error for step in affordable)
    best = min((step for step in affordable if step.expected.error <= least), key=lambda step: step.seconds)
    whole = "the best that was measured" if budget is None else f"the best within {budget:g} s"
    return best, whole + ("" if within is None else f"; none is within {within:.0%}")


def faster(steps, seconds):
    """The `Step` of least expected error that runs the scene in a third of these `seconds`, or at least in less; None
    where there is none with a measured error."""
    able = [step for step in steps if step.rung.changes is not None and not step.rung.trials
            and step.expected and step.expected.tells]
    for most in (seconds / FASTER, LESS * seconds):
        if quick := [step for step in able if step.seconds <= most]:
            return min(quick, key=lambda step: (step.expected.error, step.seconds))
    return None


def next_up(steps, chosen):
    """The cheapest `Step` beyond `chosen` with less expected error, or about the same; None where there is none."""
    if chosen.expected is None:
        return None
    finer = [step for step in steps if step.expected and step.seconds > chosen.seconds
             and step.expected.error <= NEAR * chosen.expected.error]
    return min(finer, key=lambda step: step.seconds, default=None)
