"""The factor of safety of a block that hangs from one that does not break (`cohesive_crack`).

What hangs below the middle of a row of cells of height h is borne by that row: it breaks from the factor

    F = f_t / (rho g h)

on, whatever the law around its cracks, as long as that does not yield. The factor found is the first multiple of the
step at which the block falls.
"""

import numpy as np
import pytest

from snowmpm.scenes.schema import Scene
from snowmpm.strength.reduction import reduce_strength

DX, HEIGHT, STEP, OWN = 0.05, 0.9, 0.05, 1.42
SNOW = {"kind": "cohesive_crack", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.0, "fracture_energy": 2.0,
        "strength": OWN * 250.0 * 9.81 * (HEIGHT - 0.5 * DX)}  # fmt: skip
AROUND = {"kind": "drucker_prager", "friction_angle": 30.0, "cohesion": 6e3}
"""Yields, drawn along one axis, at 2.2 times the strength of the cracks."""


def hanging(around):
    """A block of 0.3 m below a strong one of the same width, which the upper side of the domain holds."""
    strong = {**SNOW, "strength": 1e5, "fracture_energy": 1e6}
    snow = {**SNOW, **({"bulk": around} if around else {})}
    box = {"kind": "box", "min": [0.0, 1.0], "max": [0.3, 1.0 + HEIGHT]}
    return Scene.model_validate({
        "name": "hanging", "dimension": 2, "end_time": 1.0, "output": {"interval": 0.5},
        "solver": {"dx": DX, "precision": "f64", "transfer": "aflip", "f_bar": "whole"},
        "domain": {"min": [-0.5, 0.0], "max": [0.8, 1.2 + HEIGHT], "boundary": {"z_max": "stick"}},
        "materials": {"snow": snow, "strong": strong},
        "bodies": [{"name": "block", "material": "snow", "shape": box},
                   {"name": "roof", "material": "strong",
                    "shape": {**box, "min": [0.0, 1.0 + HEIGHT], "max": [0.3, 1.2 + HEIGHT]}}]})


@pytest.mark.slow
@pytest.mark.parametrize("around", [None, AROUND], ids=["elastic", "drucker_prager"])
def test_a_block_stands_below_its_factor_and_falls_above(around, tmp_path):
    reduction = reduce_strength(hanging(around), tmp_path, materials=["snow"], step=STEP, limits=(1.0, 2.0))
    assert reduction.rest_factor == 1.0
    assert reduction.found.slides == pytest.approx(STEP * np.ceil(OWN / STEP)) == pytest.approx(1.45)
    assert reduction.found.stands == pytest.approx(1.4)
    fallen = reduction.found.trial
    assert fallen.strengths["snow.strength"] == pytest.approx(SNOW["strength"] / 1.45)
    if around:
        assert fallen.strengths["snow.bulk.cohesion"] == pytest.approx(6e3 / 1.45)
