"""From rung to rung: the answer of the chosen one, confirmed by the next."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.ladder.answers import answer_of
from snowmpm.ladder.ladder import Step, next_up
from snowmpm.scenes.loader import with_overrides
from snowmpm.strength.reduction import reduce_strength

ANSWER = "answer.json"
LOWEST = -0.99
"""Relative error below which an answer says nothing of the truth."""
STEP = 0.02
"""Resolution of a factor of safety."""


@dataclass(frozen=True)
class Answer:
    """One rung's answer to a question. value: None where the model gives none, for the reason why; run: folder of its
    run, or None."""

    step: Step
    value: float | None
    run: Path | None
    why: str = ""

    @property
    def between(self):
        """(low, high) between which the truth is expected in nine of ten cases; None where no error was measured, the
        answer is 0, or one of yes and no."""
        expected = self.step.expected
        if expected is None or expected.yes_no or not self.value:
            return None
        return self.value / (1.0 + expected.high), self.value / (1.0 + max(expected.low, LOWEST))


def folder_of(name):
    """Name of the folder of a rung's run."""
    return name.replace(", ", "_").replace(" ", "_")


def stand_on(scene, ask, step, folder, simulate):
    """`Answer` of a rung. simulate: (scene, folder) -> `Run`."""
    rung, where = step.rung, Path(folder) / folder_of(step.name)
    if rung.answers is not None:
        try:
            return Answer(step, rung.answers().get(ask.question.name), None)
        except InputError as error:
            return Answer(step, None, None, str(error))
    changed = with_overrides(scene, rung.changes)
    try:
        if rung.trials:
            return Answer(step, reduce_strength(changed, where, step=STEP).found.slides, where)
        return Answer(step, answer_of(simulate(changed, where), ask), where)
    except SimulationError as error:
        return Answer(step, None, None, str(error))


def agree(ask, first, second):
    """Whether the intervals of two answers have a part in common; of yes and no whether they are the same."""
    if first.value is None or second.value is None:
        return False
    if ask.question.yes_no or min(first.value, second.value) <= 0.0:
        return first.value == second.value
    (low, high), (least, most) = first.between, second.between
    return low <= most and least <= high


def climb(scene, ask, ladder, chosen, folder, simulate, budget=None, say=print):
    """`Answer`s from the chosen rung upwards, until two that follow each other agree, or the budget [s] is spent.

    say: called with each answer. Raises SimulationError where no rung gives one."""
    answers, left, step = [], math.inf if budget is None else budget, chosen
    while step is not None and (not answers or step.seconds <= left):
        answers.append(stand_on(scene, ask, step, folder, simulate))
        left -= step.seconds
        say(answers[-1])
        known = [one for one in answers if one.value is not None]
        if len(known) > 1 and agree(ask, *known[-2:]):
            break
        step = next_up(ladder.steps, step)
    if all(one.value is None for one in answers):
        raise SimulationError("; ".join(f"{one.step.name}: {one.why or 'gives no answer'}" for one in answers))
    return answers


def write(folder, scene, ask, answers, agreed):
    """answer.json: the question, each rung's answer with its interval, whether the last two agree; -> its path."""
    record = {"scene": scene.name, "question": ask.question.name, "definition": ask.question.says,
              "unit": ask.question.unit, "agreed": agreed,
              "rungs": [{"rung": one.step.name, "value": one.value, "forecast_seconds": one.step.seconds,
                         "expected_error": one.step.expected and asdict(one.step.expected),
                         "between": one.between, "why": one.why, "run": one.run and one.run.name} for one in answers]}
    return write_text(Path(folder) / ANSWER, json.dumps(record, indent=1))
