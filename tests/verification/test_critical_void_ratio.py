"""Loose and dense sand, sheared under the same weight, reach one void ratio, in a scene (R1).

A layer on a rough floor, periodic along x, is held at the velocity gamma' z along x by an acceleration that pulls it
there; upward it is free, so that each height keeps the weight above it as its normal stress. A drag along z keeps it
from jumping: without one, and sheared five times faster, dense sand dilates so fast that it takes off from its floor.
"""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

HEIGHT, DX, RATE, SHEAR = 0.4, 0.05, 2.0, 4.0
PULL = 200.0
"""1 over the time in which a grain takes up the velocity of its height [1/s]."""
DRAG = 50.0
"""Of motion along z [1/s]; a layer that settles by 2 % in a second is held up by a hundredth of its weight."""
SAND = {"kind": "critical_state_hypoplastic", "density": 1800.0, "youngs_modulus": 1e6, "reference_pressure": 5e3,
        "poisson_ratio": 0.0, "friction_angle": 30.0, "least_void_ratio": 0.5, "critical_void_ratio_limit": 0.55,
        "critical_void_ratio_drop": 0.25, "density_effect": 0.2}
LOOSE, DENSE = 0.84, 0.66


def sheared(void_ratio, method):
    """Void ratios, heights and normal stresses over the weight above, in the middle of the layer, after the shear."""
    scene = Scene.model_validate({
        "name": "shear", "dimension": 2, "end_time": SHEAR / RATE,
        "solver": {"dx": DX if method == "mpm" else 0.5 * DX, "method": method},
        "domain": {"min": [0.0, 0.0], "max": [8 * DX, 2.0 * HEIGHT], "boundary": {
            "x_min": "periodic", "x_max": "periodic", "z_min": "stick"}},
        "materials": {"sand": {**SAND, "void_ratio": void_ratio}}, "initial": {"stress": "geostatic"},
        "bodies": [{"name": "layer", "material": "sand",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [8 * DX, HEIGHT]}}]})
    simulation = Simulation(scene)
    simulation.add_acceleration(
        lambda x, v, t: np.column_stack([PULL * (RATE * x[:, 1] - v[:, 0]), -DRAG * v[:, 1]]))
    while simulation.time < SHEAR / RATE:
        simulation.step(until=SHEAR / RATE)
    fields = simulation.particles
    height = fields["position"][:, 1]
    top, row = height.max(), 0.5 * DX
    middle = (height > 0.25 * top) & (height < 0.75 * top)
    above = np.clip((height - height[middle, None]) / row + 0.5, 0.0, 1.0) @ fields["mass"]  # half of its own row
    weight = 9.81 * above / (8 * DX)
    assert np.isfinite(fields["failure_function"]).all() and (fields["accumulated_strain"][middle] > 1.0).all()
    return fields["void_ratio"][middle], -fields["stress"][middle, 1] / weight


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_loose_and_dense_sand_reach_one_void_ratio(method):
    (loose, carried), (dense, held) = (sheared(e, method) for e in (LOOSE, DENSE))
    for ratio in (carried, held):
        assert ratio.mean() == pytest.approx(1.0, abs=0.05)
    assert dense.mean() == pytest.approx(loose.mean(), rel=0.01)
    assert dense.mean() > DENSE + 0.08 and loose.mean() < LOOSE - 0.02
