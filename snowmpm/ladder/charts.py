"""A chart for each question: error of each rung against processor time, over all problems, and the front."""

from collections import defaultdict

import numpy as np

from snowmpm.ladder.questions import QUESTIONS
from snowmpm.measured.models import MISSED, expected_of
from snowmpm.render.model_ladder_plot import Rung, render_ladder

LEAST = 1e-3
"""Least error that is drawn."""


def chart(name, rows, output):
    """Draw the rows of a question; -> path."""
    groups = defaultdict(list)
    for row in rows:
        groups[row.rung].append(row)
    rungs = []
    for rung, own in groups.items():
        expected = expected_of(own)
        errors = [float(row.value != row.reference) if row.yes_no else abs(max(row.value / row.reference, MISSED) - 1.0)
                  for row in own]
        rungs.append(Rung(rung, tuple(row.seconds for row in own), tuple(max(one, LEAST) for one in errors),
                          float(np.median([row.seconds for row in own])),
                          None if expected is None else max(expected.error, LEAST)))
    question = QUESTIONS[name]
    what = "chance to be wrong" if question.yes_no else "error that nine of ten answers stay below"
    return render_ladder(rungs, output, title=f"{question.label[0].upper()}{question.label[1:]}: what each model costs"
                         " and misses", y_label=what, problems=len({row.problem for row in rows}))
