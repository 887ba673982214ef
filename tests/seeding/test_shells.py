"""Meshes of several shells: volume and inside are of one kind."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from snowmpm.seeding import seed_body
from snowmpm.seeding.shapes import mesh


def cube(side=1.0, at=(0.0, 0.0, 0.0), cavity=False):
    found = trimesh.creation.box((side, side, side))
    found.apply_translation(at)
    if cavity:
        found.invert()
    return found


CASES = {
    "side by side": ([cube(), cube(at=(3.0, 0.0, 0.0))], 2.0, False),
    "overlapping": ([cube(), cube(at=(0.5, 0.0, 0.0))], 1.5, True),
    "one in the other": ([cube(), cube(0.5)], 1.0, True),
    "a cavity": ([cube(), cube(0.5, cavity=True)], 0.875, False),
    "a cavity in a file that faces inwards": ([cube(cavity=True), cube(0.5)], 0.875, False),
    "snow in a cavity": ([cube(), cube(0.5, cavity=True), cube(0.2)], 0.883, False),
    "twice the same": ([cube(), cube()], 1.0, False),
}


@pytest.mark.parametrize("name", CASES)
def test_volume_and_inside(tmp_path, name):
    parts, volume, told = CASES[name]
    trimesh.util.concatenate(parts).export(tmp_path / "body.stl")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        shape = mesh(SimpleNamespace(file="body.stl"), 3, tmp_path, "shape")
    assert bool([one for one in said if "its shells overlap" in str(one.message)]) == told
    assert shape.volume == pytest.approx(volume, rel=2e-3 if told else 1e-6)
    points = shape.origin + np.random.default_rng(1).random((200_000, 3)) * shape.size
    assert shape.contains(points).mean() * shape.size.prod() == pytest.approx(volume, rel=0.02)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_mass_of_the_particles(tmp_path):
    trimesh.util.concatenate(CASES["overlapping"][0]).export(tmp_path / "body.stl")
    seeds = seed_body(SimpleNamespace(kind="mesh", file="body.stl"), None, dim=3, dx=0.1, particles_per_cell=8,
                      sampling="regular", rng=np.random.default_rng(1), base_dir=tmp_path)
    assert seeds.volumes.sum() == pytest.approx(1.5, rel=2e-3)
    assert len(seeds.volumes) == pytest.approx(1.5 * 8000, rel=0.01)


def test_a_cavity_is_cut_at_a_side_of_the_domain(tmp_path):
    trimesh.util.concatenate(CASES["a cavity"][0]).export(tmp_path / "body.stl")
    cut = np.array([0.0, -np.inf, -np.inf]), np.full(3, np.inf)
    seeds = seed_body(SimpleNamespace(kind="mesh", file="body.stl"), None, dim=3, dx=0.1, particles_per_cell=8,
                      sampling="regular", rng=np.random.default_rng(1), base_dir=tmp_path, cut=cut)
    assert seeds.volumes.sum() == pytest.approx(0.875 / 2.0, rel=1e-6) and seeds.share == pytest.approx(0.5)
