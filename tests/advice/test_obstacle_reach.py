"""Obstacles that snow cannot reach are refused; those too slender for the grid, or mostly buried, are warned of."""

import warnings

import pytest

from snowmpm import Simulation
from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build
from snowmpm.setup.obstacle_reach import doubts

SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}


def box(low, high, **keys):
    return {"name": "house", "shape": {"kind": "box", "min": low, "max": high}, **keys}


def scene(obstacle, points=((0.0, 4.0), (10.0, 0.0), (20.0, 0.0)), **solver):
    """A slope of 10 m by 4 m, flat beyond, to x = 20 m; cells of half a metre."""
    return Scene.model_validate({
        "name": "slope", "dimension": 2, "end_time": 4.0, "solver": {"dx": 0.5, **solver},
        "domain": {"min": [-2.0, -3.0], "max": [25.0, 10.0]},
        "terrain": {"kind": "profile", "points": [list(point) for point in points]}, "materials": {"snow": SNOW},
        "bodies": [{"name": "snow", "material": "snow",
                    "shape": {"kind": "layer", "bottom": 0.0, "top": 1.0, "region": {"x": [1.0, 5.0]}}}],
        "obstacles": [obstacle]})


@pytest.mark.parametrize(("obstacle", "why"), [
    (box([12.0, -2.0], [14.0, -0.5]), "below the ground, which is 0.00 to 0.00 m high there"),
    (box([21.0, 0.0], [23.0, 2.0]), "beside the terrain"),
    (box([30.0, 0.0], [32.0, 2.0]), "outside the domain"),
    (box([12.0, -2.0], [14.0, -0.5], motion={"velocity": [1.0, 0.0]}), "below the ground"),
])
def test_what_snow_cannot_reach_is_refused(obstacle, why):
    with pytest.raises(InputError) as error:
        build(scene(obstacle))
    first, second = str(error.value).splitlines()
    assert first == "slope: obstacles.0 (house): snow cannot reach any of it"
    assert second.startswith("it lies at [") and why in second


def test_what_comes_into_reach_is_not():
    build(scene(box([12.0, -2.0], [14.0, -0.5], motion={"velocity": [0.0, 1.0]})))


def test_a_buried_obstacle_is_warned_of_in_check_and_run():
    buried = scene(box([12.0, -2.5], [15.0, 0.3]))
    said = [caution.says for caution in advise(buried).cautions if caution.key == "obstacles.0 (house)"]
    assert len(said) == 1 and "snow can reach 15% of it" in said[0]
    with pytest.warns(UserWarning, match=r"obstacles\.0 \(house\): snow can reach 15% of it"):
        Simulation(buried)


def test_an_obstacle_too_slender_for_the_grid_is_warned_of_with_the_spacing_it_needs():
    slender = {"name": "mast", "shape": {"kind": "sphere", "centre": [12.0, 0.5], "radius": 0.2}}
    doubt, = doubts(build(scene(slender)))
    assert "0.8 cells across" in doubt.says and doubt.cure == "solver.dx = 0.2 or less"
    assert not list(doubts(build(scene(slender, dx=0.2))))
    wall = box([12.0, -0.2], [12.2, 2.0])  # thin along the flow only: it stops what it should
    assert not list(doubts(build(scene(wall))))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Simulation(scene(wall))
