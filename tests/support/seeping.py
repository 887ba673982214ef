"""Scenes of water that seeps through grains at rest, in profile."""

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

DX, POROSITY = 0.1, 0.4
SOIL = {"kind": "elastic", "density": 1600.0, "youngs_modulus": 1e7, "poisson_ratio": 0.0}
WATER = {"scheme": "seepage", "permeability": 1e-7, "grain_density": 1600.0 / 0.6, "bulk_modulus": 1e6}


def tables(size=(0.5, 0.6), tub=(1.0, 1.0), water=None, sides=None, **changes):
    """Tables of a block of soil from the origin, `size` [m] along x and z, in a tub [m]."""
    walls = {**dict.fromkeys(("x_min", "x_max", "z_min"), "slip"), **(sides or {})}
    return {"name": "seepage", "dimension": 2, "end_time": 10.0,
            "solver": {"method": "sph", "dx": DX, "precision": "f64"},
            "domain": {"min": [0.0, 0.0], "max": list(tub), "boundary": walls},
            "materials": {"soil": SOIL}, "water": {**WATER, **(water or {})},
            "bodies": [{"name": "block", "material": "soil",
                        "shape": {"kind": "box", "min": [0.0, 0.0], "max": list(size)}}], **changes}


def seeping(*size, **changes):
    """`Simulation` of `tables`."""
    return Simulation(Scene.model_validate(tables(*size, **changes)))


def wet(simulation):
    """Whether each particle is water."""
    return simulation.particles["material"] == 1
