"""What `snowmpm check` says of the library: no warning that a scene does not speak of, and advice that can be followed.

Every saving is followed: the scene with its keys validates, costs as much less as was promised, and is warned of
nothing that the scene was not."""

import functools

import pytest

from snowmpm import load_scene
from snowmpm.advice.refinement import refined, within_reach
from snowmpm.advice.report import advise
from snowmpm.methods import METHODS
from snowmpm.scenes.library import comment, library
from snowmpm.scenes.loader import with_overrides
from snowmpm.scenes.reasons import reasons

LARGE = {"avalanche_on_raster", "column_collapse_3d", "crown_and_flanks", "impact_mast", "microstructure", "pst",
         "slab_release_resolved"}
PROMISED = 0.15
"""Largest error of the share of the run time that is promised to be saved."""


@functools.cache
def advice_on(name):
    return advise(load_scene(name))


def every(mark=pytest.mark.slow):
    return [pytest.param(name, marks=[mark] if name in LARGE else []) for name in sorted(library())]


@pytest.mark.parametrize("name", every())
def test_no_warning_that_the_scene_does_not_speak_of(name):
    warned = {caution.entry or caution.key for caution in advice_on(name).cautions}
    said = " ".join(comment(name))
    spoken_of = {word.strip(":,.`") for word in said.partition("`snowmpm check` warns of")[2].split()}
    assert warned <= spoken_of


@pytest.mark.parametrize("name", every())
def test_every_saving_keeps_what_it_promises(name):
    before = advice_on(name)
    warned = {caution.entry or caution.key for caution in before.cautions}
    for saving in before.savings:
        if not saving.overrides:
            continue
        after = advise(with_overrides(load_scene(name), saving.overrides))
        saved = 1.0 - after.facts["run_time"] / before.facts["run_time"]
        assert saved == pytest.approx(saving.share, abs=PROMISED), saving
        assert {caution.entry or caution.key for caution in after.cautions} <= warned, saving
        assert saving.key not in {again.key for again in after.savings}, saving


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(library()))
def test_fast_and_accurate_take_as_long_as_they_say(name):
    from snowmpm.advice.along_front import faster, more_accurate

    scene = load_scene(name)
    if not METHODS[scene.solver.method].capabilities.presets:
        pytest.skip("--fast and --accurate were not measured for it")
    for alternative, change in zip(advice_on(name).along, (faster(scene), more_accurate(scene)), strict=True):
        after = advise(with_overrides(scene, change.overrides)).facts["run_time"]
        assert after == pytest.approx(alternative.seconds, rel=0.3), alternative.option


def test_no_advice_against_the_scenes_own_reason():
    """A cfl that its comment explains stays, whatever it would save; without the comment it is named."""
    assert "solver.cfl" in reasons(load_scene("skier_trigger").source)
    for name in library():
        explained = reasons(load_scene(name).source)
        if name not in LARGE:
            assert not explained.keys() & {saving.key for saving in advice_on(name).savings}


def test_a_finer_grid_is_advised_only_within_reach():
    from snowmpm.advice.facts import SceneFacts
    from snowmpm.setup.build import build

    scene = load_scene("flow_cold_dense", {"solver.dx": 0.5})
    model = build(scene)
    facts = SceneFacts(scene, model, model.solver())
    assert within_reach(facts, 0.25) and not within_reach(facts, 2e-4)
    seconds, size = refined(facts, 0.25)
    assert seconds < refined(facts, 0.125)[0] and size < refined(facts, 0.125)[1]
