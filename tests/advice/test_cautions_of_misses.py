"""What is missed by tests and a user can meet is told by `check`; each rule where it applies, and not beside it."""

import pytest

from snowmpm.advice.report import advise
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene
from tests.support.soaked_column import column


def told(scene, key):
    return [caution for caution in advise(scene).cautions if key in caution.key]


@pytest.mark.parametrize(("damping", "warned"), [(0.0, True), (0.3, False)])
def test_water_that_swings_on(damping, warned):
    scene = column(0.1, solver={"implicit": {"time": "newmark", "dt": 1e-2, "damping": damping}},
                   water={"split": "monolithic"})
    assert bool(told(scene, "solver.implicit.damping")) == warned


@pytest.mark.parametrize(("dx", "warned"), [(None, True), pytest.param(0.5, False, marks=pytest.mark.slow)])
def test_a_weak_layer_of_two_cells_rubs(dx, warned):
    """On half the spacing it has four."""
    scene = load_scene("slab_release_resolved")
    if dx:
        scene = load_scene("slab_release_resolved", {"solver.dx": dx * scene.solver.dx})
    rubs = [caution for caution in told(scene, "bodies.") if "rubs as the snow beside it" in caution.says]
    assert bool(rubs) == warned


@pytest.mark.parametrize(("radius", "shared", "warned"), [(0.15, "whole", True), (0.6, "whole", False),
                                                          (0.15, False, False)])
def test_a_press_narrower_than_cells(radius, shared, warned):
    scene = Scene.model_validate({
        "name": "press", "dimension": 2, "end_time": 0.1, "solver": {"dx": 0.1, "f_bar": shared},
        "domain": {"min": [0.0, 0.0], "max": [2.0, 3.0], "boundary": {"z_min": "stick"}},
        "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "block", "material": "snow",
                    "shape": {"kind": "box", "min": [0.5, 0.0], "max": [1.5, 1.0]}}],
        "obstacles": [{"name": "piston", "motion": {"velocity": [0.0, -0.1]},
                       "shape": {"kind": "sphere", "centre": [1.0, 1.05 + radius], "radius": radius}}]})
    assert bool(told(scene, "obstacles.0.shape.radius")) == warned
