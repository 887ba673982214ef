"""Free rigid bodies without snow (X3): sliding, rolling, toppling, collisions, spinning in flight."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.components.rigid_bodies import impulses
from snowmpm.components.rigid_bodies.mass_properties import MassProperties
from snowmpm.solids.primitives import CYLINDER
from snowmpm.solids.shape import SolidShape
from tests.components.rigid_bodies.bodies import BALL, BOX, G, body, let_go, on_slope, plane, solid, world


@pytest.mark.parametrize("dim", [2, 3])
def test_a_block_slides_down_a_slope_as_coulomb_says(dim):
    """M12: g (sin 24 - tan 15 cos 24) = 1.58875771 m/s2."""
    made, down, _ = on_slope(BOX, [0.05] * (dim - 1) + [0.025], np.radians(24.0), dim,
                             friction=np.tan(np.radians(15.0)))
    let_go(made, 1.0, dt=5e-3)
    motion = made.bodies[0].motion
    assert motion.velocity @ down == pytest.approx(1.58875771, rel=1e-7)
    # Symplectic Euler: half a step ahead
    assert motion.centre @ down == pytest.approx(0.5 * 1.58875771 * (1.0 + 5e-3), rel=1e-6)
    assert np.linalg.norm(motion.omega) < 1e-9


def test_a_block_rests_where_friction_holds_it():
    made, _, _ = on_slope(BOX, [0.05, 0.025], np.radians(24.0), friction=np.tan(np.radians(24.5)))
    start = made.bodies[0].motion.centre.copy()
    let_go(made, 2.0, dt=5e-3)
    assert np.abs(made.bodies[0].motion.centre - start).max() < 1e-9


@pytest.mark.parametrize(("dim", "friction"), [(2, 0.5), (2, 0.1), (3, 0.5), (3, 0.1)])
def test_a_disc_and_a_sphere_roll_or_slip(dim, friction):
    """M13: they roll with a = 2/3 or 5/7 g sin where mu > tan / 3 or 2/7 tan, else slip."""
    slope, share = np.radians(30.0), 0.5 if dim == 2 else 0.4
    made, down, _ = on_slope(BALL, 0.5, slope, dim, friction=friction)
    let_go(made, 1.0, dt=4e-3)
    motion = made.bodies[0].motion
    if friction == 0.5:
        speed, rim = G * np.sin(slope) / (1.0 + share), G * np.sin(slope) / (1.0 + share)
    else:
        speed, rim = G * (np.sin(slope) - friction * np.cos(slope)), friction * G * np.cos(slope) / share
    assert motion.velocity @ down == pytest.approx(speed, rel=1e-6)
    assert 0.5 * np.linalg.norm(motion.omega) == pytest.approx(rim, rel=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("excess", "topples"), [(-0.5, False), (0.5, True)])
def test_a_block_topples_where_its_weight_leaves_its_base(dim, excess, topples):
    """b / h = tan of the tipping angle: 0.4 m by 1 m tips at 21.80 degrees."""
    angle = np.arctan(0.4) + np.radians(excess)
    half = [0.2, 0.5] if dim == 2 else [0.2, 0.3, 0.5]
    made, _, _ = on_slope(BOX, half, angle, dim, friction=2.0)
    let_go(made, 2.0, dt=4e-3)
    turned = np.arccos(np.clip(made.bodies[0].motion.rotation[-1, -1], -1.0, 1.0))
    assert turned > 0.5 if topples else turned < 1e-6


def test_a_block_falls_over_as_a_pendulum_does():
    """A block that turns about its lower edge: (I + M r2) theta'' = M g r sin(theta), theta from the upright."""
    half, angle = np.array([0.1, 0.5]), np.arctan(0.2) + 0.02
    made, _, _ = on_slope(BOX, half, angle, friction=50.0)
    r = np.linalg.norm(half)
    inertia = (half @ half) / 3.0 + r**2
    first = angle - np.arctan(0.2)
    exact = solve_ivp(lambda t, y: [y[1], G * r * np.sin(y[0]) / inertia], [0.0, 1.0], [first, 0.0], rtol=1e-10)
    let_go(made, 1.0, dt=5e-4)
    assert -made.bodies[0].motion.turn[0] == pytest.approx(exact.y[0, -1] - first, rel=0.01)


@pytest.mark.parametrize("spacing", [0.05, 0.1])
def test_twice_as_many_points_change_nothing(spacing):
    """N_C of B 133-137: forces do not depend on how many points a body has."""
    found = []
    for step in (spacing, 0.5 * spacing):
        made, _, _ = on_slope(BOX, [0.2, 0.3, 0.1], 0.3, 3, height=0.25, friction=0.4, spacing=step,
                              omega=[1.0, 0.5, 0.3])
        let_go(made, 0.8, dt=4e-3)
        found.append([*made.bodies[0].motion.centre, *made.bodies[0].impulse])
    assert np.allclose(found[0], found[1], rtol=0.01, atol=1e-3 * np.abs(found[0]).max())


@pytest.mark.parametrize("dim", [2, 3])
def test_bodies_that_collide_keep_their_momenta(dim):
    """Also the angular one: two boxes that meet askew."""
    along = np.eye(dim)
    one = body(0, solid(BOX, 0.0 * along[0], 0.1, 0.3), velocity=2.0 * along[0], friction=0.3, restitution=0.5)
    other = body(1, solid(BOX, 0.33 * along[0] + 0.06 * along[-1], 0.12, -0.2), density=300.0, friction=0.6)
    made = world(one, other)

    def momenta():
        motions = [each.motion for each in made.bodies]
        p = sum(m.mass_properties.mass * m.velocity for m in motions)
        cross = np.cross if dim == 3 else lambda a, b: np.array([a[0] * b[1] - a[1] * b[0]])
        return p, sum(m.spin + m.mass_properties.mass * cross(m.centre, m.velocity) for m in motions)

    before, start = momenta(), other.motion.velocity.copy()
    let_go(made, 0.3, g=0.0)
    after = momenta()
    assert np.linalg.norm(other.motion.velocity - start) > 0.5 and np.linalg.norm(one.motion.spin) > 1e-3
    for was, now in zip(before, after, strict=True):
        assert np.allclose(now, was, rtol=0.0, atol=1e-12 * np.linalg.norm(before[0]))
    assert made.row(np.zeros(dim))["rigid_momentum_residual"] < 1e-14


@pytest.mark.parametrize("bounce", [0.0, 0.7, 1.0])
def test_restitution_is_speed_after_over_speed_before(bounce):
    query, _, _ = plane(0.0, 3)
    ball = body(0, solid(BALL, [0.0, 0.0, 0.6], 0.5), velocity=[0.0, 0.0, -2.0], restitution=bounce)
    made = world(ball, ground=query)
    let_go(made, 0.2, g=0.0)
    assert made.bodies[0].motion.velocity[2] == pytest.approx(2.0 * bounce, abs=1e-12)


def test_a_body_that_tumbles_keeps_its_angular_momentum_and_energy():
    """Free rotation about the middle axis, which is unstable: Euler's equations by an independent integrator."""
    half, omega = np.array([0.1, 0.2, 0.4]), np.array([0.05, 6.0, 0.05])
    one = body(0, solid(BOX, np.zeros(3), half), omega=omega)
    made, motion = world(one), one.motion
    inertia, spin, energy = np.diag(motion.mass_properties.inertia), motion.spin.copy(), motion.energy

    def euler(_, w):
        return np.cross(inertia * w, w) / inertia

    exact = solve_ivp(euler, [0.0, 3.0], omega, rtol=1e-11, atol=1e-12).y[:, -1]
    let_go(made, 3.0, dt=2e-3, g=0.0)
    assert np.array_equal(motion.spin, spin)
    assert motion.energy == pytest.approx(energy, rel=1e-5)
    assert np.allclose(motion.rotation.T @ motion.omega, exact, atol=0.02 * np.linalg.norm(exact))


