"""Made-up runs that look like avalanches: a slab lets go, slides, spreads and comes to rest. No physics in them."""

import numpy as np
import trimesh

from snowmpm.io import RunWriter

RELEASE = (20.0, 55.0)  # m, along x
RUNOUT = 95.0  # m, how far the front travels along x


def height(x, y=0.0):
    """38 degrees for 90 m, an arc, then flat; in 3-D a shallow gully with gentle relief."""
    slope, bend, flat = np.tan(np.radians(38.0)), 90.0, 40.0
    s = np.clip((np.asarray(x, float) - bend) / flat, 0.0, None)
    drop = np.where(s <= 0.0, x * slope, bend * slope + slope * flat * np.where(s < 1.0, s - 0.5 * s**2, 0.5))
    relief = 0.004 * np.clip(y, -70.0, 70.0) ** 2 / (1.0 + np.exp((np.asarray(x) - 110.0) / 15.0))
    waves = 1.2 * np.sin(np.asarray(x) / 11.0) * np.sin(np.asarray(y) / 9.0)
    return 90.0 - drop + relief + waves


def _travel(start, t, rng, width):
    """Position along x and share of the way done, for particles that start at `start` and let go one after another."""
    back = (start - RELEASE[0]) / (RELEASE[1] - RELEASE[0])
    reach = RUNOUT * (0.7 + 0.3 * back) + rng.normal(0.0, 2.5, len(start))
    share = np.clip((t - 0.4 - 0.5 * (1.0 - back)) / (5.5 + 0.7 * width), 0.0, 1.0)
    return start + reach * share**2 * (3.0 - 2.0 * share), share


def slab_2d(path, *, spacing=0.12, frames=12, duration=8.0, thickness=0.6, extra=0, obstacles=False):
    """A 2-D run; `extra` more particles that fly off, as a real run has them; `obstacles`: a wall, and a wheel that
    rolls uphill."""
    rng = np.random.default_rng(2)
    along, up = np.meshgrid(np.arange(*RELEASE, spacing), np.arange(0.5 * spacing, thickness, spacing))
    along, up = along.ravel() + rng.normal(0, 0.05 * spacing, along.size), up.ravel()
    ground = np.linspace(-5.0, 190.0, 300)
    vertices = np.column_stack([ground, height(ground)])
    facets = np.column_stack([np.arange(299), np.arange(1, 300)])

    def positions(t):
        keep = np.random.default_rng(3)
        x, share = _travel(along, t, keep, up / thickness)
        lift = up * (1.0 + 0.5 * np.sin(np.pi * share) * keep.random(len(up)))
        return np.column_stack([x, height(x) + lift / np.cos(np.radians(30.0))])

    damage = (up < 1.5 * spacing).astype(float)
    drawings = {}
    if obstacles:
        base = height(120.0)
        angle = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
        wheel = np.array([110.0, height(110.0) + 5.0]) + 4.0 * np.column_stack([np.cos(angle), np.sin(angle)])
        wall = np.array([[118.0, base - 2.0], [121.0, base - 2.0], [120.0, base + 9.0], [119.0, base + 9.0]])
        drawings = {"wall": (wall, _ring(4)), "wheel": (wheel, _ring(12))}
    _write(path, 2, positions, frames, duration, (vertices, facets), spacing**2, {"damage": damage}, extra,
           obstacles=drawings)


