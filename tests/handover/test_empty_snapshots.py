"""A zone that is still empty when its state is noted for a checkpoint, and holds particles when it is written."""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import Scene

SCENE = {
    "name": "zone", "dimension": 3, "end_time": 5.0, "output": {"interval": 0.5},
    "solver": {"method": "depth", "dx": 1.0},
    "domain": {"min": [0.0, 0.0, -40.0], "max": [60.0, 8.0, 10.0], "boundary": {"y_min": "slip", "y_max": "slip"}},
    "terrain": {"kind": "plane", "point": [0.0, 0.0, 0.0], "angle": 30.0, "friction": 0.2},
    "materials": {"snow": {"kind": "drucker_prager", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
                           "friction_angle": 30.0}},
    "bodies": [{"name": "slab", "material": "snow", "shape": {"kind": "layer", "bottom": 0.0, "top": 1.0,
                                                             "region": {"x": [5.0, 12.0], "y": [0.0, 8.0]}}}],
    "zone": {"region": {"x": [18.0, 30.0], "y": [0.0, 8.0]}, "solver": {"dx": 0.5}},
}


def test_a_snapshot_of_nothing_stays_one(taichi):
    simulation = Simulation(Scene.model_validate(SCENE))
    particles = simulation.solver.inner.particles
    before = particles.snapshot()
    assert len(before.labels) == 0
    while particles.count == 0:
        simulation.step()
    assert before.positions().shape == (0, 3) and np.all(np.isfinite(particles.snapshot().positions()))
