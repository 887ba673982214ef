"""Bodies with a shape of their own: volume, evenness, nothing outside, the same from the same seed."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from snowmpm.errors import InputError
from snowmpm.seeding import seed_body
from snowmpm.seeding.polygons import Polygons
from tests.support.tables import Table as Spec

DX = 0.2


def fill(spec, dim, sampling="regular", dx=DX, seed=1, base_dir="."):
    rng = np.random.default_rng(seed)
    return seed_body(
        spec, None, dim=dim, dx=dx, particles_per_cell=2**dim, sampling=sampling, rng=rng, base_dir=base_dir
    )


SHAPES = {
    "box2": (Spec(kind="box", min=(0.0, 1.0), max=(3.0, 2.0)), 2, 3.0),
    "box3": (Spec(kind="box", min=(0.0, 1.0, -1.0), max=(1.1, 2.0, 0.5)), 3, 1.65),
    "disc": (Spec(kind="sphere", centre=(5.0, 2.0), radius=1.3), 2, np.pi * 1.69),
    "ball": (Spec(kind="sphere", centre=(5.0, 2.0, 1.0), radius=0.9), 3, 4 / 3 * np.pi * 0.729),
    "cylinder": (Spec(kind="cylinder", base=(1, 1, 0), axis=(1, 0, 2), radius=0.7, height=1.5), 3, np.pi * 0.735),
    "polygon": (Spec(kind="polygon", points=((0, 0), (4, 0), (4, 2), (2, 0.5), (0, 2))), 2, 5.0),
    "prism": (Spec(kind="prism", points=((0, 0), (4, 0), (4, 2), (2, 0.5), (0, 2)), y=(1.0, 1.8)), 3, 4.0),
}  # fmt: skip


def is_inside(spec, x):
    if spec.kind == "box":
        return ((x > spec.min) & (x < spec.max)).all(axis=1)
    if spec.kind == "sphere":
        return np.linalg.norm(x - spec.centre, axis=1) < spec.radius
    if spec.kind == "cylinder":
        axis = np.array(spec.axis) / np.linalg.norm(spec.axis)
        along = (x - spec.base) @ axis
        across = np.linalg.norm(x - spec.base - along[:, None] * axis, axis=1)
        return (along > 0) & (along < spec.height) & (across < spec.radius)
    if spec.kind == "prism" and not ((x[:, 1] > spec.y[0]) & (x[:, 1] < spec.y[1])).all():
        return np.zeros(len(x), bool)
    height = np.interp(x[:, 0], [0, 2, 4], [2, 0.5, 2])
    return (x[:, -1] > 0) & (x[:, -1] < height) & (x[:, 0] > 0) & (x[:, 0] < 4)


@pytest.mark.parametrize("sampling", ["regular", "jittered", "poisson"])
@pytest.mark.parametrize("name", SHAPES)
def test_volume_and_place(name, sampling):
    spec, dim, volume = SHAPES[name]
    seeds = fill(spec, dim, sampling)
    assert seeds.volumes.sum() == pytest.approx(volume, rel=1e-12)  # round-off
    assert is_inside(spec, seeds.positions).all()
    share = DX**dim / 2**dim
    # Lattice fitted to the box, border cells in or out by their centre: the count is a few per cent off.
    assert seeds.volumes.mean() == pytest.approx(share, rel=0.12)
    least = {"regular": 0.9, "jittered": 0.45, "poisson": 0.65}[sampling]  # of the spacing; see `lattice.py`
    nearest = cKDTree(seeds.positions).query(seeds.positions, 2)[0][:, 1]
    assert nearest.min() > least * DX / 2


@pytest.mark.parametrize("sampling", ["jittered", "poisson"])
def test_the_seed_decides(sampling):
    spec, dim, _ = SHAPES["box3"]
    a, b, c = (fill(spec, dim, sampling, seed=s).positions for s in (1, 1, 2))
    assert (a == b).all()
    assert a.shape != c.shape or (a != c).any()


def test_regular_box_on_the_grid_has_particles_at_the_quarters_of_its_cells():
    x = fill(Spec(kind="box", min=(0.4, 0.0), max=(1.0, 0.4)), 2).positions / DX
    np.testing.assert_allclose(np.sort(np.unique(np.round(x % 1.0, 9))), [0.25, 0.75])
    assert len(x) == 3 * 2 * 4


def test_stacked_boxes_have_no_gap():
    lower = fill(Spec(kind="box", min=(0.0, 0.0), max=(1.0, 0.5)), 2).positions
    upper = fill(Spec(kind="box", min=(0.0, 0.5), max=(1.0, 1.0)), 2).positions
    assert upper[:, 1].min() - lower[:, 1].max() == pytest.approx(0.1, rel=1e-12)  # one spacing


def test_closed_mesh_is_filled(tmp_path):
    ring = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=0.6, sections=64)
    ring.apply_translation([10.0, 5.0, 2.0])
    ring.export(tmp_path / "ring.stl")
    seeds = fill(Spec(kind="mesh", file="ring.stl"), 3, base_dir=tmp_path)
    assert seeds.volumes.sum() == pytest.approx(ring.volume, rel=1e-6)  # STL is float32
    r = np.linalg.norm(seeds.positions[:, :2] - [10.0, 5.0], axis=1)
    assert 0.49 < r.min() < 0.6  # inner facets leave the circle by 0.6 mm; nothing in the hole
    assert 0.9 < r.max() < 1.0
    assert seeds.volumes[0] == pytest.approx(0.001, rel=0.05)


def test_bad_shapes_are_named(tmp_path):
    trimesh.creation.box().slice_plane([0, 0, 0], [0, 0, 1]).export(tmp_path / "open.stl")
    (tmp_path / "junk.stl").write_text("no mesh")
    cases = [
        (Spec(kind="box", min=(0, 0), max=(1, 0)), 2, "shape.max"),
        (Spec(kind="box", min=(0, 0, 0), max=(1, 1, 1)), 2, "must be 2 finite numbers"),
        (Spec(kind="sphere", centre=(0, 0), radius=0.0), 2, "shape.radius"),
        (Spec(kind="polygon", points=((0, 0), (1, 1), (2, 2))), 2, "no area"),
        (Spec(kind="polygon", points=((0, 0), (1, 1))), 2, "no area"),
        (Spec(kind="polygon", points=((0, 0), (1, 1), (1, 0))), 3, "2-D scenes only"),
        (Spec(kind="cylinder", base=(0, 0, 0), axis=(0, 0, 0), radius=1.0, height=1.0), 3, "shape.axis"),
        (Spec(kind="cylinder", base=(0, 0, 0), axis=(0, 0, 1), radius=1.0, height=-1.0), 3, "shape.height"),
        (Spec(kind="polygon", points=((0, 0), (0.04, 0), (0.04, 0.04), (0.039, 0.001))), 2, "too small for a particle"),
        (Spec(kind="mesh", file="open.stl"), 3, "must be a closed mesh"),
        (Spec(kind="mesh", file="junk.stl"), 3, "shape.file = "),
        (Spec(kind="mesh", file="none.stl"), 3, "no such file"),
        (Spec(kind="blob"), 3, "must be one of box, sphere"),
        (Spec(kind="layer", bottom=0.0, top=1.0), 3, "needs a .terrain."),
    ]
    for spec, dim, message in cases:
        with pytest.raises(InputError, match=message) as caught:
            fill(spec, dim, base_dir=tmp_path)
        assert len(str(caught.value).splitlines()) == 1
    with pytest.raises(InputError, match=r"solver\.sampling"):
        fill(SHAPES["box2"][0], 2, sampling="dense")


@pytest.mark.parametrize("turn", [1.0, 0.1, 1.0 / 3.0], ids=["tens", "tenths", "thirds"])
def test_rows_on_a_sloping_edge_are_all_inside_or_all_outside(turn):
    """A slope of 45 degrees that runs through the places of a lattice: no row of its face lacks a particle, and of two
    bodies that meet in it each place belongs to one."""
    corners = turn * np.array([[0.0, 0.0], [24.0, 0.0], [24.0, 9.0], [14.0, 9.0], [8.0, 3.0], [0.0, 3.0]])
    over = turn * np.array([[0.0, 3.0], [8.0, 3.0], [14.0, 9.0], [0.0, 9.0]])
    i, k = np.indices((120, 45)).reshape(2, -1)
    points = turn * np.column_stack([0.2 * (i + 0.5), 0.2 * (k + 0.5)])
    inside, above = (Polygons.of([[ring]], "body").contains(points) for ring in (corners, over))
    assert (inside ^ above).all()
    face = (i - k == 25) & (k >= 15)  # x - z = 5
    assert face.sum() == 30 and inside[face].all()