def slab_3d(
    path, *, particles=20000, frames=8, duration=8.0, thickness=1.2, cell=2.5, origin=(0.0, 0.0, 0.0), hole=False,
    obstacles=False, far=0.0
):
    """A 3-D run on a gully of triangles of side `cell`; with `hole`, a patch of the terrain is missing; `obstacles`: a
    house and a mast that falls over; far [m]: more terrain on each side."""
    rng = np.random.default_rng(2)
    width = 44.0
    along = rng.uniform(*RELEASE, particles)
    across = rng.uniform(-0.5 * width, 0.5 * width, particles)
    inside = (across / (0.5 * width)) ** 2 < 0.55 + 0.45 * (along - RELEASE[0]) / 35.0
    along, across = along[inside], across[inside]
    up = rng.uniform(0.0, thickness, len(along))
    volume = 35.0 * width * thickness / particles

    def positions(t):
        keep = np.random.default_rng(3)
        x, share = _travel(along + 2.0 * np.sin(across / 6.0), t, keep, up / thickness)
        y = across * (1.0 - 0.9 * share + 1.0 * share**2) + keep.normal(0.0, 1.2, len(x)) * share
        lift = up * (1.0 + 2.0 * np.sin(np.pi * share) * keep.random(len(up)))
        return np.column_stack([x, y, height(x, y) + lift / np.cos(np.radians(30.0))])

    drawings = {}
    if obstacles:
        house, mast = trimesh.creation.box(extents=[8.0, 10.0, 14.0]), trimesh.creation.cylinder(0.6, 20.0)
        house.apply_translation([125.0, 6.0, height(125.0, 6.0)])
        mast.apply_translation([118.0, -12.0, height(118.0, -12.0) + 9.0])
        drawings = {"house": (house.vertices, house.faces), "mast": (mast.vertices, mast.faces)}
    _write(path, 3, positions, frames, duration, gully(cell, hole, far), volume, {}, 0, origin, drawings)


def saw_column(path, dimension, *, slope=0.0, frames=3, length=2.0, spacing=0.025):
    """A saw test that stands still while its saw goes 0.5 m a second, in `frames` seconds: a slab of 0.3 m on a weak
    layer of 0.05 m on the ground, which the saw takes away."""
    half = 0.15
    across = np.arange(-half + 0.5 * spacing, half, spacing) if dimension == 3 else np.zeros(1)
    x, y, z = (g.ravel() for g in np.meshgrid(np.arange(0.5 * spacing, length, spacing), across,
                                              np.arange(0.5 * spacing, 0.35, spacing), indexing="ij"))
    scene = f"""
dimension = {dimension}
[solver]
dx = {2.0 * spacing}
[saw_test]
length = {length}
slope_angle = {slope}
weak_layer = {{ material = "weak", thickness = 0.01, cells = 1 }}
[[saw_test.slab]]
material = "slab"
thickness = 0.3
"""
    middles = np.arange(0.05, length, 0.1)
    test = {"about": {"length": length, "slope_angle": slope, "notch": 0.0}, "series": {"time": "s", "saw": "m"},
            "lines": {}, "bins": {"x": (middles, "m")}}
    record = {"scene_name": "column", "scene": scene, "materials": ["slab", "weak"], "particle_spacing": spacing}
    with RunWriter(path, provenance=record, dimension=dimension, units={"velocity": "m/s"}, saw_test=test) as writer:
        for i in range(frames):
            writer.history(float(i), {"max_speed": 0.0}, {})
            left = (z > 2.0 * spacing) | (x > 0.5 * i)
            writer.frame(float(i), np.column_stack([x, y, z])[left], {"velocity": np.zeros((left.sum(), 3))},
                         saw_test=({"time": np.array([float(i)]), "saw": np.array([0.5 * i])}, {}))


def weak_layer_3d(path, *, spacing=0.5, frames=3):
    """A slab of 20 m by 12 m on a weak layer on a plane of 30 degrees; the weak layer breaks from its middle outwards
    along x, and nothing moves. Scene text, bodies and materials as a run has them."""
    x, y, up = (g.ravel() for g in np.meshgrid(np.arange(0.0, 20.0, spacing), np.arange(-6.0, 6.0, spacing),
                                               np.arange(0.5 * spacing, 2.0, spacing), indexing="ij"))
    z = -np.tan(np.radians(30.0)) * x
    material = np.where(up < 1.0, 1, 0).astype(np.int32)
    scene = """
[materials.slab]
kind = "cohesive_cam_clay"
[materials.weak]
kind = "anticrack_cam_clay"
[[bodies]]
name = "weak_layer"
material = "weak"
shape = { kind = "layer", bottom = 0.0, top = 1.0 }
[[bodies]]
name = "slab"
material = "slab"
shape = { kind = "layer", bottom = 1.0, top = 2.0 }
[[events]]
kind = "cut"
body = "weak_layer"
"""
    corners = np.array([[-20.0, -20.0, 0.0], [40.0, -20.0, 0.0], [40.0, 20.0, 0.0], [-20.0, 20.0, 0.0]])
    corners[:, 2] = -np.tan(np.radians(30.0)) * corners[:, 0]
    record = {"scene_name": "cut", "scene": scene, "materials": ["slab", "weak"], "particle_spacing": spacing}
    with RunWriter(path, provenance=record, terrain=(corners, np.array([[0, 1, 2], [0, 2, 3]])), dimension=3,
                   units={"damage": "1", "velocity": "m/s"}) as writer:
        for i in range(frames):
            reach = 10.0 * i / (frames - 1)
            damage = ((material == 1) & (np.abs(x - 10.0) < reach)).astype(float)
            writer.history(float(i), {"max_speed": 1.0 * i, "kinetic_energy": float(i)}, {})
            writer.frame(float(i), np.column_stack([x, y, z + up]),
                         {"damage": damage, "material": material, "velocity": np.zeros((len(x), 3))})


