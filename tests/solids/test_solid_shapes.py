"""Distance to rigid shapes: closed forms, trimesh, and the same numbers inside a kernel wherever the solid has gone."""

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from snowmpm.compiler import runtime, ti
from snowmpm.errors import InputError
from snowmpm.solids import Obstacle, RigidMotion, SolidShape, samples
from snowmpm.solids.motion import Uniform
from snowmpm.solids.samples import DistanceSamples
from snowmpm.solids.table import CODE, FRICTION, REACH, STEP, SolidTable, distance_function

DX = 0.1
L_SHAPE = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]


def shape(dim, folder=".", **spec):
    return SolidShape.of(SimpleNamespace(**spec), dim, folder)


def spread(dim, n=3000, seed=0):
    """Points in a box around shapes near the origin."""
    return np.random.default_rng(seed).uniform(-2.0, 3.0, (n, dim))


def around(d, x, step=1e-6):
    """Central differences of the distance `d` at x (k, dim)."""
    return np.stack([(d(x + step * e) - d(x - step * e)) / (2.0 * step) for e in np.eye(x.shape[1])], axis=1)


def box_reference(x, lower, upper):
    """Distance to the nearest point of the box, or, inside, to the nearest face."""
    outside = np.linalg.norm(x - np.clip(x, lower, upper), axis=1)
    return np.where(outside > 0.0, outside, -np.minimum(x - lower, upper - x).min(axis=1))


def cylinder_reference(x, base, axis, radius, height):
    """The same for a cylinder, from the nearest points of its side and of its ends, each found on its own."""
    axis = np.asarray(axis) / np.linalg.norm(axis)
    h = (x - base) @ axis
    radial = x - base - h[:, None] * axis
    r = np.linalg.norm(radial, axis=1)
    nearest = np.stack([  # on the side; on the two ends
        np.hypot(r - radius, h - np.clip(h, 0.0, height)),
        np.hypot(np.maximum(r - radius, 0.0), h),
        np.hypot(np.maximum(r - radius, 0.0), h - height)]).min(axis=0)
    inside = (r < radius) & (h > 0.0) & (h < height)
    return np.where(inside, -nearest, nearest)


PRIMITIVES = [
    (2, {"kind": "box", "min": (0.2, -0.5), "max": (1.2, 0.7)}, lambda x: box_reference(x, (0.2, -0.5), (1.2, 0.7))),
    (3, {"kind": "box", "min": (0.0, -0.5, 0.3), "max": (1.0, 0.7, 2.0)},
     lambda x: box_reference(x, (0.0, -0.5, 0.3), (1.0, 0.7, 2.0))),
    (2, {"kind": "sphere", "centre": (0.3, 0.4), "radius": 0.9},
     lambda x: np.linalg.norm(x - (0.3, 0.4), axis=1) - 0.9),
    (3, {"kind": "sphere", "centre": (0.3, 0.4, 0.5), "radius": 0.9},
     lambda x: np.linalg.norm(x - (0.3, 0.4, 0.5), axis=1) - 0.9),
    (3, {"kind": "cylinder", "base": (0.2, 0.1, -0.3), "axis": (0.0, 0.0, 2.0), "radius": 0.6, "height": 1.7},
     lambda x: cylinder_reference(x, (0.2, 0.1, -0.3), (0, 0, 1), 0.6, 1.7)),
    (3, {"kind": "cylinder", "base": (0.2, 0.1, -0.3), "axis": (1.0, -2.0, 0.5), "radius": 0.6, "height": 1.7},
     lambda x: cylinder_reference(x, (0.2, 0.1, -0.3), (1, -2, 0.5), 0.6, 1.7)),
]


@pytest.mark.parametrize(("dim", "spec", "reference"), PRIMITIVES)
def test_primitives_match_closed_forms(dim, spec, reference):
    x, solid = spread(dim), shape(dim, **spec)
    distance, normal = solid.query(x)
    assert np.allclose(distance, reference(x), rtol=0.0, atol=1e-14)
    assert (distance < 0.0).sum() > 40 and np.allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=0.0, atol=1e-14)
    slope = around(reference, x)
    smooth = np.abs(np.linalg.norm(slope, axis=1) - 1.0) < 1e-6  # off the inner edges, where it has no gradient
    assert smooth.mean() > 0.99 and np.abs(normal - slope)[smooth].max() < 1e-6
    foot, _ = solid.query(x - distance[:, None] * normal)
    assert np.abs(foot).max() < 1e-14


