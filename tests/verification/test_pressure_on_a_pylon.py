"""Slow, dense snow that flows around a narrow pylon presses far more than its weight (G6).

Sovilla, Kern and Schaer (2010), doi:10.3189/002214310793146287, on three wet avalanches at the pylon of Vallee de la
Sionne, 0.6 m wide: the mean pressure rises linearly with the depth below the surface, to about eight times that of the
weight above, whatever the speed; it fluctuates by about a fifth. Broms (1964) takes 3 (1 + sin phi) / (1 - sin phi)
times the weight for soil before a narrow pile. Here snow of a friction angle of 30 degrees, three cells to the pylon,
in a channel 13 times as wide, whose slope balances most of the drag.

Seen: 8.1 times at 4 m/s, 5.1 at 2 m/s; so it depends on the speed here. Why is not known.
"""

import numpy as np
import pytest

import snowmpm
from snowmpm.io.panels import panels_of
from snowmpm.scenes import Scene

DEPTH, DENSITY, G, FRICTION = 3.0, 400.0, 9.81, 30.0
STEADY = 1.5, 3.5
"""Times of the mean [s]."""
MEASURED = 8.0
pytestmark = pytest.mark.slow


def flow(speed):
    """Snow of DEPTH that flows around a pylon, in a channel that is closed on itself."""
    low, high = -8.0, 8.0
    bodies = [{"name": name, "material": "snow", "velocity": [speed, 0.0, 0.0],
               "shape": {"kind": "box", "min": [start, -4.0, 0.0], "max": [end, 4.0, DEPTH]}}
              for name, start, end in (("upstream", low, -0.3), ("downstream", 0.9, high))]
    return Scene.model_validate({
        "name": "pylon", "dimension": 3, "end_time": STEADY[1], "output": {"interval": 0.5}, "solver": {"dx": 0.2},
        "gravity": [0.9, 0.0, -G], "initial": {"stress": "geostatic"},
        "domain": {"min": [low, -4.0, 0.0], "max": [high, 4.0, 7.0],
                   "boundary": {"x_min": "periodic", "x_max": "periodic", "y_min": "symmetric", "y_max": "symmetric",
                                "z_min": "slip", "z_max": "open"}},
        "materials": {"snow": {"kind": "mohr_coulomb", "density": DENSITY, "youngs_modulus": 2e6,
                               "poisson_ratio": 0.3, "friction_angle": FRICTION, "cohesion": 500.0}},
        "bodies": bodies,
        "obstacles": [{"name": "pylon",
                       "shape": {"kind": "box", "min": [-0.3, -0.3, -0.4], "max": [0.9, 0.3, 6.0]},
                       "panels": {"size": 0.5, "direction": [1.0, 0.0, 0.0], "interval": 0.02}}]})


@pytest.fixture(scope="module", params=[
    pytest.param(2.0, marks=pytest.mark.xfail(strict=True, raises=AssertionError, reason="5.1 times the weight")), 4.0],
    ids=["2 m/s", "4 m/s"])
def pressures(request, tmp_path_factory):
    """Depth of the rows of panels below the surface just upstream [m], mean pressure, its standard deviation [Pa]."""
    run = snowmpm.run(flow(request.param), tmp_path_factory.mktemp("pylon") / "run")
    one = panels_of(run)["pylon"]
    steady = (one.time > STEADY[0]) & (one.time <= STEADY[1])
    rows = one.pressure[steady].mean(axis=2)
    below = surface(run) - one.middles(1)
    inside = below > one.edges[1]
    return below[inside], rows.mean(axis=0)[inside], rows.std(axis=0)[inside]


def surface(run):
    """Mean height of the snow within a metre upstream of the pylon over the steady frames [m]."""
    found = []
    for i in np.flatnonzero((run.times >= STEADY[0]) & (run.times <= STEADY[1])):
        x = run.frame(i, []).positions
        found.append(np.percentile(x[(x[:, 0] > -1.3) & (x[:, 0] < -0.3) & (np.abs(x[:, 1]) < 0.5), 2], 98))
    return np.mean(found)


def test_it_rises_with_depth_to_eight_times_the_weight(pressures):
    below, mean, deviation = pressures
    slope = mean @ below / (below @ below)
    print(f"{slope / (DENSITY * G):.2f} times the weight")
    assert slope / (DENSITY * G) == pytest.approx(MEASURED, rel=0.25)
    assert np.corrcoef(below, mean)[0, 1] > 0.98
    assert 0.05 < (deviation / mean).mean() < 0.4
