"""Thrust of dry sand on a smooth wall, on a line of the grid or beside it (T5), by default choices of a scene.

At rest the sand presses with K0 = nu / (1 - nu) of its weight, in one dimension. When the wall gives way, it presses
with Rankine's active coefficient (1 - sin phi) / (1 + sin phi), from a few thousandths of its height on. Per width of
wall both thrusts are K rho g H^2 / 2. The floor is smooth too.
"""

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes import Scene

HEIGHT, DENSITY, POISSON_RATIO, FRICTION = 1.0, 1600.0, 0.3, 30.0
CELL = 0.05
WEIGHT = 0.5 * DENSITY * 9.81 * HEIGHT**2
"""rho g H^2 / 2 [N/m]."""
GIVES_WAY = 0.3
"""When the wall begins to move [s], by 1 cm/s."""


def thrust(offset, folder):
    """Force on the wall against its normal [N/m] over time; offset: of its face from a line of the grid [cells]."""
    face = offset * CELL
    scene = Scene.model_validate({
        "name": "thrust", "dimension": 2, "end_time": 1.5, "output": {"interval": 0.05}, "solver": {"dx": CELL},
        "domain": {"min": [-0.5, 0.0], "max": [1.0, 1.5], "boundary": {"x_max": "symmetric", "z_min": "symmetric"}},
        "materials": {"sand": {"kind": "mohr_coulomb", "density": DENSITY, "youngs_modulus": 2e6,
                               "poisson_ratio": POISSON_RATIO, "friction_angle": FRICTION}},
        "bodies": [{"name": "fill", "material": "sand",
                    "shape": {"kind": "box", "min": [face, 0.0], "max": [1.0, HEIGHT]}}],
        "obstacles": [{"name": "wall", "shape": {"kind": "box", "min": [-0.4, -0.2], "max": [face, 1.4]},
                       "contact": "slip", "motion": {"velocity": [-0.01, 0.0], "start": GIVES_WAY}}],
        "initial": {"stress": "geostatic"}})
    history = snowmpm.run(scene, folder / "run").history
    return history["time"], -np.asarray(history["wall_force_x"])


@pytest.mark.parametrize("offset", [0.0, 0.5, *(pytest.param(k, marks=pytest.mark.slow) for k in (0.25, 0.8))])
def test_thrust_at_rest_and_active(offset, tmp_path):
    time, force = thrust(offset, tmp_path)
    at_rest = force[(time > 0.1) & (time < GIVES_WAY)]
    assert len(at_rest) >= 3
    assert at_rest == pytest.approx(POISSON_RATIO / (1.0 - POISSON_RATIO) * WEIGHT, rel=0.002)
    sine = np.sin(np.deg2rad(FRICTION))
    active = force[time > GIVES_WAY + 0.4]
    assert active == pytest.approx((1.0 - sine) / (1.0 + sine) * WEIGHT, rel=0.03)
