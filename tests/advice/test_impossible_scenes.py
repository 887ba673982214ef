"""check says what the cells do not resolve, and what can never happen."""

import pytest

from snowmpm.advice.report import advise
from snowmpm.scenes import Scene, library, load_scene
from snowmpm.scenes.loader import with_overrides
from snowmpm.setup.build import build

SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
PLAIN = {"name": "b", "dimension": 2, "end_time": 0.02, "output": {"interval": 0.01},
         "domain": {"min": [0.0, 0.0], "max": [2.0, 2.0], "boundary": "slip"}, "materials": {"snow": SNOW}}


def told(scene, key):
    """Cautions about a key, as check prints them."""
    return [str(one) for one in advise(scene).cautions if one.key.startswith(key)]


def bodies(*shapes, dx=0.1, **changes):
    return Scene.model_validate(PLAIN | {"solver": {"dx": dx, "precision": "f64"}, "bodies": [
        {"name": f"body_{i}", "material": "snow", "shape": shape} for i, shape in enumerate(shapes)]} | changes)


@pytest.mark.parametrize(("shape", "words"), [
    ({"kind": "box", "min": [0.2, 0.2], "max": [1.8, 0.32]}, "1.1 cells thick: strain across it is one number"),
    ({"kind": "box", "min": [0.2, 0.2], "max": [0.32, 1.8]}, "1.1 cells thick"),
    ({"kind": "box", "min": [0.2, 0.2], "max": [0.25, 0.25]}, "it is smaller than a cell"),
    ({"kind": "sphere", "centre": [1.0, 1.0], "radius": 0.07}, "cells thick: strain across it is one number"),
    ({"kind": "polygon", "points": [[0.2, 0.2], [1.8, 0.2], [1.8, 0.3]]}, "cells thick: strain"),
    ({"kind": "box", "min": [0.2, 0.2], "max": [1.8, 0.4]}, None)])
def test_thin_bodies_of_any_shape(shape, words):
    said = told(bodies(shape), "bodies.0")
    assert bool(said) == (words is not None)
    if words:
        assert words in said[0]
        dx = float(said[0].split("solver.dx = ")[1].split()[0])  # the advice is accepted, and cures
        assert told(bodies(shape, dx=dx), "bodies.0") == []


def test_a_thin_body_on_another_is_resolved_with_it():
    assert told(bodies({"kind": "box", "min": [0.2, 0.0], "max": [1.8, 0.1]},
                       {"kind": "box", "min": [0.2, 0.1], "max": [1.8, 0.8]}), "bodies") == []


def test_one_particle_in_a_cell_larger_than_the_domain():
    said = told(bodies({"kind": "box", "min": [0.2, 0.0], "max": [0.6, 0.4]}, dx=5.0), "bodies.0")
    assert len(said) == 1 and "it is smaller than a cell" in said[0]


@pytest.mark.parametrize(("switch", "why"), [
    ({"when": "t > 50"}, "the scene ends at 40 s"), ({"when": "t > 20"}, None),
    ({"when": "flowing", "speed": 500.0}, "a fall over all of the ground gives"), ({"when": "flowing"}, None),
    ({"when": "reached", "region": {"x": [9000.0, 9100.0], "y": [0.0, 50.0]}}, "its region lies outside the domain"),
    ({"when": "reached", "region": {"x": [600400.0, 600500.0]}}, None)])
def test_switches_that_never_come(switch, why):
    scene = load_scene("avalanche_on_raster", {"end_time": 40.0, "solver.dx": 3.0})
    made = with_overrides(scene, {"switch": [{"to": "depth", "solver": {"dx": 5.0}, **switch}]})
    said = told(made, "switch.0.when")
    assert [why in one for one in said] == ([True] if why else [])


@pytest.mark.parametrize("share", [True, False])
def test_a_dam_on_the_release(share):
    scene = load_scene("avalanche_depth_averaged")
    middle = build(scene).population.positions[:, :2].mean(axis=0)
    x, y = middle if share else (middle[0] + 300.0, middle[1])
    dam = {"name": "dam", "line": [[x, y - 20.0], [x, y + 20.0]], "height": 12.0}
    said = told(with_overrides(scene, {"terrain.dams": [dam]}), "terrain.dams.0")
    assert [one for one in said if "of the snow at the start" in one] == (said if share else []) and bool(said) == share


@pytest.mark.parametrize(("pressure", "says"), [(1e4, False), (1e8, True)])
def test_water_that_compresses_ice(pressure, says):
    scene = bodies({"kind": "box", "min": [0.0, 0.0], "max": [2.0, 1.0]}, water={
        "scheme": "u_p", "permeability": 1e-9, "pressure": pressure})
    assert bool(told(scene, "water.pressure")) == says


@pytest.mark.parametrize("name", library())
def test_no_scene_of_the_library_is_impossible(name):
    words = ("cells thick", "never comes", "of the snow at the start", "compress ice")
    assert not [one for one in advise(load_scene(name)).cautions if any(word in one.says for word in words)]


def test_layers_have_a_rule_of_their_own():
    assert not told(load_scene("avalanche_on_raster"), "bodies.0")


def test_a_house_smaller_than_the_cells_of_a_depth_averaged_flow():
    house = [{"name": "house", "shape": {"kind": "box", "min": [500.0, 300.0, 0.0], "max": [514.0, 312.0, 2000.0]}}]
    scene = load_scene("avalanche_depth_averaged", {"solver.dx": 20.0})
    lower, upper = build(scene).surface.lower, build(scene).surface.upper
    middle = 0.5 * (lower + upper)
    house[0]["shape"] |= {"min": [*(middle[:2] - 7.0), float(lower[2])], "max": [*(middle[:2] + 7.0), float(upper[2])]}
    house[0]["shape"]["min"] = [float(v) for v in house[0]["shape"]["min"]]
    house[0]["shape"]["max"] = [float(v) for v in house[0]["shape"]["max"]]
    for dx, warned in ((20.0, True), (5.0, False)):
        said = told(with_overrides(scene, {"solver.dx": dx, "obstacles": house}), "obstacles.0")
        assert bool(said) == warned


def test_a_density_in_grams_per_cubic_centimetre():
    for density, warned in ((0.2, True), (50.0, False)):
        said = told(bodies({"kind": "box", "min": [0.2, 0.2], "max": [1.8, 1.8]},
                           materials={"snow": {**SNOW, "density": density}}), "materials.snow.density")
        assert bool(said) == warned


def test_what_begins_after_the_end():
    block = {"kind": "box", "min": [0.2, 0.2], "max": [0.8, 0.8]}
    force = {"kind": "acceleration", "value": [0.0, 1.0]}
    for start, warned in ((0.01, False), (5.0, True)):
        said = told(bodies(block, forces=[force | {"start": start}]), "forces.0")
        assert bool(said) == warned and (not said or "never comes" in said[0])
