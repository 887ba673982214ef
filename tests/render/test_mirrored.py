"""A quarter drawn whole."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.render import render_run
from snowmpm.render.mirrored import MirroredRun
from snowmpm.scenes.schema import Scene


def quarter(sides):
    return Scene.model_validate({
        "name": "quarter", "dimension": 3, "end_time": 0.05, "output": {"interval": 0.05}, "solver": {"dx": 0.25},
        "domain": {"min": [-1.0, 2.0, 0.0], "max": [1.0, 4.0, 2.0], "boundary": {**sides, "z_min": "stick"}},
        "terrain": {"kind": "plane"}, "materials": {"snow": {
            "kind": "elastic", "density": 100.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
        "bodies": [{"name": "ball", "material": "snow", "velocity": [1.0, -1.0, 0.0],
                    "shape": {"kind": "sphere", "centre": [1.0, 2.0, 0.8], "radius": 0.7}}]})


def test_four_quarters(tmp_path):
    run = snowmpm.run(quarter({"x_max": "symmetric", "y_min": "symmetric"}), tmp_path / "run")
    assert run.provenance["body_shares"] == {"ball": pytest.approx(0.25)}
    whole = MirroredRun(tmp_path / "run")
    part, frame = run.frame(0), whole.frame(0)
    assert whole.n_points(0) == len(frame) == 4 * len(part)
    np.testing.assert_allclose(frame.positions.mean(axis=0)[:2], [1.0, 2.0], atol=1e-5)
    assert (frame.positions[: len(part)] == part.positions).all()
    np.testing.assert_allclose(frame.fields["velocity"].mean(axis=0), [0.0, 0.0, 0.0], atol=1e-6)
    radius = np.linalg.norm(frame.positions - [1.0, 2.0, 0.8], axis=1)
    assert radius.max() < 0.7 and (np.linalg.norm(part.positions - [1.0, 2.0, 0.8], axis=1).max() == radius.max())
    assert len(whole.terrain.facets) == 4 * len(run.terrain.facets)
    np.testing.assert_allclose((whole.terrain.vertices + whole.origin).min(axis=0)[:2], [-1.0, 0.0], atol=1e-5)
    render_run(whole, tmp_path / "whole.png", size=(320, 180))


def test_walls_are_no_mirrors(tmp_path):
    snowmpm.run(quarter({"x_max": "slip", "y_min": "slip"}), tmp_path / "run")
    with pytest.raises(InputError, match='nothing to mirror: no side of its domain is "symmetric"'):
        MirroredRun(tmp_path / "run")
