"""Forces on snow: on a whole body, growing, ending; what they give is what they should."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.scenes import Scene

SNOW = {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
MASS = 200.0 * 0.4 * 0.2  # kg/m
FORCE = (3.0, -5.0)  # N/m


def blocks(**load):
    """Two blocks far apart in space without gravity; the load is on the second."""
    return Scene.model_validate({
        "name": "blocks", "dimension": 2, "end_time": 1.0, "gravity": 0.0, "solver": {"dx": 0.1},
        "domain": {"min": [-1.0, -2.0], "max": [4.0, 2.0]}, "materials": {"snow": SNOW},
        "bodies": [{"name": name, "material": "snow", "shape": {"kind": "box", "min": [x, 0.0], "max": [x + 0.4, 0.2]}}
                   for name, x in (("first", 0.0), ("second", 2.0))],
        "events": [{"kind": "load", "body": "second", "force": FORCE, **load}]})


def velocities(scene, until):
    """Mean velocity of each block at a time, and the imbalance of momentum."""
    simulation = snowmpm.Simulation(scene)
    while simulation.time < until:
        simulation.step(until=until)
    simulation.step()  # a load on particles acts before the step that follows its time
    fields = simulation.particles
    mean = [fields["velocity"][fields["body"] == body].mean(axis=0) for body in (0, 1)]
    return np.array(mean), simulation.audit()["momentum_residual"]


@pytest.mark.parametrize(("load", "acts"), [
    ({"start": 0.1}, 0.2), ({"start": 0.1, "ramp": 0.1}, 0.15), ({"start": 0.1, "ramp": 0.4}, 0.05),
    ({"start": 0.0, "stop": 0.2}, 0.2), ({"start": 0.5}, 0.0)])
def test_a_body_gets_the_impulse_of_the_force(load, acts):
    """At 0.3 s the force acted for `acts` seconds, over its full size."""
    mean, residual = velocities(blocks(**load), 0.3)
    np.testing.assert_allclose(mean[1], np.array(FORCE) / MASS * acts, atol=1e-4)
    assert (mean[0] == 0.0).all()
    assert residual < 1e-5


def test_a_local_load_grows_as_well():
    """Around a point that holds the whole block the same force gives the same velocity."""
    mean, residual = velocities(blocks(centre=[2.2, 0.1], radius=0.6, start=0.1, ramp=0.1), 0.3)
    np.testing.assert_allclose(mean[1], np.array(FORCE) / MASS * 0.15, rtol=0.05)  # nodes: a step late at most
    assert (mean[0] == 0.0).all() and residual < 1e-5


def test_half_a_place_is_none():
    with pytest.raises(ValueError, match="both centre and radius"):
        blocks(centre=[2.2, 0.1])
    with pytest.raises(InputError, match="no snow of second"):
        velocities(blocks(centre=[3.5, 0.1], radius=0.3), 0.01)
