"""The work of walls: none of it on snow at rest, however many of them meet in a corner."""

import pytest

from tests.components.forcing_and_damping.forced_block import SNOW, run, stage


@pytest.mark.parametrize("ground", ["slip", "stick"])
def test_walls_take_nothing_from_a_column_at_rest(ground):
    height = 0.8
    sim = stage("sph", gravity=9.81, shape={"kind": "box", "min": [0.0, 0.0], "max": [0.4, height]},
                domain={"min": [0.0, 0.0], "max": [0.4, 1.2],
                        "boundary": {"x_min": "slip", "x_max": "slip", "z_min": ground}},
                material={**SNOW, "youngs_modulus": 4e6}, initial={"stress": "geostatic"})
    stored = sim.audit()["elastic_energy"]
    before, after = run(sim, 0.1), run(sim, 0.2)  # the first settles what a lattice is not in balance with
    for name in ("contact_work", "energy_remainder"):
        assert abs(after[name] - before[name]) < 0.04 * stored, name
