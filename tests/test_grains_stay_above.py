"""A thin flow on curved ground: no grain sinks in, and none is lost through the floor."""

import numpy as np

import snowmpm


def test_no_grain_sinks_into_the_valley():
    """Grains may dip below the surface, by less than half a cell: deeper ones would not come back."""
    scene = snowmpm.load_scene("avalanche_on_raster", {"solver.dx": 3.0})
    simulation = snowmpm.Simulation(scene)
    deepest = []
    while simulation.time < 21.0:
        for _ in range(100):
            simulation.step()
        deepest.append(simulation.model.distance.query(simulation.particles["position"])[0].min())
    assert np.min(deepest) > -0.5 * scene.solver.dx
    assert simulation.solver.particles.removed["count"] == 0
