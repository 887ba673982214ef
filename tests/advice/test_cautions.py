"""`snowmpm check` warns of corners of the atlas, names what cures them, and leaves sound scenes alone."""

import re

import pytest

from snowmpm.advice import refinement
from snowmpm.advice.report import advise
from snowmpm.materials import MuI
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene

SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}


ICE = {**SNOW, "density": 900.0}
CLAY = {**SNOW, "kind": "softening_cone", "friction_angle": 0.0, "residual_friction_angle": 0.0, "cohesion": 1e4,
        "residual_cohesion": 1e3, "softening_strain": 0.1}
FLUFFY, SOFT, HARD = ({**SNOW, "youngs_modulus": E} for E in (5e3, 2e4, 2e7))


def block(solver=None, materials=None, bodies=None, **tables):
    """A scene of an elastic block of 8 x 4 cells on a floor."""
    own = {"name": "block", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.8, 0.4]}}
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": tables.pop("end_time", 1.0),
        "solver": {"dx": 0.1, **(solver or {})},
        "domain": {"min": [-1.0, 0.0], "max": [3.0, 2.0], "boundary": {"z_min": "stick"}},
        "materials": {"snow": SNOW, **(materials or {})}, "bodies": [own, *(bodies or [])], **tables})


def another(lower, upper, material="snow", **keys):
    return {"name": "other", "material": material, "shape": {"kind": "box", "min": lower, "max": upper}, **keys}


def entries(scene):
    return {caution.entry: caution for caution in advise(scene).cautions}


ABOVE = ([0.0, 0.4], [0.8, 0.8])
WALL = {"name": "wall", "shape": {"kind": "box", "min": [2.0, 0.0], "max": [2.1, 1.0]}}
PLATE = {"name": "plate", "foot": [2.0, 0.0], "top": [2.0, 1.5], "width": 0.3, "youngs_modulus": 1e8, "density": 500.0}
STICKY = {**PLATE, "contact": "stick"}
POST = {"name": "post", "joints": {"a": [2.0, 0.0], "b": [2.0, 1.5], "c": [3.0, 0.0]},
        "feet": {"a": "fixed", "c": "fixed"}, "members": [{"ends": ["a", "b"]}, {"ends": ["c", "b"]}],
        "width": 0.3, "youngs_modulus": 1e8, "density": 500.0}
STACK = [{"name": f"block_{i}", "shape": {"kind": "box", "min": [1.5, 0.5 * i], "max": [2.5, 0.5 * (i + 1)]},
          "free": {"density": density}} for i, density in enumerate((400.0, 2e7))]
