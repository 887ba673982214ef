"""A third method needs no change of the program but its row in the registry: it runs, is audited, mapped and drawn.

It passes the suite of methods (`test_every_method`): there it is resumed, and refused what it cannot do."""

from pathlib import Path

import numpy as np
import pytest

import snowmpm
from snowmpm import render
from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.scenes.schema import Scene
from tests.contract import toy_method
from tests.support.registered import registered, without

ANGLE, MU, G = 35.0, 0.3, 9.81


@pytest.fixture(autouse=True)
def sliding():
    with registered(toy_method.ENTRY):
        yield


def slope(dimension=3, **changes):
    """A layer of snow on a plane."""
    across = {} if dimension == 2 else {"y": [-0.5, 0.5]}
    tables = {
        "name": "sliding", "dimension": dimension, "end_time": 0.4, "gravity": G,
        "solver": {"method": "sliding", "dx": 0.2, "precision": "f64"}, "output": {"interval": 0.2},
        "domain": {"min": [-2.0, -2.0, -6.0][-dimension:], "max": [6.0, *[2.0, 2.0][1 - dimension:]]},
        "terrain": {"kind": "plane", "angle": ANGLE, "friction": MU, "contact": "separate"},
        "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
        "bodies": [{"name": "snow", "material": "snow",
                    "shape": {"kind": "layer", "bottom": 0.0, "top": 0.4, "region": {"x": [0.0, 1.0], **across}}}]}
    return Scene.model_validate({**tables, **changes})


def test_it_is_small():
    assert len(Path(toy_method.__file__).read_text().splitlines()) < 500


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run that stopped half way and was resumed."""
    folder = tmp_path_factory.mktemp("sliding")
    with registered(toy_method.ENTRY):
        snowmpm.run(slope(end_time=0.2), folder)
        return snowmpm.run(slope(), folder, resume=True)


def test_it_slides_as_coulomb_has_it(finished):
    """v = g t (sin a - mu cos a) down the slope, of all that lay on it."""
    last = finished.frame(-1)
    angle = np.radians(ANGLE)
    expected = G * 0.4 * (np.sin(angle) - MU * np.cos(angle))
    speed = np.linalg.norm(last.fields["velocity"], axis=1)
    assert np.median(speed) == pytest.approx(expected, rel=0.02)


def test_it_is_audited(finished):
    history = finished.history
    assert abs(history["momentum_residual"][-1]) < 1e-12
    lost = history["potential_energy"][0] - history["potential_energy"][-1]
    assert lost > 0.0 and abs(history["energy_remainder"][-1]) < 1e-9 * lost
    assert history["contact_work"][-1] > 0.1 * lost


def test_it_is_mapped(finished):
    assert np.nanmax(finished.maps["peak_speed"].values) == pytest.approx(
        np.linalg.norm(finished.frame(-1).fields["velocity"], axis=1).max(), rel=0.3)


def test_it_is_drawn(finished, tmp_path):
    assert render.render_run(finished, tmp_path / "last.png", size=(160, 120)).stat().st_size > 1000
    assert render.render_history(finished, tmp_path / "history.png").stat().st_size > 1000


WALL = [{"name": "wall", "shape": {"kind": "box", "min": [3.0, -1.0], "max": [3.2, 1.0]}}]


def test_a_refusal_names_the_key_and_the_methods_that_can():
    """One for each capability: the suite."""
    words = ('obstacles.0.name = \'wall\': needs solver.method = "mpm" or "sph" or "depth" or "implicit" in place of'
             ' "sliding"')
    with pytest.raises(InputError, match=words):
        snowmpm.Simulation(slope(2, obstacles=WALL))


def test_a_dimension_that_it_lacks_is_refused():
    from dataclasses import replace

    plane = replace(toy_method.ENTRY, capabilities=replace(toy_method.ENTRY.capabilities, dimensions=(2,)))
    words = r'dimension = 3: needs .* = "mpm" or "sph" or "depth".*which has 2 only'
    with registered(plane), pytest.raises(InputError, match=words):
        snowmpm.Simulation(slope(3))


def test_a_method_that_is_not_there_is_refused():
    with without(METHODS, "sliding"), pytest.raises(ValueError, match="'mpm', 'sph', 'depth' or 'implicit'"):
        slope()
