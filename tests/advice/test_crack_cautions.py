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


def test_cells_in_which_a_crack_would_snap_back_are_refused():
    with pytest.raises(InputError) as refusal:
        build(block({**CRACKING, "fracture_energy": 0.01}, f_bar="whole")).solver()
    text = str(refusal.value)
    assert "materials.snow" in text and "cells below 0.0021 m" in text and len(text.splitlines()) <= 2


def test_other_words_for_f_bar_are_refused():
    with pytest.raises(ValueError, match=r"f_bar"):
        block(f_bar="half")
