"""Newmark's sliding block (1965, doi:10.1680/geot.1965.15.2.139): a block on ground that shakes slides while the pull
along the ground exceeds what friction holds, and stops when its speed is spent."""

import numpy as np
import pytest

from tests.components.forcing_and_damping.forced_block import METHODS, centre, run, stage

G, MU = 9.81, 0.3
TIMES = [0.0, 0.05, 0.1, 0.25, 0.3, 0.5, 0.55, 0.7, 0.75]
PULL = [0.0, 0.0, 7.0, 7.0, -5.0, -5.0, 2.0, 2.0, 0.0]  # minus the acceleration of the ground [m/s2]


def newmark(end_time, n=200_000):
    """Sliding (m) of a rigid block at `end_time` [s]."""
    dt, speed, way, furthest = end_time / n, 0.0, 0.0, 0.0
    for pull in np.interp((np.arange(n) + 0.5) * dt, TIMES, PULL):
        if speed == 0.0:
            speed = dt * np.sign(pull) * max(0.0, abs(pull) - MU * G)
        else:
            after = speed + dt * (pull - MU * G * np.sign(speed))
            speed = after if after * speed > 0.0 else 0.0
        way += dt * speed
        furthest = max(furthest, way)
    return way, furthest


@pytest.mark.parametrize("method", METHODS)
def test_block_on_shaken_ground(method):
    sim = stage(method, dx=0.1, precision="f32",
                material={"kind": "elastic", "density": 400.0, "youngs_modulus": 2e6, "poisson_ratio": 0.3},
                shape={"kind": "box", "min": [-0.3, 0.0], "max": [0.3, 0.2]},
                domain={"min": [-2.0, -1.0], "max": [2.0, 1.0]}, initial={"stress": "geostatic"},
                terrain={"kind": "plane", "contact": "separate", "friction": MU},
                gravity={"times": TIMES, "values": [[pull, -G] for pull in PULL]})
    start, end = centre(sim)[0], 0.8
    expected, furthest = newmark(end)
    assert furthest > 0.05 and abs(furthest - expected) > 0.005  # it slides one way, and some of it back
    row = run(sim, end)
    assert centre(sim)[0] - start == pytest.approx(expected, rel=0.04)
    # What friction took is what gravity did
    assert row["contact_work"] == pytest.approx(-row["potential_energy"], rel=0.05)
