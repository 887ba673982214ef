"""Releases: thickness by number, attribute or raster; several of them; some that go later than others."""

import json
import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.scenes import Scene
from tests.support.same_runs import assert_same, assert_same_runs, run_with_signal

ANGLE, DENSITY = 30.0, 200.0
SQUARE = [[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]]
COLUMNS = {"method": "depth", "dx": 1.0, "particles_per_cell": 9, "depth": {"scheme": "columns"}}
LATER = [[20.0, 5.0], [28.0, 5.0], [28.0, 15.0], [20.0, 15.0]]


def body(top, region, name="one", **more):
    shape = {"kind": "layer", "top": top, **({"region": region} if region else {})}
    return {"name": name, "material": "snow", "shape": shape, **more}


def scene(*bodies, friction=0.2, **changes):
    """Layers on a plane of 60 m."""
    tables = {
        "name": "releases", "dimension": 3, "end_time": 3.0, "output": {"interval": 0.5, "map_cell": 1.0},
        "solver": {"method": "depth", "dx": 1.0, "particles_per_cell": 9},
        "domain": {"min": [0.0, 0.0, -60.0], "max": [60.0, 20.0, 10.0]},
        "terrain": {"kind": "plane", "angle": ANGLE, "friction": friction}, "bodies": list(bodies),
        "materials": {"snow": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        **changes}
    return Scene.model_validate(tables)


def raster(folder, values, cell=1.0, name="depth.asc"):
    """Values (rows, columns), the first row that of the largest y, with the corner at 0, 0."""
    rows, columns = np.shape(values)
    head = f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize {cell}\nNODATA_value -9999\n"
    path = folder / name
    path.write_text(head + "\n".join(" ".join(f"{value:.6g}" for value in row) for row in values) + "\n")
    return {"file": str(path)}


def mass(*bodies):
    return snowmpm.Simulation(scene(*bodies)).audit()["mass"]


def expected(depth_and_area):
    """Mass of thicknesses normal to the ground over areas in plan."""
    return DENSITY * sum(depth * area for depth, area in depth_and_area) / np.cos(np.radians(ANGLE))


def test_each_polygon_of_a_file_has_its_thickness(tmp_path):
    polygons = [{"type": "Feature", "properties": {"thickness": depth},
                 "geometry": {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}}
                for depth, ring in ((0.5, SQUARE), (1.5, LATER))]
    file = tmp_path / "releases.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": polygons}))
    with pytest.warns(UserWarning, match="coordinate system"):
        found = mass(body("file", {"file": str(file)}))
    assert found == pytest.approx(expected([(0.5, 100.0), (1.5, 80.0)]), rel=1e-6)


def test_a_raster_gives_the_thickness(tmp_path):
    """Steps of 0.5 m and 2 m, and cells without data or with 0, which hold no snow: with and without a polygon."""
    values = np.zeros((20, 60))
    values[:, 10:20], values[:, 20:30], values[:, 40:] = 0.5, 2.0, -9999.0
    file = raster(tmp_path, values)
    # Steps lie within columns, 1/3 m wide, which are read at four places across
    step = 1.0 / 3.0 / 4.0
    assert mass(body(file, None)) == pytest.approx(expected([(0.5, 200.0), (2.0, 200.0)]), rel=step / 20.0)
    assert mass(body(file, {"polygon": SQUARE})) == pytest.approx(expected([(0.5, 50.0)]), rel=step / 5.0)
    here = snowmpm.Simulation(scene(body(file, None), solver=COLUMNS)).particles["position"][:, 0]
    assert 10.0 < here.min() < 10.4 and 29.6 < here.max() < 30.0  # over its own ground


@pytest.mark.parametrize(("value", "told"), [(-1.0, "a thickness must be from 0 to 100 m"), (0.0, "no cell with snow")])
def test_a_raster_without_snow_is_refused(tmp_path, value, told):
    values = np.full((20, 60), value)
    values[:, 30:40] = abs(value)
    with pytest.raises(InputError, match=told) as refused:
        snowmpm.Simulation(scene(body(raster(tmp_path, values), None)))
    assert "bodies.0 (one): shape.top.file" in str(refused.value) and len(str(refused.value).splitlines()) <= 2


def test_a_raster_that_misses_the_region_is_refused(tmp_path):
    values = np.zeros((20, 60))
    values[:, 40:] = 1.0
    with pytest.raises(InputError, match="has no snow in the region"):
        snowmpm.Simulation(scene(body(raster(tmp_path, values), {"polygon": SQUARE})))


def delayed(start=1.0, **changes):
    """A slab that goes at once, and one 5 m below it that goes later."""
    return scene(body(1.0, {"polygon": SQUARE}), body(1.0, {"polygon": LATER}, "two", start_time=start), **changes)