@pytest.mark.parametrize(("dim", "spec", "reference"), PRIMITIVES)
def test_middle_and_surface_have_a_normal(dim, spec, reference):
    solid = shape(dim, **spec)
    special = np.concatenate([solid.origin[None], solid.origin + np.eye(dim) @ (solid.size[:, None] * solid.axes)])
    distance, normal = solid.query(special)
    assert np.allclose(np.linalg.norm(normal, axis=1), 1.0) and distance[0] < 0.0
    assert np.allclose(distance[1:], 0.0, atol=1e-15) and np.allclose(normal[1:], solid.axes, atol=1e-12)


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("meshes")
    trimesh.creation.icosphere(subdivisions=3, radius=0.9).export(folder / "ball.stl")
    trimesh.creation.annulus(0.4, 1.1, 0.9).export(folder / "ring.stl")
    open_mesh = trimesh.creation.box(extents=[1.0] * 3)
    trimesh.Trimesh(open_mesh.vertices, open_mesh.faces[:-1]).export(folder / "open.stl")
    return folder


@pytest.mark.parametrize("file", ["ball.stl", "ring.stl"])
def test_a_mesh_matches_trimesh(meshes, file):
    x, solid = spread(3, 800), shape(3, meshes, kind="mesh", file=file)
    distance, normal = solid.query(x)
    mesh, size = trimesh.load(meshes / file), 2.0 * np.linalg.norm(solid.size)
    assert (distance[np.linalg.norm(x, axis=1) > 1.5 * size] == size).all()  # cut off there
    x, distance, normal = (values[distance < size] for values in (x, distance, normal))
    assert len(x) > 750 and (distance < 0.0).sum() > 10
    assert np.allclose(distance, -trimesh.proximity.signed_distance(mesh, x), rtol=0.0, atol=1e-7)
    foot = trimesh.proximity.closest_point(mesh, x)[0]
    assert np.allclose(x - distance[:, None] * normal, foot, rtol=0.0, atol=1e-6)


def test_a_mesh_may_be_cut_off_near_its_surface(meshes):
    x = spread(3)
    whole, near = (SolidShape.of(SimpleNamespace(kind="mesh", file="ball.stl"), 3, meshes, reach=reach)
                   for reach in (np.inf, 0.3))
    (distance, normal), (cut, same) = whole.query(x), near.query(x)
    inside_reach = np.abs(distance) < 0.3
    assert 100 < inside_reach.sum() < 1000
    assert np.array_equal(cut[inside_reach], distance[inside_reach])
    assert np.array_equal(same[inside_reach], normal[inside_reach])
    assert np.array_equal(cut[~inside_reach], 0.3 * np.sign(distance[~inside_reach]))


def test_a_polygon_is_inside_where_its_corners_say():
    solid = shape(2, kind="polygon", points=L_SHAPE)
    distance, normal = solid.query([[0.5, 0.5], [1.5, 1.5], [-0.3, -0.4], [1.5, 1.1], [1.9, 0.5], [0.5, 3.0]])
    corner = np.sqrt(0.5)
    assert distance == pytest.approx([-0.5, 0.5, 0.5, 0.1, -0.1, 1.0])
    assert normal[2:] == pytest.approx(np.array([[-0.6, -0.8], [0.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), abs=1e-12)
    assert solid.query([[1.0 - 0.1, 1.0 - 0.1]])[0] == pytest.approx([-0.1 / corner], rel=1e-12)
    again = shape(2, kind="polygon", points=[*L_SHAPE[:2], *L_SHAPE[1:], L_SHAPE[0]])  # repeated points, closed ring
    assert np.array_equal(again.query(spread(2))[0], solid.query(spread(2))[0])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "crosses itself"),
        ([[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]], "crosses itself"),  # touches itself
        ([[0, 0], [1, 0], [2, 0]], "encloses nothing|crosses itself|closed"),
    ],
)
def test_a_polygon_without_an_inside_is_refused(points, message):
    with pytest.raises(InputError, match=message):
        shape(2, kind="polygon", points=points)


def test_a_mesh_without_an_inside_is_refused(meshes):
    with pytest.raises(InputError, match=r"open\.stl.*must be closed"):
        shape(3, meshes, kind="mesh", file="open.stl")
    with pytest.raises(InputError, match="no such file"):
        shape(3, meshes, kind="mesh", file="absent.stl")


