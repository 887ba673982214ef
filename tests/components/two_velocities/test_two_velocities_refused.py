"""What does not go with water that has a velocity of its own: two lines, with the key."""

import pytest

from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

SCENE = """
name = "slush"
dimension = 2
end_time = 1.0
[solver]
dx = 0.1
precision = "f64"
transfer = "aflip"
[domain]
min = [-2.0, -2.0]
max = [4.0, 2.0]
[terrain]
kind = "plane"
angle = 10.0
contact = "stick"
[materials.snow]
kind = "elastic"
density = 400.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[water]
scheme = "v_w"
permeability = 1e-8
bulk_modulus = 1e6
[[bodies]]
name = "slab"
material = "snow"
shape = { kind = "layer", bottom = 0.0, top = 0.4, region = { x = [0.0, 1.0] } }
"""


@pytest.mark.parametrize(("changes", "key"), [
    ({"water.scheme": ["v_w"]}, "water.scheme"),
    ({"water.scheme": {"a": 1}}, "water.scheme"),
    ({"events": [{"kind": "cut", "body": "slab", "path": [[0.0, 0.0], [1.0, 0.0]]}]}, "events.0.body"),
    ({"water.permeability": 0.0}, "water.permeability"),
    ({"water.permeability": -1e-9}, "water.permeability"),
    ({"water.permeability": {"file": "k.asc"}}, "water.permeability"),
    ({"water.grain_density": 300.0}, "materials.snow.density"),
    ({"materials.snow.density": 950.0}, "materials.snow.density"),
    ({"water.dry": ["slap"]}, "water.dry"),
    ({"water.porosity": 0.5}, "water.porosity"),
    ({"water.table": 0.2, "water.pressure": 1.0}, "water.pressure"),
    ({"water.bulk_modulus": 0.0}, "water.bulk_modulus"),
    ({"solver.transfer": "apic"}, "solver.transfer"),
    ({"solver.precision": "f32"}, "solver.precision"),
    ({"solver.method": "sph"}, "water.scheme"),
    ({"solver.method": "implicit"}, "water.scheme"),
    ({"initial.stress": "geostatic"}, "initial.stress"),
    ({"initial.stress": "isotropic", "initial.pressure": 1e3}, "initial.stress"),
    ({"initial.stress": "settle", "initial.relaxation": "static"}, "initial.relaxation"),
    ({"events": [{"kind": "melt", "energy_flux": 3334.0}]}, 'does not go with water.scheme = "v_w": take "rain" with'
                                                            " rate = 0.01"),
    ({"terrain.contact": "separate", "terrain.friction": {"law": "voellmy", "mu": 0.2, "xi": 1e3}}, "terrain.friction"),
    ({"events": [{"kind": "drainage", "border": "ground", "becomes": "drained"}]}, "events.0.kind"),
])
def test_what_is_refused(changes, key, tmp_path):
    (tmp_path / "slush.toml").write_text(SCENE)
    with pytest.raises(InputError) as refusal:
        Simulation(load_scene(tmp_path / "slush.toml", changes))
    said = str(refusal.value)
    assert key in said and len(said.splitlines()) <= 2, said
