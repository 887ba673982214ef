"""Small scenes with forces, made of numbers."""

from snowmpm.components.forcing_and_damping.declare import IN_TIME
from snowmpm.methods import who_can
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

SNOW = {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e6, "poisson_ratio": 0.0}
FREE = {"min": [-5.0, -8.0], "max": [5.0, 8.0]}
BLOCK = {"kind": "box", "min": [0.0, 0.0], "max": [0.4, 0.4]}
METHODS = [name for name in IN_TIME if name in who_can("dimensions", 2)]


def scene_of(method="mpm", *, dx=0.1, precision="f64", shape=BLOCK, velocity=None, material=SNOW, **keys):
    """Scene of one block in the air without gravity, unless the keys of the scene say otherwise."""
    dim = len(shape["min"])
    free = {axis: ([-5.0, *[-5.0] * (dim - 2), -8.0], [5.0, *[5.0] * (dim - 2), 8.0])[axis == "max"]
            for axis in ("min", "max")}
    return Scene.model_validate({
        "name": "forces", "dimension": dim, "end_time": 10.0, "gravity": 0.0,
        "solver": {"method": method, "dx": dx, "precision": precision}, "domain": free,
        "materials": {"snow": material},
        "bodies": [{"name": "block", "material": "snow", "shape": shape, "velocity": velocity or [0.0] * dim}], **keys})


def stage(method="mpm", **keys):
    """`Simulation` of it."""
    return Simulation(scene_of(method, **keys))


def run(simulation, end_time):
    """Run to `end_time` [s]; -> last row of the audit."""
    while simulation.time < end_time:
        simulation.step(until=end_time)
    return simulation.audit()


def mean_velocity(simulation):
    """Of the mass (dim,) [m/s]."""
    fields = simulation.particles
    return fields["mass"] @ fields["velocity"] / fields["mass"].sum()


def centre(simulation):
    """Of the mass (dim,) [m]."""
    fields = simulation.particles
    return fields["mass"] @ fields["position"] / fields["mass"].sum()