def test_samples_are_exact_for_planes_and_of_third_order_on_curved_faces():
    solid = shape(2, kind="sphere", centre=(0.0, 0.0), radius=1.0)
    errors = []
    for spacing in (0.1, 0.05, 0.025):
        x = spread(2, 4000)
        x = x[np.abs(solid.query(x)[0]) < 0.2]
        distance, normal, d, n = on_samples(solid, spacing, x)
        errors.append([np.abs(d - distance).max(), np.abs(n - normal).max()])
    orders = 0.5 * np.log2(np.array(errors[0]) / errors[-1])
    assert orders[0] > 2.8 and orders[1] > 1.8
    assert errors[1][0] < 3e-6  # cells of 0.1, samples of half of that: 3e-5 of a cell
    plane = shape(2, kind="box", min=(-9.0, -9.0), max=(9.0, 0.3))
    x = np.column_stack([np.linspace(-1.0, 1.0, 50), np.linspace(0.1, 0.5, 50)])
    distance, normal, d, n = on_samples(plane, 0.1, x)
    assert np.abs(d - distance).max() < 1e-13 and np.abs(n - normal).max() < 1e-13


def on_samples(solid, spacing, x):
    """Distance and normal at x, exact and interpolated, in float64."""
    found = DistanceSamples.of(lambda y: solid.query(y + solid.origin), -solid.size, solid.size, spacing, 1.0, "solid")
    table = SolidTable([], dim=2, precision="f64", origin=np.zeros(2), dx=1.0)
    table.samples = ti.ndarray(ti.types.vector(4, ti.f64), (len(found.values),))
    table.samples.from_numpy(found.values)
    numbers = np.array([[3, 0, 0, *found.shape, 0]], np.int32)
    sizes = np.array([[0, 0, 0, *found.lower, 0, found.spacing, found.reach, 0]])
    poses = np.zeros((1, table.poses.shape[1]))
    poses[0, :6] = [1, 0, 0, 1, *solid.origin]
    d, n = in_kernel(2, "f64", x, 1, numbers, sizes, poses, table.samples)
    return *solid.query(x), d[0], n[0]


KERNELS = {}


def in_kernel(dim, precision, x, count, numbers, sizes, poses, samples):
    """d (count, k) and n of `count` obstacles at x (k, dim)."""
    real, numpy_real = runtime.DTYPES[precision]
    if (dim, precision) not in KERNELS:
        distance = distance_function(dim, real)

        @ti.kernel
        def ask(count: ti.i32, x: ti.types.ndarray(), numbers: ti.types.ndarray(), sizes: ti.types.ndarray(),
                poses: ti.types.ndarray(), samples: ti.types.ndarray(dtype=ti.types.vector(4, real), ndim=1),
                d: ti.types.ndarray(), n: ti.types.ndarray()):
            for i in range(x.shape[0]):
                for o in range(count):
                    at = ti.Vector([x[i, k] for k in ti.static(range(dim))])
                    found, normal = distance(o, at, numbers, sizes, poses, samples)
                    d[o, i] = found
                    for k in ti.static(range(dim)):
                        n[o, i, k] = normal[k]

        KERNELS[dim, precision] = ask
    d, n = np.zeros((count, len(x)), numpy_real), np.zeros((count, len(x), dim), numpy_real)
    with runtime.precision(precision):
        KERNELS[dim, precision](count, x.astype(numpy_real), numbers, sizes, poses, samples, d, n)
    return d, n


