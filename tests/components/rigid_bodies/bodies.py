"""Free bodies on planes, without snow."""

import numpy as np

from snowmpm.components.rigid_bodies.body import Body
from snowmpm.components.rigid_bodies.mass_properties import MassProperties
from snowmpm.components.rigid_bodies.motion import FreeMotion
from snowmpm.components.rigid_bodies.world import World
from snowmpm.solids.obstacle import Obstacle
from snowmpm.solids.primitives import BALL, BOX
from snowmpm.solids.shape import SolidShape

G = 9.81


def solid(kind, origin, half, angle=0.0):
    """`SolidShape` with its own frame turned by `angle` [rad] from x towards z."""
    origin, dim = np.asarray(origin, float), len(origin)
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[c, s], [-s, c]]) if dim == 2 else np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return SolidShape(kind, origin, axes, np.broadcast_to(half, dim).astype(float))


def body(number, shape, *, density=1000.0, velocity=None, omega=None, spacing=0.05, **contact):
    motion = FreeMotion(MassProperties.of(shape, density), velocity, omega)
    return Body(number, Obstacle(f"body_{number}", shape, motion), spacing, **contact)


def plane(angle, dim=2):
    """query(points) of a plane through the origin that falls towards +x at `angle` [rad]; its unit vectors down the
    slope and out of it."""
    down, out = np.zeros(dim), np.zeros(dim)
    down[[0, -1]] = np.cos(angle), -np.sin(angle)
    out[[0, -1]] = np.sin(angle), np.cos(angle)
    return (lambda points: (points @ out, np.broadcast_to(out, points.shape).copy())), down, out


def world(*bodies, **what):
    made = World(bodies, **what)
    made.begin()
    return made


def let_go(made, duration, dt=1e-3, g=G):
    """Steps of a `World` under gravity downwards, without snow."""
    first = made.bodies[0].motion
    gravity = np.zeros(len(first.centre))
    gravity[-1] = -g
    totals = np.zeros((len(made.bodies), len(first.centre) + len(first.spin) + 1))
    for n in range(round(duration / dt)):
        made.advance(n * dt, dt, gravity, totals)


def on_slope(kind, half, angle, dim=2, height=None, **more):
    """A body that lies on a plane, turned with it, its lowest point at the plane."""
    query, down, out = plane(angle, dim)
    half = np.broadcast_to(half, dim).astype(float)
    shape = solid(kind, (half[-1] if height is None else height) * out, half, -angle)
    return world(body(0, shape, **more), ground=query), down, out


__all__ = ["BALL", "BOX", "G", "body", "let_go", "on_slope", "plane", "solid", "world"]