def test_a_stack_stands_still():
    """Six blocks, each on the one below."""
    query, _, _ = plane(0.0)
    made = world(*(body(i, solid(BOX, [0.0, 0.1 + 0.2 * i], 0.1)) for i in range(6)), ground=query)
    let_go(made, 0.4, dt=4e-3)
    for i, each in enumerate(made.bodies):
        assert np.allclose(each.motion.centre, [0.0, 0.1 + 0.2 * i], atol=1e-7)
        assert np.linalg.norm(each.motion.velocity) < 1e-6


SHAPES = {
    "box": SolidShape(BOX, np.array([1.0, 2.0, 3.0]), np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0],
                      np.array([0.1, 0.2, 0.4])),
    "cylinder": SolidShape(CYLINDER, np.array([1.0, 2.0, 3.0]), np.eye(3)[[1, 2, 0]], np.array([0.2, 0.2, 0.5])),
    "ball": SolidShape(BALL, np.array([1.0, 2.0, 3.0]), np.eye(3), np.full(3, 0.3)),
    "rectangle": solid(BOX, [1.0, 2.0], [0.1, 0.3], 0.4), "disc": solid(BALL, [1.0, 2.0], [0.3, 0.3])}


@pytest.mark.parametrize("name", list(SHAPES))
def test_matter_is_that_of_the_volume(name):
    """Against sums over a lattice of points inside the shape."""
    shape = SHAPES[name]
    dim, reach, n = shape.dim, np.linalg.norm(shape.size), 401 if shape.dim == 2 else 101
    line = np.linspace(-reach, reach, n)
    x = np.stack(np.meshgrid(*[line] * dim, indexing="ij"), axis=-1).reshape(-1, dim) + shape.origin
    x = x[shape.query(x)[0] < 0.0]
    cell = (line[1] - line[0]) ** dim
    found = MassProperties.of(shape, 10.0)
    arm = x - found.centre
    r2 = (arm**2).sum(axis=1)
    inertia = 10.0 * cell * (np.array([[r2.sum()]]) if dim == 2 else r2.sum() * np.eye(3) - arm.T @ arm)
    assert found.mass == pytest.approx(10.0 * cell * len(x), rel=0.02)
    assert np.allclose(x.mean(axis=0), found.centre, atol=0.01 * reach)
    assert np.allclose(inertia, found.inertia, rtol=0.0, atol=0.03 * np.abs(found.inertia).max())