CORNERS = {  # entry: (scene in the corner, the same scene cured, key named)
    "null_space_noise": (dict(solver={"transfer": "flip", "flip_ratio": 1.0}),
                         dict(solver={"transfer": "aflip", "flip_ratio": 0.97}), "solver.flip_ratio"),
    "damped_waves": (dict(solver={"transfer": "pic"}), dict(solver={"transfer": "aflip"}), "solver.transfer"),
    "lost_spin": (dict(solver={"transfer": "flip", "flip_ratio": 0.95}), dict(solver={"transfer": "apic"}),
                  "solver.transfer"),
    "cell_crossing": (dict(solver={"particles_per_cell": 1, "gradient": "shape"}),
                      dict(solver={"particles_per_cell": 4}), "solver.particles_per_cell"),
    "numerical_fracture": (dict(solver={"particles_per_cell": 1}), dict(solver={"particles_per_cell": 4}),
                           "solver.particles_per_cell"),
    "volumetric_locking": (dict(materials={"snow": {**SNOW, "poisson_ratio": 0.499}}),
                           dict(materials={"snow": {**SNOW, "poisson_ratio": 0.45}}), "materials.snow.poisson_ratio"),
    "stiffness_contrast": (dict(materials={"ice": HARD}, bodies=[another(*ABOVE, "ice")]),
                           dict(materials={"ice": SNOW}, bodies=[another(*ABOVE, "ice")]), "bodies (block and other)"),
    "thin_layer": (dict(materials={"soft": SOFT}, bodies=[another([0.0, 0.4], [0.8, 0.45], "soft")]),
                   dict(materials={"soft": SOFT}, bodies=[another([0.0, 0.4], [0.8, 0.8], "soft")]),
                   "bodies.1 (other)"),
    "early_contact": (dict(bodies=[another([0.95, 0.0], [1.4, 0.4], velocity=[-1.0, 0.0])]),
                      dict(bodies=[another([0.95, 0.0], [1.4, 0.4], velocity=[-1.0, 0.0], contact="separate")]),
                      "bodies (block and other)"),
    "thin_obstacle": (dict(obstacles=[WALL]),
                      dict(obstacles=[{**WALL, "shape": {**WALL["shape"], "max": [2.4, 1.0]}}]), "obstacles.0 (wall)"),
    "few_segments": (dict(structures=[{**PLATE, "segments": 3}]), dict(structures=[PLATE]), "structures.0.segments"),
    "light_structure": (dict(structures=[STICKY]), dict(structures=[{**STICKY, "coupling": "strong"}]),
                        "structures.0.coupling"),
    "few_elements": (dict(structures=[{**POST, "segments": 2}]), dict(structures=[POST]),
                     "structures.0.members.0.segments"),
    "light_framework": (dict(structures=[{**POST, "contact": "stick"}]),
                        dict(structures=[{**POST, "contact": "stick", "coupling": "strong"}]), "structures.0.coupling"),
    "heavy_on_light": (dict(obstacles=STACK), dict(obstacles=[STACK[0], {**STACK[1], "free": {"density": 4000.0}}]),
                       "obstacles.1.free"),
    "sph_pairing": (dict(solver={"method": "sph", "sph": {"kernel": "cubic_spline"}}), dict(solver={"method": "sph"}),
                    "solver.sph.kernel"),
    "sph_free_surface": (dict(solver={"method": "sph", "sph": {"gradient": "plain"}}), dict(solver={"method": "sph"}),
                         "solver.sph.gradient"),
    "sph_tensile": (dict(solver={"method": "sph", "sph": {"disorder_damping": 0.0}}), dict(solver={"method": "sph"}),
                    "materials.snow"),
    "sph_wall": (dict(solver={"method": "sph", "sph": {"barrier": False}}, materials={"snow": FLUFFY}, end_time=2.0),
                 dict(solver={"method": "sph"}, materials={"snow": FLUFFY}, end_time=2.0), "solver.sph.barrier"),
    "sph_layers": (dict(solver={"method": "sph"}, materials={"ice": ICE}, bodies=[another(*ABOVE, "ice")]),
                   dict(solver={"method": "sph", "sph": {"momentum": "volume"}}, materials={"ice": ICE},
                        bodies=[another(*ABOVE, "ice")]), "solver.sph.momentum"),
    "averaging_on_grid": (dict(materials={"snow": {**CLAY, "nonlocal_length": 0.2}}),
                          dict(materials={"snow": {**CLAY, "nonlocal_length": 0.4}}), "materials.snow.nonlocal_length"),
    "small_strains": (dict(gravity=0.0, bodies=[another([0.8, 0.0], [1.2, 0.4], velocity=[1e-7, 0.0])]),
                      dict(gravity=9.81), "solver.precision"),
}


@pytest.mark.parametrize("entry", CORNERS)
def test_a_corner_is_named_with_what_cures_it(entry):
    corner, cured, key = CORNERS[entry]
    found = entries(block(**corner))
    assert found[entry].key == key and found[entry].cure
    assert entry not in entries(block(**cured))


@pytest.mark.parametrize(("kernel", "crosses"), [("linear", True), ("gimp", False), ("quadratic", None)])
def test_a_kernel_of_comparison_is_said_to_be_one(kernel, crosses):
    scene = block({"kernel": kernel, "gradient": "shape", "transfer": "flip"})
    found = advise(scene).cautions
    said = [str(caution) for caution in found if caution.key == "solver.kernel" and not caution.entry]
    if crosses is None:
        assert not said
        return
    assert len(said) == 1 and said[0].startswith(f'solver.kernel: "{kernel}" is for comparison')
    assert ("cell_crossing" in {caution.entry for caution in found}) == crosses


SAND = {"kind": "drucker_prager", "density": 1500.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "friction_angle": 30.0}


def layer_of_sand(dx, sand=None, **solver):
    """A layer of sand, 0.8 m deep normal to a slope, 0.977 m straight up."""
    return Scene.model_validate({
        "name": "sand", "dimension": 2, "end_time": 1.0, "solver": {"dx": dx, **solver},
        "terrain": {"kind": "plane", "angle": 35.0}, "domain": {"min": [0.0, -4.0], "max": [4.0, 2.0]},
        "materials": {"sand": {**SAND, **(sand or {})}},
        "bodies": [{"name": "sand", "material": "sand",
                    "shape": {"kind": "layer", "bottom": 0.0, "top": 0.8, "region": {"x": [1.0, 3.0]}}}]})


def test_friction_that_disturbances_grow_in_is_named():
    """Too deep for its law, too shallow for the grid, and what lies between; with dilation there is no such depth."""
    found = entries(layer_of_sand(0.02))["unstable_friction"]
    assert found.key == "bodies.0 (sand)" and "cfl = 0.1" in found.cure
    for sound in (layer_of_sand(0.025, cfl=0.1), layer_of_sand(0.05), layer_of_sand(0.02, {"dilation_angle": 30.0})):
        assert "unstable_friction" not in entries(sound)


