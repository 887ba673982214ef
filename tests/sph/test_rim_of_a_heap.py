"""Grains at the rim of a heap that collapses, by SPH beside MPM."""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="99 % of the sand within 1.72 m (MPM: 1.44), single grains at 2.27 m (1.62)")
def test_the_rim_of_a_tall_column_rests():
    """a = 6 on ten particles over the half-width: the last grain lies near the front, as by MPM.

    The cause is known: the artificial viscosity of the ground's particles ahead of a grain that slides pushes it back
    and up, so that it skates without stress at a height of dx. Viscosity along the normal alone, and friction of 45
    degrees on what is borne without stress, stop it, at 1.28 m and 1.49 m. The run-out of a
    column with a = 2 then changes by 5.8 % with half the spacing, for 5 (`verification/test_columns.py`). On grains
    with hardly any others around them alone it passes here (1.47 m, 1.59 m), but a = 1 and a = 8 change by 6.7 and
    5.5 % (docs/sph.md).
    """
    fields = {}
    for method in ("mpm", "sph"):
        scene = load_scene("column_collapse_2d", {
            "solver.method": method, "solver.dx": 0.02, "bodies.0.shape.max": [0.2, 1.2], "end_time": 1.4,
            "domain.max": [4.8, 2.0]})
        simulation = Simulation(scene)
        while simulation.time < 1.4:
            simulation.step(until=1.4)
        fields[method] = simulation.particles
    fronts = {method: np.quantile(one["position"][:, 0], 0.99) for method, one in fields.items()}
    farthest = {method: one["position"][:, 0].max() for method, one in fields.items()}
    assert fronts["sph"] == pytest.approx(fronts["mpm"], rel=0.15)
    assert farthest["sph"] < 1.3 * fronts["sph"] and farthest["sph"] < 1.05 * farthest["mpm"]
