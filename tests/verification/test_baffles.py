"""Baffles and a check dam in the way of a flow (B20 of Bui and Nguyen 2021, after Yang et al.).

In words: baffles slow a flow down, tall ones more than short ones; a dam across the channel slows it most, and bears
about ten times the force of one baffle. Figures only, and no sizes; so here a channel of 3.2 m with a row of four
baffles of 0.3 m, gaps of half a metre between, in sand with mu(I).
"""

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes.schema import Scene

pytestmark = pytest.mark.slow
ANGLE, WIDE, AT = 35.0, 3.2, 9.0
SAND = {"kind": "mu_i", "density": 1500.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "static_friction": 0.47,
        "limit_friction": 0.65, "grain_diameter": 5e-3, "grain_density": 2600.0}


def scene(obstacles):
    slope = np.radians(ANGLE)
    return Scene.model_validate({
        "name": "baffles", "dimension": 3, "end_time": 3.5, "output": {"interval": 0.1},
        "gravity": [float(9.81 * np.sin(slope)), 0.0, float(-9.81 * np.cos(slope))],
        "solver": {"dx": 0.1, "particles_per_cell": 4},
        "domain": {"min": [0.0, 0.0, 0.0], "max": [30.0, WIDE, 3.0],
                   "boundary": {"x_min": "slip", "y_min": "slip", "y_max": "slip"}},
        "terrain": {"kind": "plane", "angle": 0.0, "friction": 0.5}, "materials": {"sand": SAND},
        "bodies": [{"name": "release", "material": "sand",
                    "shape": {"kind": "box", "min": [0.0, 0.0, 0.0], "max": [3.0, WIDE, 0.8]}}],
        "obstacles": obstacles})


def posts(height):
    return [{"name": f"baffle_{i}", "friction": 0.3,
             "shape": {"kind": "box", "min": [AT, 0.25 + 0.8 * i, -0.3], "max": [AT + 0.3, 0.55 + 0.8 * i, height]}}
            for i in range(4)]


DAM = [{"name": "dam", "friction": 0.3, "shape": {"kind": "box", "min": [AT, -0.5, -0.3],
                                                  "max": [AT + 0.3, WIDE + 0.5, 1.2]}}]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    cases = {"none": [], "short": posts(0.25), "tall": posts(1.2), "dam": DAM}
    return {name: snowmpm.run(scene(obstacles), tmp_path_factory.mktemp("baffles") / name)
            for name, obstacles in cases.items()}


def energy_beyond(run):
    """Kinetic energy of what has passed the row, summed over the frames after it came there [J s]."""
    total = 0.0
    for i in range(len(run)):
        frame = run.frame(i, ["velocity"])
        beyond = frame.positions[:, 0] > AT + 0.5
        total += (frame.fields["velocity"][beyond] ** 2).sum()
    return total


def largest(run, name):
    """Largest mean force along the flow over 0.1 s [N]."""
    obstacle = run.obstacles[name]
    begin = np.arange(0.0, obstacle.time[-1] - 0.1, 0.02)
    impulse = np.interp(begin + 0.1, obstacle.time, obstacle.impulse[:, 0]) - np.interp(
        begin, obstacle.time, obstacle.impulse[:, 0])
    return impulse.max() / 0.1


def test_taller_baffles_slow_the_flow_more_and_a_dam_most(runs):
    energies = [energy_beyond(runs[name]) for name in ("none", "short", "tall", "dam")]
    print(np.array(energies) / energies[0])
    assert energies == sorted(energies, reverse=True) and energies[2] < 0.9 * energies[0]


def test_the_dam_bears_several_times_the_force_of_one_baffle(runs):
    """About ten times in the source, which has other widths and gaps: 5 to 20."""
    one = np.mean([largest(runs["tall"], f"baffle_{i}") for i in range(4)])
    ratio = largest(runs["dam"], "dam") / one
    print(ratio)
    assert 5.0 < ratio < 20.0
