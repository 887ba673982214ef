"""A crack that spreads over several rows of cells or particles is told."""

import pytest

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build

CRACKING = {"kind": "cohesive_crack", "density": 250.0, "youngs_modulus": 4e6, "poisson_ratio": 0.2, "strength": 4e3,
            "fracture_energy": 1.0}  # fmt: skip


def block(material=CRACKING, **solver):
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": 0.1, "solver": {"dx": 0.05, **solver},
        "domain": {"min": [-1.0, -1.0], "max": [2.0, 2.0]}, "materials": {"snow": material},
        "bodies": [{"name": "block", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0],
                                                                    "max": [0.5, 0.5]}}]})  # fmt: skip


def keys(scene):
    model = build(scene)
    return [one.key for one in cautions(SceneFacts(scene, model, model.solver()))]


@pytest.mark.parametrize(("solver", "told"), [
    ({}, "solver.f_bar"), ({"f_bar": True}, "solver.f_bar"), ({"f_bar": "whole"}, None),
    ({"method": "sph", "dx": 0.025}, "solver.method")])
def test_what_spreads_a_crack_is_named(solver, told):
    found = {"solver.f_bar", "solver.method"} & set(keys(block(**solver)))
    assert found == ({told} if told else set())
    elastic = {name: CRACKING[name] for name in ("density", "youngs_modulus", "poisson_ratio")}
    assert not {"solver.f_bar", "solver.method"} & set(keys(block({"kind": "elastic", **elastic}, **solver)))


@pytest.mark.parametrize(("changes", "told"), [
    ({"reset": True}, "materials.snow.reset"),
    ({"bulk": {"kind": "drucker_prager", "friction_angle": 30.0, "cohesion": 1e3}}, "materials.snow.bulk"),
    ({"bulk": {"kind": "drucker_prager", "friction_angle": 30.0, "cohesion": 1e4}}, None), ({"cracks": 2}, None)])
def test_cracks_that_begin_anew_or_never_are_told(changes, told):
    found = [key for key in keys(block({**CRACKING, **changes}, f_bar="whole")) if key.startswith("materials")]
    assert found == ([told] if told else [])


def test_cells_in_which_a_crack_would_snap_back_are_refused():
    with pytest.raises(InputError) as refusal:
        build(block({**CRACKING, "fracture_energy": 0.01}, f_bar="whole")).solver()
    text = str(refusal.value)
    assert "materials.snow" in text and "cells below 0.0021 m" in text and len(text.splitlines()) <= 2


def test_steps_that_are_solved_for_are_refused():
    with pytest.raises(InputError) as refusal:
        build(block(precision="f64", implicit={"time": "quasi_static"}))
    text = str(refusal.value)
    assert "materials.snow.kind = 'cohesive_crack'" in text and '"implicit"' in text and len(text.splitlines()) <= 2


def test_other_words_for_f_bar_are_refused():
    with pytest.raises(ValueError, match=r"f_bar"):
        block(f_bar="half")
