"""What does not go with water that seeps through grains at rest: two lines, with the key."""

import pytest

from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

SCENE = """
name = "dam"
dimension = 2
end_time = 1.0
[solver]
method = "sph"
dx = 0.1
precision = "f64"
[domain]
min = [0.0, 0.0]
max = [1.0, 1.0]
boundary = { x_min = "slip", x_max = "slip", z_min = "slip" }
[materials.soil]
kind = "elastic"
density = 1600.0
youngs_modulus = 1e7
poisson_ratio = 0.0
[water]
scheme = "seepage"
permeability = 1e-7
grain_density = 2666.0
[[bodies]]
name = "block"
material = "soil"
shape = { kind = "box", min = [0.0, 0.0], max = [0.5, 0.5] }
"""

PLANE = {"kind": "plane", "angle": 10.0, "contact": "stick"}
ROD = {"name": "post", "shape": {"kind": "box", "min": [0.7, 0.0], "max": [0.8, 0.5]}}


@pytest.mark.parametrize(("changes", "key"), [
    ({"water.permeability": 0.0}, "water.permeability"),
    ({"water.permeability": -1e-9}, "water.permeability"),
    ({"water.permeability": {"file": "k.asc"}}, "water.permeability"),
    ({"water.grain_density": 1500.0}, "materials.soil.density"),
    ({"materials.soil.density": 2700.0}, "materials.soil.density"),
    ({"water.porosity": 0.5}, "water.porosity"),
    ({"water.dry": ["blok"]}, "water.dry"),
    ({"water.bulk_modulus": 0.0}, "water.bulk_modulus"),
    ({"solver.precision": "f32"}, "solver.precision"),
    ({"solver.method": "mpm"}, "water.scheme"),
    ({"initial.stress": "settle"}, "initial.stress"),
    ({"terrain": PLANE}, "terrain.kind"),
    ({"obstacles": [ROD]}, "obstacles.0"),
    ({"domain.boundary.x_max": "stick"}, "domain.boundary.x_max"),
    ({"domain.boundary.x_max": "separate"}, "domain.boundary.x_max"),
    ({"bodies.0.velocity": [1.0, 0.0]}, "bodies.0.velocity"),
    ({"events": [{"kind": "drainage", "border": "ground", "becomes": "drained"}]}, "events.0.kind"),
    ({"events": [{"kind": "melt", "energy_flux": 100.0}]}, "events.0.kind"),
    ({"forces": [{"kind": "pressure", "value": 1e4}]}, "forces.0.kind"),
    ({"damping": {"coefficient": 1.0}}, "damping.coefficient"),
])
def test_what_is_refused(changes, key, tmp_path):
    (tmp_path / "dam.toml").write_text(SCENE)
    with pytest.raises(InputError) as refusal:
        Simulation(load_scene(tmp_path / "dam.toml", changes))
    said = str(refusal.value)
    assert key in said and len(said.splitlines()) <= 2, said