def _ring(n):
    return np.column_stack([np.arange(n), np.roll(np.arange(n), -1)])


def moves(name, t, dimension):
    """Rotation and translation of an obstacle of these runs at time t: the wheel rolls uphill, the mast falls."""
    turn = 0.12 * t if name in ("wheel", "mast") else 0.0
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.eye(dimension)
    rotation[np.ix_([0, -1], [0, -1])] = [[c, s if dimension == 3 else -s], [-s if dimension == 3 else s, c]]
    centre = np.array([110.0, height(110.0) + 5.0] if dimension == 2 else [118.0, -12.0, height(118.0, -12.0)])
    shift = 0.12 * 4.0 * t * np.array([-1.0, 0.35]) if name == "wheel" else 0.0
    return rotation, centre - rotation @ centre + shift


def gully(cell, hole=False, far=0.0):
    """(vertices, triangles) of the slope, with `far` [m] more on each side."""
    x, y = np.meshgrid(np.arange(-15.0 - far, 200.0 + far, cell), np.arange(-70.0 - far, 70.01 + far, cell),
                       indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), height(x, y).ravel()])
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    facets = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    if hole:
        centre = vertices[facets].mean(axis=1)
        facets = facets[np.hypot(centre[:, 0] - 150.0, centre[:, 1] - 35.0) > 15.0]
    return vertices, facets


def _write(path, dimension, positions, frames, duration, terrain, volume, constant, extra, origin=None, obstacles=None):
    units = {"velocity": "m/s", "density": "kg/m3", "volume": "m3" if dimension == 3 else "m2"}
    record = {"scene_name": "made_up_slab", "attribution": "synthetic slope"}
    options = {"terrain": terrain, "obstacles": obstacles, "origin": origin, "dimension": dimension, "units": units}
    with RunWriter(path, provenance=record, **options) as writer:
        for t in np.linspace(0.0, duration, frames):
            x, later = positions(t), positions(t + 0.01)
            velocity = (later - x) / 0.01
            if extra:
                x[:extra] += np.outer(
                    np.linspace(0.5, 1.0, extra), [40.0 * t, 60.0 * t] if dimension == 2 else [40.0 * t] * 3
                )
            fields = {
                "velocity": velocity,
                "density": 250.0 - 3.0 * np.linalg.norm(velocity, axis=1),
                "volume": np.full(len(x), volume),
                **constant,
            }
            speed = np.linalg.norm(velocity, axis=1)
            writer.history(t, {"max_speed": speed.max(), "front": x[:, 0].max()}, {"max_speed": "m/s", "front": "m"})
            poses = {name: moves(name, t, dimension) for name in obstacles or {}}
            writer.frame(t, x, fields, poses)
        if dimension == 3:
            ny, nx = 60, 90
            yy, xx = np.mgrid[0:ny, 0:nx]
            depth = np.exp(-(((xx - 50) / 20) ** 2) - ((yy - 30) / 8) ** 2) * 2.0
            writer.map("peak_depth", np.where(depth > 0.05, depth, np.nan), 0.0, -60.0, 2.0, "m")
