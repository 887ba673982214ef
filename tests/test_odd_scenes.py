"""Scenes at the edge of what makes sense: they run, or are refused with exit code 2 and a reason in a line or two."""

import json

import numpy as np
import pytest

import snowmpm
from snowmpm.cli.app import app
from snowmpm.materials import LAWS
from snowmpm.render import render_history, render_run
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.toml import to_toml

SNOW = {"kind": "cohesive_cam_clay", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "critical_slope": 1.2, "cohesion": 0.3, "hardening": 1.0, "p0": 2e4}
COMMON = {"density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
CRUMBS = {"grain_diameter": 1e-3, "grain_density": 900.0}
SAND = {"youngs_modulus": 1e6, "reference_pressure": 5e3}
EVERY_LAW = {
    "snow": SNOW, "slab": SNOW | {"p0": 1e4}, "weak_layer": {"card": "gaume_weak_layer"},
    "soft": {"kind": "modified_cam_clay", **COMMON, "critical_slope": 0.5, "hardening": 1.0, "p0": 3e3},
    "rubber": {"kind": "elastic", **COMMON}, "clay": {"kind": "von_mises", **COMMON, "yield_stress": 2e3},
    "gum": {"kind": "neo_hookean", **COMMON}, "plate": {"kind": "st_venant_kirchhoff", **COMMON},
    "sand": {"kind": "drucker_prager", **COMMON, "friction_angle": 35.0},
    "loosening": {"kind": "softening_cone", **COMMON, "friction_angle": 37.0, "residual_friction_angle": 30.0,
                  "softening_strain": 0.05, "dilation_angle": 8.0, "dilation_strain": 0.05},
    "grit": {"kind": "mohr_coulomb", **COMMON, "friction_angle": 30.0, "cohesion": 100.0},
    "grains": {"kind": "mu_i", **COMMON, "static_friction": 0.4, "limit_friction": 0.7},
    "loose_grains": {"kind": "mu_phi_i", **COMMON, "density": 500.0, "static_friction": 0.4, "limit_friction": 0.7},
    "wet": {"card": "stomakhin"}, "loose": {"card": "peng_sand", **SAND},
    "dense": {"kind": "critical_state_hypoplastic", "density": 1800.0, **SAND, "poisson_ratio": 0.0,
              "friction_angle": 30.0, "void_ratio": 0.6, "least_void_ratio": 0.4, "critical_void_ratio_limit": 0.9,
              "critical_void_ratio_drop": 0.3, "density_effect": 0.2},
    "fast": {"card": "wu_fast_sand", "youngs_modulus": 1e6, "reference_pressure": 5e3},
    "cracking": {"kind": "cohesive_crack", **COMMON, "strength": 1e3, "fracture_energy": 1.0},
    "slush": {"kind": "wet_snow", **COMMON, "friction_angle": 33.0, "cohesion": 500.0, "water_weakening": 23.5,
              "liquid_water": 0.03},
}


def box(name, lower, upper, material="snow", **more):
    return {"name": name, "material": material, "shape": {"kind": "box", "min": lower, "max": upper}, **more}


def scene(*bodies, **more):
    """A 2-D scene on a flat floor; more: tables that replace its own."""
    return Scene.model_validate({
        "name": "odd", "dimension": 2, "end_time": 0.1, "output": {"interval": 0.05}, "solver": {"dx": 0.1},
        "domain": {"min": [-1.0, -0.5], "max": [2.0, 1.5]}, "terrain": {"kind": "plane", "friction": 0.4},
        "materials": {"snow": SNOW}, "bodies": list(bodies), **more})


def ran(scene, folder):
    """The run of a scene, after checking what any run must keep."""
    run = snowmpm.run(scene, folder)
    last = {name: values[-1] for name, values in run.history.items()}
    assert run.complete and last["momentum_residual"] < 1e-5  # float32
    assert last["mass"] + last["removed_mass"] == pytest.approx(run.history["mass"][0], rel=1e-6)
    assert last["particles"] + last["removed_particles"] == run.history["particles"][0]
    frame = run.frame(-1)
    assert len(frame) == last["particles"] and np.isfinite(frame.points).all()
    assert all(np.isfinite(values).all() for values in frame.fields.values())
    return run


@pytest.fixture
def refused(capsys, tmp_path, monkeypatch):
    """refused(scene) -> the message of `snowmpm run`, after checking that it ends with code 2 and writes nothing."""
    monkeypatch.chdir(tmp_path)

    def invoke(scene):
        (tmp_path / "odd.toml").write_text(to_toml(scene))
        with pytest.raises(SystemExit) as end:
            app(["run", "odd.toml", "-o", "out"])
        message = capsys.readouterr().err
        assert end.value.code == 2 and message.startswith("error: ") and "Traceback" not in message
        assert 1 <= message.count("\n") <= 2 and "odd.toml" in message
        assert not (tmp_path / "out").exists()
        return message

    return invoke


def test_an_avalanche_that_leaves_the_domain(tmp_path):
    """Everything is thrown out through the open side: the run goes on with nothing, can be seen and taken up again."""
    thrown = box("gone", [0.0, 0.3], [0.4, 0.6], velocity=[30.0, 0.0])
    run = ran(scene(thrown, end_time=0.2), tmp_path / "out")
    assert run.history["particles"][0] > 40 and run.history["particles"][-1] == 0
    assert run.history["removed_mass"][-1] == pytest.approx(run.history["mass"][0], rel=1e-6)
    assert len(run.frame(-1)) == 0 and len(run) == 5
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["complete"]
    assert render_run(run, tmp_path / "film.png", size=(320, 180)).is_file()
    assert render_history(run, tmp_path / "history.png", dpi=50).is_file()
    longer = snowmpm.run(scene(thrown, end_time=0.3), tmp_path / "out", resume=True)
    assert longer.complete and longer.history["particles"][-1] == 0 and len(longer) == 7


def test_one_particle(tmp_path):
    """A grain of snow falls freely, then lies on the floor."""
    single = {"dx": 0.1, "particles_per_cell": 1}
    run = ran(scene(box("grain", [0.0, 0.2], [0.1, 0.3]), solver=single), tmp_path / "falls")
    assert run.history["particles"][0] == 1
    assert run.history["momentum_z"][-1] == pytest.approx(-9.81 * 0.1 * run.history["mass"][0], rel=1e-4)
    run = ran(scene(box("grain", [0.0, 0.2], [0.1, 0.3]), solver=single, end_time=1.0), tmp_path / "lies")
    assert run.history["max_speed"][-1] < 0.05
    assert -0.05 < run.frame(-1).points[0, 2] + run.origin[2] < 0.15


@pytest.mark.parametrize("shape", [
    {"kind": "polygon", "points": [[0.0, 0.2], [0.4, 0.2], [0.8, 0.2]]},  # of no area
    {"kind": "polygon", "points": [[0.0, 0.0], [0.02, 0.0], [0.02, 0.4], [0.4, 0.4], [0.4, 0.42], [0.0, 0.42]]},  # thin
])
def test_an_empty_body_beside_others(refused, shape):
    empty = {"name": "sliver", "material": "snow", "shape": shape}
    assert "bodies.1 (sliver)" in refused(scene(box("snow", [0.0, 0.0], [0.4, 0.3]), empty))


@pytest.mark.slow
def test_ten_materials(tmp_path):
    """A row of boxes side by side, each of another material, every law of the library among them."""
    bodies = [box(name, [0.2 * i - 0.9, 0.0], [0.2 * i - 0.7, 0.3], name) for i, name in enumerate(EVERY_LAW)]
    odd = scene(*bodies, materials={name: law | CRUMBS for name, law in EVERY_LAW.items()},
                initial={"stress": "geostatic"}, domain={"min": [-1.0, -0.5], "max": [0.2 * len(bodies) - 0.5, 1.5]},
                output={"interval": 0.05, "fields": ["material", "density", "p", "strain_rate", "inertial_number",
                                                     "flow_regime", "steady_solid_fraction"]})
    assert len(bodies) >= 10 and {law.kind for law in odd.materials.values()} == set(LAWS)
    run = ran(odd, tmp_path)
    fields = run.frame(-1).fields
    assert set(fields["material"].astype(int)) == set(range(len(bodies)))
    for number, name in enumerate(EVERY_LAW):  # each of them tells how fast its grains are sheared
        pressed = (fields["material"] == number) & (fields["p"] > 0.0)
        inertial = (fields["strain_rate"] * 1e-3 * np.sqrt(900.0 / np.maximum(fields["p"], 1e-30)))[pressed]
        np.testing.assert_allclose(fields["inertial_number"][pressed], inertial, rtol=1e-4, err_msg=name)
        regime = 1.0 + (inertial > 1e-3) + (inertial > 0.1)
        assert (fields["flow_regime"][pressed] == np.where(inertial > 0.0, regime, 0.0)).mean() > 0.99
        np.testing.assert_allclose(fields["steady_solid_fraction"][pressed & (fields["flow_regime"] > 0)],
                                   0.6 - 0.1 * np.minimum(inertial[inertial > 0.0], 1.0), rtol=1e-4, err_msg=name)
        assert pressed.sum() > 3, name
    assert run.history["unconverged"][-1] == 0


def test_a_layer_one_cell_thick_slides_down_a_slope(tmp_path):
    layer = {"name": "skin", "material": "snow", "shape": {"kind": "layer", "top": 0.1, "region": {"x": [0.0, 1.0]}}}
    slope = {"kind": "plane", "angle": 35.0, "friction": 0.3}
    run = ran(scene(layer, terrain=slope, domain={"min": [-1.0, -2.5], "max": [3.0, 1.5]}, end_time=0.3,
                    initial={"stress": "geostatic"}), tmp_path)
    pull = 9.81 * (np.sin(np.radians(35.0)) - 0.3 * np.cos(np.radians(35.0)))
    down = np.hypot(run.history["momentum_x"][-1], run.history["momentum_z"][-1]) / run.history["mass"][-1]
    assert down == pytest.approx(0.3 * pull, rel=0.03)


def test_a_body_larger_than_the_domain(refused):
    assert "bodies.0 (snow): reaches outside the domain" in refused(scene(box("snow", [-5.0, 0.0], [5.0, 0.3])))


@pytest.mark.parametrize("contact", ["shared", "separate"])
def test_bodies_that_overlap(tmp_path, contact):
    """Twice the mass in the same place: one body moves; two bodies with contact part."""
    run = ran(scene(box("one", [0.0, 0.0], [0.4, 0.3]), box("other", [0.2, 0.0], [0.6, 0.3], contact=contact)),
              tmp_path)
    assert run.history["mass"][0] == pytest.approx(250.0 * 0.24, rel=1e-6)
    assert run.history["max_speed"].max() < 5.0


def test_particles_on_the_corners_and_sides_of_the_domain(tmp_path):
    """A body that fills the domain from wall to wall, and one that leaves it through its corner."""
    sides = {"x_min": "stick", "x_max": "slip", "z_min": "slip"}
    walls = {"min": [0.0, 0.0], "max": [0.8, 0.8], "boundary": sides}
    run = ran(scene(box("full", [0.0, 0.0], [0.8, 0.4]), domain=walls, terrain=None), tmp_path / "walls")
    assert run.history["removed_particles"][-1] == 0 and run.history["max_speed"][-1] < 0.5
    corner = box("corner", [-1.0, -0.5], [-0.8, -0.3], velocity=[-3.0, -3.0])
    run = ran(scene(corner, terrain=None, end_time=0.4), tmp_path / "corner")
    assert run.history["particles"][-1] == 0


def test_an_obstacle_that_buries_all_snow(refused):
    tomb = {"name": "tomb", "shape": {"kind": "box", "min": [-0.5, -0.2], "max": [0.8, 0.8]}}
    message = refused(scene(box("snow", [0.0, 0.0], [0.4, 0.3]), obstacles=[tomb]))
    assert "bodies.0 (snow): lies wholly inside obstacles" in message
