"""What a scene may not ask of the depth-averaged method: two lines at most, with key, value and what is allowed."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene

WALL = {"name": "wall", "shape": {"kind": "box", "min": [40.0, 0.0, 0.0], "max": [42.0, 20.0, 5.0]}}
LOAD = {"kind": "load", "body": "release", "force": [0.0, 0.0, -10.0]}
CUT = {"kind": "cut", "body": "release", "path": [[4.0, 6.0, 20.0], [8.0, 6.0, 18.0]]}
RASTER = {"law": "voellmy", "mu": {"file": "none.asc"}, "xi": 1000.0}


def plane(**changes):
    """A sheet on a plane of 20 degrees."""
    tables = {
        "name": "sheet", "dimension": 3, "end_time": 1.0, "output": {"interval": 0.5},
        "solver": {"method": "depth", "dx": 2.0},
        "domain": {"min": [0.0, 0.0, -60.0], "max": [60.0, 20.0, 40.0]},
        "terrain": {"kind": "plane", "point": [0.0, 0.0, 20.0], "angle": 20.0, "friction": 0.2},
        "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "release", "material": "snow", "shape": {
            "kind": "layer", "bottom": 0.0, "top": 1.0,
            "region": {"polygon": [[4.0, 4.0], [16.0, 4.0], [16.0, 16.0], [4.0, 16.0]]}}}]}
    for key, value in changes.items():
        table, _, name = key.partition("__")
        if name:
            tables[table] = {**tables[table], name: value}
        elif value is None:
            del tables[table]
        else:
            tables[table] = value
    return Scene.model_validate(tables)


@pytest.mark.parametrize(("changes", "key"), [
    ({"obstacles": [{**WALL, "motion": {"velocity": [1.0, 0.0, 0.0]}}]}, "obstacles.0.motion"),
    ({"events": [LOAD]}, "events.0.kind"),
    ({"events": [CUT]}, "events.0.kind"),
    ({"terrain__contact": "stick"}, "terrain.contact"),
    ({"domain__boundary": "stick"}, "domain.boundary"),
    ({"domain__boundary": {"x_min": "separate"}}, "domain.boundary.x_min"),
    ({"gravity": [1.0, 0.0, -9.81]}, "gravity"),
    ({"initial": {"stress": "settle"}}, "initial.stress"),
    ({"initial": {"stress": "isotropic", "pressure": 1e3}}, "initial.stress"),
    ({"terrain": None, "domain__boundary": "slip", "bodies": [{"name": "release", "material": "snow", "shape": {
        "kind": "box", "min": [4.0, 4.0, 0.0], "max": [16.0, 16.0, 1.0]}}]}, "terrain"),
    ({"terrain__friction": RASTER}, "terrain.friction.mu.file"),
])
def test_what_it_cannot_do_is_refused(changes, key):
    with pytest.raises(InputError, match=key.replace(".", r"\.")) as refused:
        snowmpm.Simulation(plane(**changes))
    assert (len(str(refused.value).splitlines()) <= 2 and "depth" in str(refused.value)) or "no such file" in str(
        refused.value)


def test_a_release_outside_the_terrain_is_refused():
    with pytest.raises(InputError, match="release") as refused:
        snowmpm.Simulation(snowmpm.load_scene("avalanche_depth_averaged", {
            "bodies.0.shape.region": {"polygon": [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]}, "bodies.0.shape.top": 1.0}))
    assert "off the terrain" in str(refused.value)


def test_snow_that_leaves_the_terrain_is_counted(tmp_path):
    """Down the plane and over its open lower side; what is gone and what is left are the release."""
    for scheme in ("columns", "volumes"):
        run = snowmpm.run(plane(end_time=12.0, output={"interval": 4.0}, solver={
            "method": "depth", "dx": 2.0, "depth": {"scheme": scheme}}), tmp_path / scheme)
        mass, gone = run.history["mass"], run.history["removed_mass"]
        assert gone[-1] > 0.5 * mass[0]
        assert mass + gone == pytest.approx(mass[0], rel=1e-6)
        assert run.history["momentum_residual"][-1] < 1e-5
        if scheme == "columns":
            assert run.history["removed_particles"][-1] + run.history["particles"][-1] == run.history["particles"][0]


def test_a_frame_holds_the_depth(tmp_path):
    """Of a sheet at rest, its thickness normal to the ground, 6 % less than the vertical one; of other methods, zero.
    A release is whole rows of columns: these 26 are 1.8 % longer than the polygon, and so much thinner."""
    run = snowmpm.run(plane(end_time=0.1, output={"interval": 0.1}, terrain__friction=0.8, solver__dx=1.0), tmp_path)
    frame = run.frame(0)
    middle = (abs(frame.points[:, :2] + run.origin[:2] - 10.0) < 3.0).all(axis=1)
    assert frame.fields["depth"][middle].mean() == pytest.approx(12.0 / (26 * 0.5 * np.cos(np.radians(20.0))), rel=2e-3)
    other = snowmpm.Simulation(plane(solver={"method": "mpm", "dx": 1.0}))
    assert (other.particles["depth"] == 0.0).all() and len(other.particles["depth"])
