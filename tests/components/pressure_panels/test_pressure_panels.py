"""Pressure over the face of an obstacle: exact profiles, balance with the force, and what a run file keeps of it."""

import csv
import io
import signal

import h5py
import numpy as np
import pytest
from PIL import Image

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.panels import panels_of
from snowmpm.render import render_panels, render_report
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_goes_on_alike, run_with_signal

CELL, HEIGHT, DENSITY, POISSON_RATIO = 0.05, 1.0, 1600.0, 0.3
FOOT = POISSON_RATIO / (1.0 - POISSON_RATIO) * DENSITY * 9.81 * HEIGHT
"""Pressure of sand at rest at the foot of a smooth wall [Pa]."""


def at_rest(offset, size, **panels):
    """Sand against a smooth wall whose face lies `offset` cells from a line of the grid."""
    face = offset * CELL
    return Scene.model_validate({
        "name": "thrust", "dimension": 2, "end_time": 0.2, "output": {"interval": 0.1}, "solver": {"dx": CELL},
        "domain": {"min": [-0.5, 0.0], "max": [1.0, 1.5], "boundary": {"x_max": "symmetric", "z_min": "symmetric"}},
        "materials": {"sand": {"kind": "mohr_coulomb", "density": DENSITY, "youngs_modulus": 2e6,
                               "poisson_ratio": POISSON_RATIO, "friction_angle": 30.0}},
        "bodies": [{"name": "fill", "material": "sand",
                    "shape": {"kind": "box", "min": [face, 0.0], "max": [1.0, HEIGHT]}}],
        "obstacles": [{"name": "wall", "shape": {"kind": "box", "min": [-0.4, -0.2], "max": [face, 1.4]},
                       "contact": "slip", "panels": {"size": size, "direction": [-1.0, 0.0], **panels}}],
        "initial": {"stress": "geostatic"}})


def of_weight(low, high):
    """Mean pressure at rest between two heights [Pa]."""
    return FOOT * (np.clip(1.0 - low, 0, None) ** 2 - np.clip(1.0 - high, 0, None) ** 2) / (2.0 * (high - low))


@pytest.mark.parametrize(("offset", "size"), [(0.0, 0.05), (0.5, 0.07), (0.8, 0.2)])
def test_sand_at_rest(offset, size, tmp_path):
    """Wherever the wall lies in the grid, and however the panels lie: 1 % of the pressure at the foot."""
    run = snowmpm.run(at_rest(offset, size, interval=0.05), tmp_path / "run")
    wall = panels_of(run)["wall"]
    edge = wall.edges[1]
    low = np.arange(wall.pressure.shape[1]) * edge
    assert wall.first[1] == 0.0 and len(low) * edge == pytest.approx(1.4)  # what the ground covers has no panels
    np.testing.assert_allclose(wall.pressure[-1][:, 0], of_weight(low, low + edge), atol=0.01 * FOOT)
    obstacle = run.obstacles["wall"]
    given = wall.impulse.sum() * wall.area + wall.force_beside @ wall.spans
    assert given == pytest.approx(-obstacle.impulse[-1][0], rel=1e-6)


def impact(shape=None, **keys):
    """Snow that hits an obstacle on an inclined plane in 3-D."""
    shape = shape or {"kind": "box", "min": [1.75, -0.8, -1.5], "max": [2.5, 0.8, 0.8]}
    return Scene.model_validate({
        "name": "impact", "dimension": 3, "end_time": 0.2, "output": {"interval": 0.1}, "solver": {"dx": 0.2},
        "domain": {"min": [-2.0, -1.0, -2.0], "max": [3.0, 1.0, 2.0]},
        "terrain": {"kind": "plane", "angle": 20.0},
        "materials": {"snow": {"kind": "drucker_prager", "density": 300.0, "youngs_modulus": 1e6,
                               "poisson_ratio": 0.3, "friction_angle": 30.0}},
        "bodies": [{"name": "block", "material": "snow", "velocity": [5.0, 0.0, -1.8],
                    "shape": {"kind": "layer", "bottom": 0.0, "top": 0.6,
                              "region": {"x": [0.6, 1.7], "y": [-0.6, 0.6]}}}],
        "obstacles": [{"name": "wall", "shape": shape,
                       "panels": {"size": 0.4, "direction": [1.0, 0.0, 0.0], "interval": 0.01}}], **keys})