@pytest.mark.parametrize(("dim", "precision", "tolerance"), [(2, "f64", 1e-12), (3, "f32", 2e-4)])
def test_kernels_see_the_moved_solid_as_numpy_does(meshes, dim, precision, tolerance):
    """Tolerance in cells: a position of up to 50 cells has an error of 4e-6 cells in float32, normals more near the
    middle of the solid. Sampled solids: 0.1 cells within a cell of a sharp edge, see below for the rest."""
    omega = 0.7 if dim == 2 else np.array([0.3, -0.5, 0.7])
    course = Uniform(np.full(dim, 0.2), omega, 0.1, None, 0.5)
    specs = [spec for own, spec, _ in PRIMITIVES if own == dim]
    specs += [{"kind": "polygon", "points": L_SHAPE}] if dim == 2 else [{"kind": "mesh", "file": "ball.stl"}]
    solids = [shape(dim, meshes, **spec) for spec in specs]
    obstacles = [Obstacle(f"o{i}", solid, RigidMotion(solid.origin + 0.3, course), "slip", 0.1 * i)
                 for i, solid in enumerate(solids)]
    origin = np.full(dim, -2.5)
    table = SolidTable(obstacles, dim=dim, precision=precision, origin=origin, dx=DX)
    x = spread(dim)
    for time in (0.0, 1.3):
        table.move(time)
        found = in_kernel(dim, precision, (x - origin) / DX, len(obstacles), table.numbers, table.sizes, table.poses,
                          table.samples)
        for o, (obstacle, d, n) in enumerate(zip(obstacles, *found, strict=True)):
            distance, normal = obstacle.query_at(x, time)
            sampled = obstacle.shape.surface is not None
            near = np.abs(distance) < 0.9 * REACH * DX if sampled else np.ones(len(x), bool)
            error, turned = np.abs(d * DX - distance)[near] / DX, np.abs(n - normal)[near].max(axis=1)
            if sampled:
                assert error.max() < 0.1 and np.quantile(error, 0.8) < (1e-12 if dim == 2 else 5e-3)
                assert np.quantile(turned, 0.8) < (1e-12 if dim == 2 else 0.05)
                assert ((d > 0.0) == (distance > 0.0))[np.abs(distance) > 0.1 * DX].all()
            else:
                assert error.max() < tolerance and np.quantile(turned, 0.999) < tolerance
            lower, upper = (corner[o] * DX + origin for corner in table.boxes())
            inside = x[distance < 0.0]
            assert (inside > lower).all() and (inside < upper).all()
            assert table.numbers.to_numpy()[o, CODE] == obstacle.code == 2
            assert table.sizes.to_numpy()[o, FRICTION] == pytest.approx(0.1 * o)
    assert np.abs(np.concatenate([o.bounds_at(1.3) for o in obstacles]) - table_boxes(table, origin)).max() < 1e-12


def table_boxes(table, origin):
    lower, upper = table.boxes()
    return np.stack([lower, upper], axis=1).reshape(-1, table.dim) * DX + origin


@pytest.mark.parametrize(("dim", "spec", "reference"), PRIMITIVES)
def test_no_point_is_faster_than_the_speed_of_the_solid(dim, spec, reference):
    solid = shape(dim, **spec)
    course = Uniform(np.full(dim, 0.4), 1.7 if dim == 2 else np.array([0.3, -1.5, 0.7]), 0.0, 3.0, 0.5)
    obstacle = Obstacle("o", solid, RigidMotion(solid.origin + 0.3, course))
    for time in (0.3, 2.0):
        points = obstacle.motion.moved(solid.drawing()[0], time)
        fastest = np.linalg.norm(obstacle.velocity_at(points, time), axis=1).max()
        assert fastest <= obstacle.speed_at(time) < 2.5 * fastest
    assert obstacle.speed_at(4.0) == 0.0


def test_a_solid_that_stands_is_moved_once(monkeypatch):
    solid = shape(2, kind="sphere", centre=(0.0, 0.0), radius=0.5)
    table = SolidTable([Obstacle("o", solid, RigidMotion(solid.origin))], dim=2, precision="f64", origin=[0, 0], dx=DX)
    table.move(0.0)
    before = table.poses.copy()
    monkeypatch.setattr(RigidMotion, "pose", None)
    table.move(1.0)
    assert np.array_equal(table.poses, before)


@pytest.mark.parametrize(("dim", "spec", "reference"), PRIMITIVES)
def test_drawings_lie_on_the_surface_and_enclose_it(dim, spec, reference):
    solid = shape(dim, **spec)
    vertices, facets = solid.drawing()
    assert np.abs(reference(vertices)).max() < 1e-12
    middles = vertices[facets].mean(axis=1)
    assert reference(middles).min() > -0.01 and facets.shape[1] == dim
    if dim == 3:
        assert trimesh.Trimesh(vertices, facets).is_watertight
    else:
        assert np.array_equal(facets[:, 1], np.roll(facets[:, 0], -1))


def test_a_large_mesh_gets_coarser_samples_and_too_large_a_one_is_refused(meshes, monkeypatch):
    solid = shape(3, meshes, kind="mesh", file="ball.stl")
    ball = Obstacle("ball", solid, RigidMotion(solid.origin))
    options = {"dim": 3, "precision": "f32", "origin": np.zeros(3)}
    monkeypatch.setattr(samples, "LARGEST", 50_000)
    steps = [SolidTable([ball], dx=dx, **options).sizes.to_numpy()[0, STEP] for dx in (0.2, 0.1)]
    assert steps == [0.5, 1.0]
    with pytest.raises(InputError, match="obstacle ball: too large for this"):
        SolidTable([ball], dx=0.05, **options)
