"""A weak layer through which no crack runs on this grid: said by `check`, before a run, and by its audit."""

import numpy as np
import pytest

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.io import Run, RunWriter
from snowmpm.io.remarks import remarks
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build


def facts(overrides):
    scene = load_scene("slab_release_2d", overrides)
    model = build(scene)
    return SceneFacts(scene, model, model.solver())


COARSER, SET_ANEW = {"solver.dx": 0.1}, {"materials.weak_layer.softening": 3.6}


@pytest.mark.parametrize(("overrides", "said"), [
    ({}, []),
    (COARSER, ["2 cells through a weak layer: once broken", "2 times the 0.05 of the scene's file"]),
    ({"solver.dx": 0.2}, ["1 cells through a weak layer", "4 times the 0.05"]),
    (COARSER | SET_ANEW, ["2 cells through a weak layer: once broken"]),
    ({"solver.dx": 0.05, "end_time": 1.0}, []),
])
def test_what_is_said_of_a_weak_layer(overrides, said):
    told = [str(caution) for caution in cautions(facts(overrides)) if "weak_layer" in caution.key
            and "reference_thickness" not in caution.key]
    assert len(told) == len(said) and all(words in line for words, line in zip(said, told, strict=True))


def test_a_run_prints_it(capsys, tmp_path, monkeypatch):
    from snowmpm.cli.run import simulate

    def run(scene, folder, approve, **_):
        approve(facts(COARSER))
        return folder

    monkeypatch.setattr("snowmpm.run", run)
    simulate(load_scene("slab_release_2d", COARSER), tmp_path, resume=False, quiet=True, accept_cost=True)
    assert "warning: solver.dx (weak_layer): 0.1 is 2 times" in capsys.readouterr().err


@pytest.mark.parametrize(("kind", "fastest", "front", "told"), [
    ("cut", 0.05, 0.0, "The cut at 1 s released nothing"), ("remove", 0.05, 0.0, "The removal at 1 s released nothing"),
    ("cut", 3.0, 0.0, ""), ("cut", 0.05, 12.0, ""), ("load", 0.05, 0.0, ""),
])
def test_a_cut_after_which_nothing_moved_is_named(tmp_path, kind, fastest, front, told):
    scene = f'[[events]]\nkind = "{kind}"\nbody = "weak_layer"\nstart = 1.0\n'
    with RunWriter(tmp_path, provenance={"dx": 0.1, "scene": scene}) as writer:
        for time in (0.0, 1.0, 2.0, 3.0):
            writer.history(time, {"max_speed": fastest * (time == 2.0), "front_distance": front * (time > 2.0)}, {})
        writer.frame(0.0, np.zeros((1, 3)), {})
        writer.close(complete=True)
    found = [line for line in remarks(Run(tmp_path)) if "released nothing" in line]
    assert [line.partition(":")[0] for line in found] == ([told] if told else [])