def test_a_release_waits_for_its_time():
    """It lies still to the bit, is part of the mass, and then starts with the acceleration of a block."""
    simulation = snowmpm.Simulation(delayed(0.7, solver=COLUMNS))
    second = np.sort(simulation.particles["id"][simulation.particles["body"] == 1])

    def of_second(name):
        fields = simulation.particles
        return fields[name][np.argsort(fields["id"])][second]

    start, whole = of_second("position")[:, :2], simulation.audit()["mass"]
    assert whole == pytest.approx(expected([(1.0, 180.0)]), rel=1e-6)
    while simulation.time < 0.7 - 1e-9:
        simulation.step(0.7)
        if simulation.time < 0.6:
            assert (of_second("position")[:, :2] == start).all() and (of_second("velocity") == 0.0).all()
    assert simulation.audit()["mass"] == pytest.approx(whole, rel=1e-6)
    while simulation.time < 0.8 - 1e-9:
        simulation.step(0.8)
    angle = np.radians(ANGLE)
    gained = np.median(np.linalg.norm(of_second("velocity"), axis=1)[(abs(start[:, 0] - 24.0) < 1.5)])
    assert gained == pytest.approx(9.81 * (np.sin(angle) - 0.2 * np.cos(angle)) * 0.1, rel=0.02)


def test_one_release_is_as_without_the_other_until_they_meet():
    """Far apart, columns of the first move as alone but for round-off, whatever waits below."""
    alone = snowmpm.Simulation(scene(body(1.0, {"polygon": SQUARE}), solver={**COLUMNS, "dt": 0.02}))
    both = snowmpm.Simulation(delayed(2.0, solver={**COLUMNS, "dt": 0.02}))
    for simulation in (alone, both):
        for _ in range(20):
            simulation.step()
    here = both.particles["body"] == 0
    np.testing.assert_allclose(both.particles["position"][here], alone.particles["position"], rtol=0.0, atol=1e-5)


def test_maps_and_history_of_a_delayed_release(tmp_path):
    """Snow that waits is no flow: it arrives when it goes. The release map holds both, and so does the mass."""
    run = snowmpm.run(delayed(1.3), tmp_path / "run")
    x, y = (np.rint(np.array(at)).astype(int) for at in ([10.0, 24.0], [10.0, 10.0]))
    arrival, release = run.maps["arrival_time"].values, run.maps["release_depth"].values
    assert arrival[y[0], x[0]] == 0.0
    # The first slab's front runs 5 m until then, and some of it may be there before
    assert 0.5 < arrival[y[1], x[1] + 3] <= 1.3 + 0.11
    middle = 1.0 / np.cos(np.radians(ANGLE))
    assert release[y[0], x[0]] == pytest.approx(middle, rel=0.02) and release[y[1], x[1]] == pytest.approx(middle, 0.02)
    mass = run.history["mass"] + run.history["removed_mass"]
    np.testing.assert_allclose(mass, mass[0], rtol=1e-6)
    assert np.abs(run.history["momentum_residual"]).max() < 1e-6


def test_a_run_does_not_end_before_its_last_release(tmp_path):
    """The first slab rests at once, on ground that is rough; the second goes at 2 s."""
    run = snowmpm.run(delayed(2.0, friction=0.8, end_time=4.0, stop={"at_rest": True, "hold": 0.1}), tmp_path / "run")
    assert run.times[-1] >= 2.0


@pytest.mark.parametrize("stop", [0.6, pytest.param(1.6, marks=pytest.mark.slow)])
def test_resumed_to_the_bit(tmp_path, stop):
    """Stopped before and after the second release."""
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    snowmpm.run(delayed(), whole)
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(delayed(), parts, signal.SIGTERM, stop)
    run = snowmpm.run(delayed(), parts, resume=True)
    assert_same_runs(whole, parts)
    for name, one in snowmpm.Run(whole).maps.items():
        assert_same(one.values, run.maps[name].values, name)


@pytest.mark.parametrize(("changes", "told"), [
    ({"start_time": 120.0}, r"bodies.0.start_time = 120.0: must be below end_time = 120"),
    ({"start_time": 1.0, "velocity": [1.0, 0.0, 0.0]}, r"bodies.0.start_time = 1.0: does not go with velocity"),
    ({"start_time": -1.0}, "bodies.0.start_time"),
])
def test_a_start_that_cannot_be_is_refused(changes, told):
    with pytest.raises(InputError, match=told) as refused:
        snowmpm.load_scene("avalanche_depth_averaged", {f"bodies.0.{key}": value for key, value in changes.items()})
    assert len(str(refused.value).splitlines()) <= 2


@pytest.mark.parametrize("change", [{"bodies.0.start_time": 1.0}, {"bodies.0.shape.top": {"file": "valley.asc"}}])
def test_other_methods_refuse_them(change):
    with pytest.raises(InputError, match=r'needs solver\.method = "depth"'):
        snowmpm.Simulation(snowmpm.load_scene("avalanche_on_raster", change))