MAST = {"kind": "cylinder", "base": [2.0, 0.0, -1.5], "axis": [0.0, 0.0, 1.0], "radius": 0.4, "height": 2.5}


@pytest.mark.parametrize("shape", [None, MAST], ids=["wall", "mast"])
def test_panels_and_what_is_beside_them_add_up_to_the_force(shape, tmp_path):
    run = snowmpm.run(impact(shape), tmp_path / "run")
    one, obstacle = panels_of(run)["wall"], run.obstacles["wall"]
    given = one.impulse.sum() * one.area + one.force_beside @ one.spans
    assert given == pytest.approx(obstacle.impulse[-1][0], rel=1e-5) and given > 100.0
    assert one.impulse.sum() * one.area > 0.99 * given
    assert one.peak[-1].max() < 0.01 * one.peak.max()  # snow of 0.6 m does not come up here
    assert one.first[1] == pytest.approx(-1.75 * np.tan(np.deg2rad(20.0)), abs=0.4)
    # Alike on both sides of the middle
    np.testing.assert_allclose(one.impulse, one.impulse[:, ::-1], atol=0.05 * one.impulse.max())


def test_it_goes_on_to_the_bit(tmp_path):
    simulation = snowmpm.Simulation(impact())
    while simulation.time < 0.055:
        simulation.step()
    other = assert_goes_on_alike(simulation, 0.12, tmp_path)
    rows = [one.solver.adapters["pressure_panels"].take_series()["face_pressure"]["wall"][1]
            for one in (simulation, other)]
    assert len(rows[0]["time"][0]) >= 11
    for column in rows[0]:
        np.testing.assert_array_equal(rows[0][column][0], rows[1][column][0])


def test_a_run_that_was_killed_has_each_row_once(tmp_path):
    scene = impact()
    whole = panels_of(snowmpm.run(scene, tmp_path / "whole"))["wall"]
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(scene, tmp_path / "cut", signal.SIGINT, 0.13)
    snowmpm.run(scene, tmp_path / "cut", resume=True)
    cut = panels_of(Run(tmp_path / "cut"))["wall"]
    np.testing.assert_array_equal(cut.time, whole.time)
    np.testing.assert_array_equal(cut.pressure, whole.pressure)


def test_pictures_and_tables(tmp_path):
    run = snowmpm.run(impact(), tmp_path / "run")
    picture, table = render_panels(run, tmp_path / "panels.png", time=0.1)
    assert Image.open(picture).width > 1500
    rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
    one = panels_of(run)["wall"]
    assert len(rows) == one.peak.size
    assert max(float(row["peak_pressure_Pa"]) for row in rows) == pytest.approx(one.peak.max(), rel=1e-5)
    assert {float(row["x_m"]) for row in rows} == {1.75}
    page = render_report(run, tmp_path / "page.html", interactive=False)
    assert "Pressure over the face" in page.read_text(encoding="utf-8")
    frame = run.to_pandas("panels")
    assert frame["impulse_Pa_s"].sum() == pytest.approx(one.impulse.sum())
    with pytest.raises(InputError, match=r"time = 9: must be from 0 to 0\.2"):
        render_panels(run, tmp_path / "late.png", time=9.0)
    assert not (tmp_path / "late.png").exists()


@pytest.mark.parametrize(("keys", "said"), [
    ({"motion": {"velocity": [1.0, 0.0, 0.0]}}, "moves"),
    ({"panels": {"size": 1e-3, "direction": [1.0, 0.0, 0.0]}}, "at most 20000 panels"),
    ({"panels": {"size": 0.4, "direction": [0.0, 0.0, 0.0]}}, "zero"),
])
def test_refused(keys, said):
    scene = impact().model_dump(exclude_unset=True)
    scene["obstacles"] = [{**scene["obstacles"][0], **keys}]
    with pytest.raises((InputError, ValueError), match=said):
        snowmpm.Simulation(Scene.model_validate(scene))


