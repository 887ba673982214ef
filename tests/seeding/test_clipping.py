"""Bodies cut off at symmetric sides: exact volumes, and a quarter that flows as the whole does."""

import numpy as np
import pytest
import trimesh

from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.seeding.clipping import clipped, disc_part
from snowmpm.seeding.shapes import shape_of
from snowmpm.setup.build import build
from tests.support.tables import Table

FREE = np.inf
SHAPES = [
    Table(kind="sphere", centre=(0.0, 0.0, 0.0), radius=2.0), Table(kind="box", min=(-1, -1, -1), max=(1, 2, 3)),
    Table(kind="cylinder", base=(0, 0, 0), axis=(0, 0, 2.0), radius=1.0, height=3.0),
    Table(kind="cylinder", base=(0, 2.0, 0), axis=(0, -1.0, 0), radius=1.0, height=3.0),
    Table(kind="cylinder", base=(0, 0, 0), axis=(1, 0.3, 2.0), radius=1.0, height=3.0),
    Table(kind="prism", points=((-1, -1), (2, -1), (0, 2), (0, 0)), y=(-1, 1)),
]
BOXES = [((0, 0, -FREE), (FREE,) * 3), ((-0.3, -0.6, 0.1), (0.7, FREE, 0.5)), ((0, -FREE, -FREE), (FREE,) * 3)]


@pytest.mark.parametrize("spec", SHAPES, ids=lambda spec: spec.kind)
@pytest.mark.parametrize("box", BOXES, ids=str)
def test_volume(spec, box):
    """Against the share of random points; particles lie inside."""
    whole, (lower, upper) = shape_of(spec, 3, ".", "shape"), map(np.array, box)
    part = clipped(whole, spec, lower.astype(float), upper.astype(float), "shape")
    points = whole.origin + (np.random.default_rng(0).random((200_000, 3)) * whole.size) @ whole.axes
    inside = (points >= lower).all(axis=1) & (points < upper).all(axis=1)
    if whole.contains is not None:
        inside &= whole.contains(points)
    expected = inside.mean() * np.prod(whole.size)
    assert part.volume == pytest.approx(expected, abs=4.0 * np.prod(whole.size) * 0.5 / np.sqrt(len(points)))
    if part.contains is not None:
        np.testing.assert_array_equal(part.contains(points), inside)


def test_exact_volumes(tmp_path):
    """Quarters and eighths to round-off; caps of a ball and of a mesh."""
    free, zero = np.full(3, FREE), np.zeros(3)
    for spec, share in ((SHAPES[0], 8), (SHAPES[2], 4)):
        whole = shape_of(spec, 3, ".", "shape")
        assert clipped(whole, spec, zero, free, "shape").volume == pytest.approx(whole.volume / share, rel=1e-12)
    ball = shape_of(SHAPES[0], 3, ".", "shape")
    cap = clipped(ball, SHAPES[0], np.array([-FREE, 1.2, -FREE]), free, "shape").volume
    assert cap == pytest.approx(np.pi * 0.8**2 * (3 * 2.0 - 0.8) / 3.0, rel=1e-10)
    assert disc_part(2.0, np.array([0.0, -FREE]), np.array([FREE, 1.0])) == pytest.approx(
        0.5 * (4.0 * np.pi - 4.0 * (np.arccos(0.5) - 0.5 * np.sqrt(0.75))), rel=1e-12)
    trimesh.creation.box(extents=(2.0, 2.0, 4.0)).export(tmp_path / "box.stl")
    spec = Table(kind="mesh", file="box.stl")
    whole = shape_of(spec, 3, tmp_path, "shape")
    part = clipped(whole, spec, np.array([-0.5, 0.25, -FREE]), np.array([0.5, FREE, 1.0]), "shape")
    assert part.volume == pytest.approx(1.0 * 0.75 * 3.0, rel=1e-6)
    voxels = np.ones((4, 2, 2), np.uint8)
    voxels[0] = 0
    np.save(tmp_path / "ice.npy", voxels)
    spec = Table(kind="voxels", file="ice.npy", voxel_size=0.5, phase=1, origin=None, counts=None)
    part = clipped(shape_of(spec, 3, tmp_path, "shape"), spec, np.array([0.7, -FREE, 0.25]), free, "shape")
    assert part.volume == pytest.approx(1.3 * 1.0 * 0.75, rel=1e-12)


def column(quarter, method="mpm", **keys):
    low, sides = (0.0, {"x_min": "symmetric", "y_min": "symmetric"}) if quarter else (-1.5, {})
    return Scene.model_validate({
        "name": "column", "dimension": 3, "end_time": 0.25, "solver": {"dx": 0.1, "method": method},
        "domain": {"min": [low, low, 0.0], "max": [1.5, 1.5, 1.0], "boundary": {**sides, "z_min": "stick"}},
        "materials": {"sand": {"kind": "mohr_coulomb", "density": 1500.0, "youngs_modulus": 4e5, "poisson_ratio": 0.3,
                               "friction_angle": 25.0}},
        "bodies": [{"name": "column", "material": "sand", "shape": {
            "kind": "cylinder", "base": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "radius": 0.5, "height": 0.5}}],
        **keys})


@pytest.mark.parametrize("method", ["mpm", pytest.param("sph", marks=pytest.mark.slow)])
def test_a_quarter_of_a_round_column_collapses_as_all_of_it(method):
    mass, reach, height = {}, {}, {}
    for quarter in (True, False):
        simulation = Simulation(column(quarter, method))
        mass[quarter] = simulation.solver.particles.mass
        while simulation.time < 0.25:
            simulation.step(until=0.25)
        x = simulation.particles["position"]
        reach[quarter], height[quarter] = np.quantile(np.hypot(x[:, 0], x[:, 1]), [0.5, 0.9, 0.99]), x[:, 2].max()
    assert mass[True] == pytest.approx(0.25 * mass[False], rel=1e-12)
    np.testing.assert_allclose(reach[True], reach[False], rtol=0.01)
    assert reach[False][-1] > 0.53 and height[True] == pytest.approx(height[False], rel=0.02)


def test_what_is_said_of_a_cut_body():
    assert build(column(True)).shares == {"column": pytest.approx(0.25, rel=1e-12)}
    assert build(column(False)).shares == {"column": 1.0}


def test_a_body_beyond_the_side_is_refused():
    ball = {"kind": "sphere", "centre": [-1.0, 0.0, 0.3], "radius": 0.2}
    body = column(True).bodies[0].model_dump() | {"shape": ball}
    with pytest.raises(InputError, match="wholly beyond a side"):
        build(column(True, bodies=[body]))


def test_open_sides_still_refuse_what_reaches_outside():
    ball = {"kind": "sphere", "centre": [1.4, 0.5, 0.3], "radius": 0.2}
    body = column(True).bodies[0].model_dump() | {"shape": ball}
    with pytest.raises(InputError, match="reaches outside the domain"):
        build(column(True, bodies=[body]))