def test_matter_of_a_polygon_and_of_a_mesh(tmp_path):
    import trimesh

    from snowmpm.scenes.shapes import Polygon, SolidMesh

    points = [[1.0, 1.0], [1.4, 1.0], [1.4, 1.2], [1.0, 1.2]]
    for corners in (points, points[::-1]):
        found = MassProperties.of(SolidShape.of(Polygon(kind="polygon", points=corners), 2), mass=7.0)
        assert found.mass == 7.0 and np.allclose(found.centre, [1.2, 1.1])
        assert np.allclose(found.inertia, [[7.0 * (0.4**2 + 0.2**2) / 12.0]])
    box = trimesh.creation.box(extents=[0.2, 0.4, 0.8])
    box.apply_translation([5.0, 6.0, 7.0])
    box.export(tmp_path / "box.stl")
    found = MassProperties.of(SolidShape.of(SolidMesh(kind="mesh", file=str(tmp_path / "box.stl")), 3), 100.0)
    # STL is in float32
    assert np.allclose(found.centre, [5.0, 6.0, 7.0]) and found.mass == pytest.approx(6.4, rel=1e-5)
    assert np.allclose(found.inertia, np.diag([0.8, 0.68, 0.2]) * 6.4 / 12.0, atol=1e-5)


@pytest.mark.parametrize(("sweeps", "all_settle"), [(2000, True), (1, False)])
def test_contact_that_does_not_settle_is_counted(monkeypatch, sweeps, all_settle):
    """Three boxes on each other on a floor: one sweep is not enough."""
    monkeypatch.setattr(impulses, "SWEEPS", sweeps)
    impulses._relax.cache_clear()
    try:
        made = world(*(body(i, solid(BOX, [0.0, 0.1 + 0.2 * i], 0.1, 0.0)) for i in range(3)), ground=plane(0.0)[0])
        let_go(made, 0.05)
    finally:
        impulses._relax.cache_clear()
    assert (made.row(np.zeros(2))["rigid_unsettled"] == 0.0) == all_settle
