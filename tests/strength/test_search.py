"""The search for the factor at which something slides."""

import pytest

from snowmpm.errors import InputError
from snowmpm.strength.search import Trial, search


def slope(strength):
    """attempt(factor) of a slope of this factor of safety, and the factors it was asked for."""
    asked = []

    def attempt(factor):
        asked.append(factor)
        return Trial(factor, 0.0, 0.0, factor > strength, f"{factor}")

    return attempt, asked


@pytest.mark.parametrize("strength", [0.31, 0.74, 0.99, 1.0, 1.04, 1.59, 2.0, 4.2])
@pytest.mark.parametrize("step", [0.01, 0.05, 0.1, 0.3])
def test_found_within_a_step(strength, step):
    attempt, asked = slope(strength)
    found = search(attempt, step, 0.1, 6.0)
    assert found.stands <= strength < found.slides and found.slides - found.stands == pytest.approx(step)
    assert len(set(asked)) == len(asked) == len(found.trials) <= 16
    assert found.trial.slides and found.trial.factor == found.slides
    assert all(abs(factor / step - round(factor / step)) < 1e-9 for factor in asked)


def test_limits_are_named():
    for strength, word in ((9.0, r"--to 2: it still stands"), (0.1, r"--from 0\.5: it still slides")):
        attempt, asked = slope(strength)
        with pytest.raises(InputError, match=word):
            search(attempt, 0.1, 0.5, 2.0)
        assert min(asked) >= 0.5 and max(asked) <= 2.0
    attempt, asked = slope(1.75)
    assert search(attempt, 0.1, 1.5, 2.0).slides == pytest.approx(1.8) and min(asked) >= 1.5
