"""How a scene asks for a layer of points, and what shows that it carries the snow above."""

import numpy as np

import snowmpm
from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def on_points(method):
    """A saw test on cells five times as thick as its weak layer."""
    return Simulation(snowmpm.load_scene("pst_2d", {
        "solver.method": method, "solver.dx": 0.25, "saw_test.length": 1.2, "initial.stress": "geostatic",
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05, "interface": 2}}))


def is_carried(simulation):
    steps(simulation, 5)
    np.testing.assert_allclose(simulation.solver.totals.impulse, -simulation.solver.totals.weight_impulse, rtol=0.1,
                               atol=1.0)


def part(method):
    """What a scene needs for it, beside other components: a layer on the ground under the block."""
    dim, top = given.least_dimension(method), 0.05
    across = {} if dim == 2 else {"y": [0.0, given.SIDE]}
    region = {"region": {"x": [0.0, given.SIDE], **across}}
    layer = {"name": "weak", "material": "weak", "shape": {"kind": "layer", "bottom": 0.0, "top": top, **region},
             "interface": 2}
    slab = {"name": "one", "shape": given.box(dim, (0.0, top), (given.SIDE, top + given.SIDE))}
    return {"terrain": given.ground(method), "solver": {"transfer": "aflip"}, "bodies": [slab, layer],
            "materials": {"weak": {"kind": "elastic", "density": 100.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}}}


ASKED = on_points, is_carried
