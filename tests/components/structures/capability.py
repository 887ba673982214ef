"""How a scene asks for a mast, and what shows that the snow bends it."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def against_mast(method, density=1000.0, coupling="weak"):
    """A block thrown at a mast."""
    dim = given.least_dimension(method)
    foot, top = given.point(dim, given.SIDE + 0.14, -0.4, 0.2), given.point(dim, given.SIDE + 0.14, 0.8, 0.2)
    return Simulation(given.scene(method, bodies=[given.block(dim, (8.0, 0.0))], structures=[
        {"name": "mast", "foot": foot, "top": top, "width": 0.2, "youngs_modulus": 1e7, "density": density,
         "coupling": coupling}]))


def bends_it(simulation):
    steps(simulation, 30)
    row = simulation.audit()
    # Struck below its middle: it bends, and its top lags behind
    assert row["mast_largest_moment"] > 1.0 and row["structure_energy"] > 0.1
    assert row["momentum_residual"] < 1e-11 and row["structure_momentum_residual"] < 1e-9


def part(method):
    """What a scene needs for it, beside other components: a mast on the left of the block."""
    dim = given.least_dimension(method)
    foot, top = given.point(dim, -0.14, 0.0, 0.2), given.point(dim, -0.14, 0.8, 0.2)
    return {"structures": [{"name": "mast", "foot": foot, "top": top, "width": 0.2, "youngs_modulus": 1e7,
                            "density": 1000.0}]}


ASKED = against_mast, bends_it
