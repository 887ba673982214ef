"""What is expected of a model, from the table of errors: interval, share of wrong answers, choice."""

import math

import numpy as np
import pytest
from scipy.stats import t

from snowmpm.ladder.climb import Answer, agree
from snowmpm.ladder.ladder import Step, choose, faster, next_up
from snowmpm.ladder.questions import QUESTIONS, Ask
from snowmpm.ladder.rung import Rung
from snowmpm.measured import models
from snowmpm.measured.models import Expected, Row, expected_of


def rows(errors, unsure=0.0):
    return [Row(f"problem {k}", "run-out", "a rung", 100.0 * math.exp(e), 100.0, unsure, 1.0, 1.0)
            for k, e in enumerate(errors)]


def test_the_interval_is_that_of_another_problem():
    errors = np.array([-0.05, 0.02, 0.04, -0.01])
    found = expected_of(rows(errors))
    half = t.ppf(0.95, 3) * errors.std(ddof=1) * math.sqrt(1.25)
    assert found.low == pytest.approx(math.expm1(errors.mean() - half))
    assert found.high == pytest.approx(math.expm1(errors.mean() + half)) and found.n == 4


def test_nine_of_ten_new_answers_lie_within():
    random, inside = np.random.default_rng(3), 0
    for _ in range(2000):
        *known, new = random.normal(0.1, 0.2, 6)
        found = expected_of(rows(known))
        inside += found.low <= math.expm1(new) <= found.high
    assert inside / 2000 == pytest.approx(0.9, abs=0.02)


def test_what_the_reference_is_known_to_counts():
    same = expected_of(rows([0.0, 0.0, 0.0], unsure=0.05))
    assert same.high == pytest.approx(math.expm1(t.ppf(0.95, 2) * 0.05))


def test_two_problems_tell_nothing():
    assert expected_of(rows([0.0, 0.1])) is None and expected_of([]) is None


def test_a_model_that_misses_all_is_off_by_a_hundred_and_not_by_infinity():
    assert rows([0.0])[0].error == 0.0
    assert Row("p", "load", "r", 0.0, 5.0, 0.0, 1.0, 1.0).error == pytest.approx(math.log(models.MISSED))


def test_yes_and_no_have_a_chance_to_be_wrong():
    said = [Row(f"p{k}", "release", "r", float(k > 0), 1.0, 0.0, 1.0, 1.0, yes_no=True) for k in range(4)]
    assert expected_of(said).error == pytest.approx(2.0 / 6.0)  # one of four


def step(name, seconds, error):
    expected = None if error is None else Expected(-error, error, 5)
    return Step(Rung(name, "", {}), seconds, 1e6, expected)


STEPS = [step("rough", 1.0, 0.45), step("fair", 5.0, 0.12), step("unknown", 6.0, None), step("good", 30.0, 0.06),
         step("best", 400.0, 0.03)]


@pytest.mark.parametrize(("within", "budget", "name"), [
    (0.1, None, "good"), (0.6, None, "rough"), (0.01, None, "best"), (None, 60.0, "good"), (None, None, "best"),
    (0.1, 10.0, "fair"), (0.2, 10.0, "fair")])
def test_the_cheapest_that_is_within_or_the_best_within_the_time(within, budget, name):
    chosen, reason = choose(STEPS, within, budget)
    assert chosen.name == name
    assert ("none is within" in reason) == (within is not None and chosen.expected.error > within)


def test_without_measurements_or_time_there_is_no_choice():
    assert choose(STEPS[2:3], 0.1)[0] is None and choose(STEPS, None, 0.5)[0] is None


def test_the_next_rung_is_dearer_and_better():
    assert next_up(STEPS, STEPS[1]).name == "good" and next_up(STEPS, STEPS[-1]) is None


def test_fast_is_a_third_of_the_time_or_at_least_less_and_still_tells_something():
    assert faster(STEPS, 400.0).name == "good"
    assert faster(STEPS, 20.0).name == "fair"
    assert faster(STEPS, 5.1).name == "rough" and faster(STEPS, 1.0) is None
    wild = Step(Rung("wild", "", {}), 1.0, 1e6, Expected(-0.99, 5.0, 5))
    guess = Step(Rung("guess", "", {}), 1.0, 1e6, Expected(0.4, 0.4, 5, yes_no=True))
    assert faster([wild, guess], 100.0) is None


def test_two_answers_agree_where_their_intervals_have_a_part_in_common():
    ask = Ask(QUESTIONS["run-out"])
    first = Answer(STEPS[1], 100.0, None)
    assert first.between == pytest.approx((100.0 / 1.12, 100.0 / 0.88))
    assert agree(ask, first, Answer(STEPS[3], 110.0, None))
    assert agree(ask, first, Answer(STEPS[3], 113.63 * 1.05, None))
    assert not agree(ask, first, Answer(STEPS[3], 113.64 * 1.07, None))
    assert Answer(STEPS[3], 0.0, None).between is None
    assert not agree(ask, first, Answer(STEPS[3], None, None))
    yes_no = Ask(QUESTIONS["release"])
    assert agree(yes_no, Answer(STEPS[1], 1.0, None), Answer(STEPS[3], 1.0, None))
    assert not agree(yes_no, Answer(STEPS[1], 1.0, None), Answer(STEPS[3], 0.0, None))
