"""A thick elastic cantilever under a load that bends it by a third of its length (I4, Nost's V2 without water).

L = 1 m, h = 0.3 m, E = 10 MPa, nu = 0, 54 kN/m downwards, by steps at rest from a scene: as weight, and as traction on
the upper face. The end of Reissner's beam of a linear law lies at (0.9513, -0.3008) m; its fibres are strained by up to
18 %, where Hencky's law is softer. On the upper face the load moves outwards as the beam turns: it sinks 13 % more.
"""

import numpy as np
import pytest

from snowmpm import Simulation
from snowmpm.scenes import Scene
from tests.support.thick_beam import tip

LENGTH, THICKNESS, MODULUS, LOAD = 1.0, 0.3, 10e6, 54e3
TRACTION = {"kind": "traction", "name": "load", "body": "beam",
            "within": {"min": [-0.1, THICKNESS], "max": [1.1, THICKNESS]}, "value": ["0.0", f"-{LOAD}*min(t, 1)"]}


def end(cells, on_top=False):
    """Where the middle of the end comes to (2,) [m], from (1, 0), with so many cells through the thickness."""
    scene = Scene.model_validate({
        "name": "thick_cantilever", "dimension": 2, "end_time": 1.0, "output": {"interval": 0.1},
        "gravity": [0.0, 0.0 if on_top else -LOAD / (1000.0 * THICKNESS)],
        "solver": {"method": "implicit", "dx": THICKNESS / cells, "precision": "f64",
                   "implicit": {"time": "quasi_static"}},
        "domain": {"min": [0.0, -1.0], "max": [1.2, 0.6], "boundary": {"x_min": "stick"}},
        "materials": {"rubber": {"kind": "elastic", "density": 1000.0, "youngs_modulus": MODULUS,
                                 "poisson_ratio": 0.0}},
        "bodies": [{"name": "beam", "material": "rubber",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [LENGTH, THICKNESS]}}],
        "forces": [TRACTION] if on_top else []})
    simulation = Simulation(scene)

    def positions():
        return np.asarray(simulation.particles["position"])[np.argsort(simulation.particles["id"])]

    before = positions()
    while simulation.time < 1.0 - 1e-9:
        simulation.step()
    last = before[:, 0] > before[:, 0].max() - 1e-9
    return np.array([LENGTH, 0.0]) + (positions() - before)[last].mean(axis=0)


def test_the_beam_of_a_linear_law_is_the_published_one():
    assert tip(LOAD, LENGTH, THICKNESS, MODULUS, hencky=False) == pytest.approx([0.9513, -0.3008], abs=1e-4)


def test_the_published_tip():
    """Six cells through the thickness, as asked; 1 %."""
    assert end(6) == pytest.approx([0.9513, -0.3008], rel=0.01)


def test_own_weight_beside_the_beam_of_the_same_law():
    assert end(12) == pytest.approx(tip(LOAD, LENGTH, THICKNESS, MODULUS), rel=0.002)


def test_load_on_the_upper_face():
    found = end(12, on_top=True)
    expected = tip(LOAD, LENGTH, THICKNESS, MODULUS, arm=0.5 * THICKNESS)
    assert found == pytest.approx(expected, rel=0.01)
    assert abs(found[1]) > 1.1 * abs(tip(LOAD, LENGTH, THICKNESS, MODULUS)[1])
