"""A third method needs no change of the program but its row in the registry: it runs, is audited, mapped, drawn,
checkpointed and resumed, and what it cannot do is refused."""

from pathlib import Path

import numpy as np
import pytest
import toy_method

import snowmpm
from snowmpm import render
from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.scenes.schema import Scene

ANGLE, MU, G = 35.0, 0.3, 9.81


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    monkeypatch.setitem(METHODS, "sliding", toy_method.ENTRY)


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
def runs(tmp_path_factory):
    """One run as a whole, and one that stopped half way and was resumed."""
    folder = tmp_path_factory.mktemp("sliding")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(METHODS, "sliding", toy_method.ENTRY)
        whole = snowmpm.run(slope(), folder / "whole")
        snowmpm.run(slope(end_time=0.2), folder / "parts")
        return whole, snowmpm.run(slope(), folder / "parts", resume=True)


def test_it_slides_as_coulomb_has_it(runs):
    """v = g t (sin a - mu cos a) down the slope, of all that lay on it."""
    last = runs[0].frame(-1)
    angle = np.radians(ANGLE)
    expected = G * 0.4 * (np.sin(angle) - MU * np.cos(angle))
    speed = np.linalg.norm(last.fields["velocity"], axis=1)
    assert np.median(speed) == pytest.approx(expected, rel=0.02)


def test_it_is_audited(runs):
    history = runs[0].history
    assert abs(history["momentum_residual"][-1]) < 1e-12
    lost = history["potential_energy"][0] - history["potential_energy"][-1]
    assert lost > 0.0 and abs(history["energy_remainder"][-1]) < 1e-9 * lost
    assert history["contact_work"][-1] > 0.1 * lost


def test_it_is_mapped(runs):
    assert np.nanmax(runs[0].maps["peak_speed"].values) == pytest.approx(
        np.linalg.norm(runs[0].frame(-1).fields["velocity"], axis=1).max(), rel=0.3)


def test_it_is_drawn(runs, tmp_path):
    assert render.render_run(runs[0], tmp_path / "last.png", size=(160, 120)).stat().st_size > 1000
    assert render.render_history(runs[0], tmp_path / "history.png").stat().st_size > 1000


def test_it_resumes_bit_by_bit(runs):
    whole, parts = runs
    assert list(whole.times) == list(parts.times)
    for k in range(len(whole)):
        assert whole.frame(k).points.tobytes() == parts.frame(k).points.tobytes()
        assert whole.frame(k).fields["velocity"].tobytes() == parts.frame(k).fields["velocity"].tobytes()
    for name, values in whole.history.items():
        assert np.array_equal(values, parts.history[name], equal_nan=True), name


WALL = [{"name": "wall", "shape": {"kind": "box", "min": [3.0, -1.0], "max": [3.2, 1.0]}}]
BODY = {"name": "snow", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.4, 0.4]}}
CUT = [{"kind": "cut", "body": "snow", "path": [[0.0, 0.0], [1.0, 0.0]]}]


@pytest.mark.parametrize(("changes", "words"), [
    ({"obstacles": WALL}, 'obstacles.0.name = \'wall\': needs solver.method = "mpm" or "sph" in place of "sliding"'),
    ({"bodies": [{**BODY, "contact": "separate"}]}, 'bodies.0.contact = \'separate\': needs solver.method = "mpm"'),
    ({"initial": {"stress": "geostatic"}}, "initial.stress = 'geostatic': needs solver.method"),
    ({"initial": {"stress": "settle"}}, "initial.stress = 'settle': needs solver.method"),
    ({"events": CUT}, "events.0.kind = 'cut': needs solver.method"),
    ({"domain": {"min": [-1.6, -3.0], "max": [4.8, 2.0], "boundary": {"x_min": "periodic", "x_max": "periodic"}}},
     "domain.boundary = 'periodic': needs solver.method")])
def test_what_it_cannot_do_is_refused(changes, words):
    with pytest.raises(InputError) as refusal:
        snowmpm.Simulation(slope(2, **changes))
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2


def test_a_dimension_that_it_lacks_is_refused(monkeypatch):
    from dataclasses import replace

    plane = replace(toy_method.ENTRY, capabilities=replace(toy_method.ENTRY.capabilities, dimensions=(2,)))
    monkeypatch.setitem(METHODS, "sliding", plane)
    with pytest.raises(InputError, match=r'dimension = 3: needs solver.method = "mpm" or "sph" or "depth".*which has 2 only'):
        snowmpm.Simulation(slope(3))


def test_a_method_that_is_not_there_is_refused(monkeypatch):
    monkeypatch.delitem(METHODS, "sliding")
    with pytest.raises(ValueError, match="'mpm', 'sph' or 'depth'"):
        slope()
