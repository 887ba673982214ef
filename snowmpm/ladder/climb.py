"""From rung to rung: the answer of the chosen one, confirmed by the next."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from snowmpm.draft import write_text
from snowmpm.errors import InputError
from snowmpm.ladder.answers import answer_of
from snowmpm.ladder.ladder import Step, next_up
from snowmpm.scenes.loader import with_overrides
from snowmpm.strength.reduction import reduce_strength

ANSWER = "answer.json"
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


def folder_of(name):
    """Name of the folder of a rung's run."""
    return name.replace(", ", "_").replace(" ", "_")


def stand_on(scene, ask, step, folder, simulate):
    """`Answer` of a rung. simulate: (scene, folder) -> `Run`. Raises SimulationError where a run fails."""
    rung, where = step.rung, Path(folder) / folder_of(step.name)
    if rung.answers is not None:
        try:
            return Answer(step, rung.answers().get(ask.question.name), None)
        except InputError as error:
            return Answer(step, None, None, str(error))
    changed = with_overrides(scene, rung.changes)
    if rung.trials:
        return Answer(step, reduce_strength(changed, where, step=STEP).found.slides, where)
    return Answer(step, answer_of(simulate(changed, where), ask), where)


def agree(ask, first, second):
    """Whether two answers differ by no more than was expected of the two."""
    a, b = first.value, second.value
    if a is None or b is None:
        return False
    if ask.question.yes_no:
        return a == b
    if a <= 0.0 or b <= 0.0:
        return a == b
    return abs(math.log(a / b)) <= math.hypot(*(_spread(one.step.expected) for one in (first, second)))


def _spread(expected):
    """Largest ln of an answer over the truth that is expected."""
    return max(-math.log1p(max(expected.low, -0.999)), math.log1p(expected.high))


def climb(scene, ask, ladder, chosen, folder, simulate, budget=None, say=print):
    """`Answer`s from the chosen rung upwards, until two that follow each other agree, or the budget [s] is spent.

    say: called with each answer and each reason to go on."""
    answers, left, step = [], math.inf if budget is None else budget, chosen
    while step is not None and (not answers or step.seconds <= left):
        answers.append(stand_on(scene, ask, step, folder, simulate))
        left -= step.seconds
        say(answers[-1])
        if len(answers) > 1 and agree(ask, *answers[-2:]):
            break
        step = next_up(ladder.steps, step)
    return answers


def write(folder, scene, ask, answers, agreed):
    """answer.json: the question, each rung's answer with its interval, whether the last two agree; -> its path."""
    record = {"scene": scene.name, "question": ask.question.name, "definition": ask.question.says,
              "unit": ask.question.unit, "agreed": agreed,
              "rungs": [{"rung": one.step.name, "value": one.value, "forecast_seconds": one.step.seconds,
                         "expected_error": one.step.expected and asdict(one.step.expected),
                         "run": one.run and one.run.name} for one in answers]}
    return write_text(Path(folder) / ANSWER, json.dumps(record, indent=1))
