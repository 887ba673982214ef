"""How a scene asks for an average over a length, and what shows that it acts."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps

CLAY = {"kind": "softening_cone", "density": given.DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "friction_angle": 0.0, "residual_friction_angle": 0.0, "cohesion": 2e3, "residual_cohesion": 1e3,
        "softening_strain": 0.1, "nonlocal_length": 4 * given.SIDE}


def remoulded(method):
    """Clay that loses its strength at a wall, and over a length beyond its own size."""
    dim = given.least_dimension(method)
    lower, upper = given.point(dim, given.SIDE + 0.02, -0.4, -0.4), given.point(dim, given.SIDE + 0.4, 0.8, 0.8)
    return Simulation(given.scene(method, bodies=[given.block(dim, (8.0, 0.0))], materials={"snow": CLAY}, obstacles=[
        {"name": "wall", "shape": {"kind": "box", "min": lower, "max": upper}}]))


def has_lost_strength_everywhere(simulation):
    steps(simulation, 15)
    strain = simulation.particles["plastic_strain"]
    assert 0.5 * strain.max() < strain.min() < strain.max() and simulation.audit()["momentum_residual"] < 1e-11


def part(method):
    """What a scene needs for it, beside other components."""
    return {"materials": {"snow": CLAY}}


ASKED = remoulded, has_lost_strength_everywhere