def test_a_refusal_names_the_file(tmp_path):
    file = tmp_path / "wall.toml"
    scene = impact().model_dump(exclude_unset=True)
    scene["obstacles"][0]["panels"]["size"] = 1e-3
    file.write_text(Scene.model_validate(scene).to_toml(), encoding="utf-8")
    with pytest.raises(InputError, match=r"wall\.toml: obstacles\.0\.panels\.size = 0\.001: must give at most 20000"):
        snowmpm.Simulation(snowmpm.load_scene(file))


def test_what_check_says():
    scene = impact().model_dump(exclude_unset=True)
    scene["obstacles"][0]["panels"] = {"size": 0.1, "direction": [1.0, 0.0, 0.0], "interval": 1e-4}
    keys = [caution.key for caution in advise(Scene.model_validate(scene)).cautions]
    assert {"obstacles.0.panels.size", "obstacles.0.panels.interval"} <= set(keys)


@pytest.mark.parametrize("harm", ["short", "about", "number", "axes", "far", "empty", "times", "nan", "direction"])
def test_a_changed_file_is_told(harm, tmp_path):
    run = snowmpm.run(at_rest(0.0, 0.2), tmp_path / "run")
    with h5py.File(run.path, "r+") as h5:
        group = h5["series/face_pressure/wall"]
        if harm == "short":
            group["pressure"].resize(1, axis=0)
        elif harm == "about":
            group.attrs["about"] = "[1]"
        elif harm == "number":
            group.attrs["about"] = 1
        elif harm == "empty":
            del group["pressure"]
            group.create_dataset("pressure", (len(group["time"]), 7, 0))
        elif harm == "times":
            group["time"][:] = 0.0
        elif harm == "nan":
            group["pressure"][:] = np.nan
        else:
            change = {"axes": ('"first"', '"last"'), "far": ('"edges": [1.0,', '"edges": [1e308,'),
                      "direction": ("[-1.0, 0.0]", "[NaN, 0.0]")}[harm]
            assert change[0] in group.attrs["about"]
            group.attrs["about"] = group.attrs["about"].replace(*change)
    with pytest.raises(InputError):
        panels_of(Run(run.path))


@pytest.mark.parametrize("joint", [1.0, 1.06])
def test_obstacles_that_touch_have_each_their_own_push(joint, tmp_path):
    """A wall of two boxes, whose joint lies on a line of the grid or beside it."""
    tables = at_rest(0.0, 0.2).model_dump(exclude_unset=True)
    wall = tables["obstacles"][0]
    tables["bodies"][0]["shape"]["max"] = [1.0, 1.3]
    tables["obstacles"] = [{**wall, "name": name, "shape": {"kind": "box", "min": [-0.4, low], "max": [0.0, high]}}
                           for name, low, high in (("low", -0.2, joint), ("high", joint, 1.5))]
    run = snowmpm.run(Scene.model_validate(tables), tmp_path / "run")
    for name, one in panels_of(run).items():
        given = one.impulse.sum() * one.area + one.force_beside @ one.spans
        assert given == pytest.approx(-run.obstacles[name].impulse[-1][0], rel=1e-6)


@pytest.mark.parametrize("interval", [0.07, 1e9])
def test_the_last_mean_ends_with_the_run(interval, tmp_path):
    run = snowmpm.run(at_rest(0.0, 0.2, interval=interval).model_copy(update={"end_time": 0.15}), tmp_path / "run")
    one = panels_of(run)["wall"]
    assert one.time[-1] == pytest.approx(0.15) and one.spans.max() < 0.1 + 1e-9
    given = one.impulse.sum() * one.area + one.force_beside @ one.spans
    assert given == pytest.approx(-run.obstacles["wall"].impulse[-1][0], rel=1e-6)


def test_a_direction_against_the_flow_is_told():
    tables = impact().model_dump(exclude_unset=True)
    tables["obstacles"][0]["panels"]["direction"] = [-1.0, 0.0, 0.0]
    keys = [caution.key for caution in advise(Scene.model_validate(tables)).cautions]
    assert "obstacles.0.panels.direction" in keys
    assert "obstacles.0.panels.direction" not in [caution.key for caution in advise(impact()).cautions]