@pytest.mark.parametrize(("diameter", "warned"), [(0.003, True), (0.08, False)])
def test_friction_that_grows_with_the_rate_of_shear_cures_it_for_grains_coarse_enough(diameter, warned):
    scene = layer_of_sand(0.02)
    coarse = MuI(density=1500.0, youngs_modulus=1e6, poisson_ratio=0.3, static_friction=0.5, limit_friction=0.76,
                 grain_diameter=diameter, grain_density=2500.0)
    found = entries(scene.model_copy(update={"materials": {"sand": coarse}}))
    assert ("unstable_friction" in found) == warned


@pytest.mark.parametrize("solver", [{"cfl": 0.1}, {"method": "sph"}])
def test_what_cures_it_on_few_cells_does_not_on_eighty(solver):
    found = entries(layer_of_sand(0.0122, **solver))["unstable_friction"]
    assert "cells is over" in found.says and "fewer cells" in found.cure


def test_no_saving_undoes_a_cure():
    """A cfl of a quarter of the usual one is needless elsewhere, and here it is the cure."""
    assert "solver.cfl" not in {saving.key for saving in advise(layer_of_sand(0.025, cfl=0.1)).savings}
    assert "solver.cfl" in {saving.key for saving in advise(layer_of_sand(0.05, cfl=0.1)).savings}


def hanging_beam(modulus, **solver):
    """A beam of 1 m by 0.1 m that a side holds at one end; modulus [Pa]."""
    return Scene.model_validate({
        "name": "beam", "dimension": 2, "end_time": 1.0, "solver": {"dx": 0.1 / 6, **solver},
        "domain": {"min": [0.0, -1.0], "max": [1.5, 0.5], "boundary": {"x_min": "stick"}},
        "materials": {"rubber": {**SNOW, "density": 1000.0, "youngs_modulus": modulus}},
        "bodies": [{"name": "beam", "material": "rubber",
                    "shape": {"kind": "box", "min": [0.0, -0.05], "max": [1.0, 0.05]}}]})


def test_a_thin_beam_that_bends_far_is_named():
    """qL^3/EI of 5 hangs it by six thicknesses."""
    soft = 2.1e6
    found = entries(hanging_beam(soft, gradient="affine"))["bent_beam"]
    assert found.key == "bodies.0 (beam)" and "cubic" in found.cure
    for sound in (hanging_beam(soft), hanging_beam(20.0 * soft, gradient="affine")):
        assert "bent_beam" not in entries(sound)


def test_the_spacing_that_a_shallow_flow_wants_is_named():
    said = entries(layer_of_sand(0.2))["shallow_flow"].cure
    assert 'transfer = "aflip"' in said and "about" in said
    assert "shallow_flow" not in entries(layer_of_sand(float(re.findall(r"solver.dx = ([\d.]+)", said)[-1])))


def test_a_spacing_that_nobody_can_pay_for_is_called_so(monkeypatch):
    monkeypatch.setattr(refinement, "LONGEST_ADVISED", 0.0)
    monkeypatch.setattr(refinement, "GROWTH", 0.0)
    said = entries(layer_of_sand(0.2))["shallow_flow"].cure
    assert "out of reach" in said and "memory" in said


def test_snow_that_hangs_over_the_end_of_the_ground_has_no_depth():
    """A layer normal to a slope, by its upper end: no vertical from it meets the ground."""
    scene = Scene.model_validate({
        "name": "over", "dimension": 2, "end_time": 1.0, "solver": {"dx": 0.1},
        "domain": {"min": [-3.0, -3.0], "max": [3.0, 6.0]},
        "terrain": {"kind": "profile", "points": [[0.0, 0.0], [2.0, 2.0]]},
        "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "snow", "material": "snow",
                    "shape": {"kind": "layer", "bottom": 0.5, "top": 0.7, "region": {"x": [0.0, 0.2]}}}]})
    assert "shallow_flow" not in {caution.entry for caution in advise(scene).cautions}


def test_layers_of_about_the_same_density_are_left_alone():
    bodies = [another(*ABOVE, "ice")]
    for ratio, named in ((1.3, False), (1.5, True)):
        materials = {"ice": {**SNOW, "density": 300.0 * ratio}}
        assert ("sph_layers" in entries(block(solver={"method": "sph"}, materials=materials, bodies=bodies))) == named


def test_an_interface_below_a_slab_of_few_cells_is_named():
    """Cells of 25 cm under half a metre carry its crack a fifth too slowly, cells of 12.5 cm well enough."""
    for dx, warned in ((0.25, True), (0.125, False)):
        scene = load_scene("pst_2d", {
            "solver.dx": dx, "solver.transfer": "aflip", "materials.weak_layer": {"card": "gaume_weak_layer"},
            "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05, "interface": 8}})
        found = entries(scene)
        assert ("coarse_interface" in found) == warned
        if warned:
            assert "cells over the slab 2 cells" in found["coarse_interface"].says
            assert "solver.dx" in found["coarse_interface"].cure


def test_a_sound_scene_is_left_alone():
    assert advise(block()).cautions == []
