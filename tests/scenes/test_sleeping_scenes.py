"""Scenes that ask for sleeping snow: what `check` says, and where it is refused."""

import pytest

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.errors import InputError
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build
from snowmpm.setup.refusals import refuse_beyond
from snowmpm.stepping.calm import calm

BESIDE = {
    "forces": {"forces": [{"kind": "acceleration", "value": ["1.0", "0.0"]}]},
    "damping": {"damping": {"coefficient": 1.0}},
    "bodies with contact": {"bodies.0.contact": "separate"},
    "solver.method": {"solver": {"method": "sph", "dx": 0.02, "sleeping": 0.02}},
}


def scene(**overrides):
    return load_scene("column_collapse_2d", {"solver.sleeping": 0.02, "solver.dx": 0.02, **overrides})


@pytest.mark.parametrize("what", BESIDE)
def test_where_it_is_not_safe_it_is_refused_in_two_lines(what):
    overrides = BESIDE[what]
    asked = load_scene("column_collapse_2d", overrides) if "solver" in overrides else scene(**overrides)
    with pytest.raises(InputError) as refusal:
        refuse_beyond(asked)
    text = str(refusal.value)
    assert "solver.sleeping" in text and what in text and len(text.splitlines()) <= 2


def test_the_usual_is_taken():
    refuse_beyond(scene())
    assert load_scene("column_collapse_2d").solver.sleeping == 0.0


@pytest.mark.parametrize(("share", "warned"), [(0.0, False), (0.02, False), (0.05, True)])
def test_check_warns_of_what_would_sleep_too_soon(share, warned):
    model = build(scene(**{"solver.sleeping": share}))
    facts = SceneFacts(model.scene, model, model.solver(), 0.0, model.scene.end_time)
    assert ("slow_start" in [found.entry for found in cautions(facts)]) == warned
    said = [payment.detail for payment in facts.budget.payments() if payment.what == "sleeping"]
    assert len(said) == (share > 0.0) and all("left out" in text for text in said)


def test_what_counts_as_calm():
    assert calm(0.01, 0.1, [0.0, -9.81]) == pytest.approx((0.01 * 0.981**0.5, (0.1 / 9.81) ** 0.5))
    assert calm(0.01, 0.1, [0.0, 0.0]) == (0.0, float("inf"))
