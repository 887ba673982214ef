"""Contact of free bodies in a step: impulses that keep them from sinking into anything."""

import numpy as np

from snowmpm.components.rigid_bodies.contact_points import tangents
from snowmpm.components.rigid_bodies.impulses import impulses

SINK = 1e-4
"""Overlap, over the radius of a body, that is left as it is: more is taken out by degrees."""

RELIEF = 0.2
"""Share of the overlap beyond that which is taken out in a step."""

BOUNCE = 4.0
"""Speed of approach over what gravity adds in a step, above which restitution acts: resting bodies do not jump."""


def resolve(acting, touches, dt, g, warm):
    """Give bodies the impulses of their `ContactPoints` in a step of dt [s] under gravity g [m/s2].

    acting: `Body`s that move; others are held. warm: impulses (dim,) [N s] of the step before by touch, from which the
    sweeps begin; -> those of this step, and whether the sweeps came to an end.
    """
    points, normals, gaps = (np.concatenate([vars(touch)[name] for touch in touches])
                             for name in ("points", "normals", "gaps"))
    counts = [len(touch.gaps) for touch in touches]
    friction, restitution, radius = (np.repeat(values, counts) for values in zip(
        *((touch.friction, touch.restitution, touch.first.radius) for touch in touches), strict=True))
    dim = points.shape[1]
    frame = np.concatenate([normals[:, None], tangents(normals)], axis=1)
    state = _State(acting)
    jacobian, relative = np.zeros((len(points), dim, len(acting), state.width)), -np.concatenate(
        [touch.velocity for touch in touches])
    for name, sign in (("first", 1.0), ("second", -1.0)):
        owner = np.repeat([state.row(vars(touch)[name]) for touch in touches], counts)
        at = np.flatnonzero(owner >= 0)
        owner, arms = owner[at], points[at] - state.centre[owner[at]]
        relative[at] += sign * (state.velocity[owner] + _turned(state.omega[owner], arms))
        jacobian[at, :, owner, :dim] = sign * frame[at]
        jacobian[at, :, owner, dim:] = sign * _moment(arms[:, None], frame[at])
    speeds = np.einsum("kad,kd->ka", frame, relative)
    least = _least_speed(gaps, restitution, radius, speeds[:, 0], dt, g)
    answer = np.einsum("kabi,bij->kabj", jacobian, state.inverse_mass).reshape(len(points) * dim, -1)
    jacobian = jacobian.reshape(len(points) * dim, -1)
    keys = [(touch.first.number, touch.surface, number) for touch in touches for number in touch.numbers.tolist()]
    # Kept in space, so that a patch that turns keeps its friction
    nothing = np.zeros(dim)
    start = np.einsum("kad,kd->ka", frame, np.array([warm.get(key, nothing) for key in keys]))
    found, settled = impulses(answer @ jacobian.T, speeds, least, friction, start)
    given = (jacobian.T @ found.ravel()).reshape(len(acting), state.width)
    for body, push in zip(acting, given, strict=True):
        body.push(push[:dim], push[dim:])
    return dict(zip(keys, np.einsum("kad,ka->kd", frame, found), strict=True)), settled


class _State:
    """Motion of bodies as arrays, a row each: centre, velocity (n, dim), omega (n, 1 or 3), inverse_mass (n, width,
    width) of translation and rotation."""

    def __init__(self, bodies):
        motions = [body.motion for body in bodies]
        self.centre = np.array([motion.centre for motion in motions])
        self.velocity = np.array([motion.velocity for motion in motions])
        self.omega = np.array([motion.omega for motion in motions])
        dim = self.centre.shape[1]
        self.width = dim + self.omega.shape[1]
        self._rows = {body.number: i for i, body in enumerate(bodies)}
        self.inverse_mass = np.zeros((len(bodies), self.width, self.width))
        for matrix, motion in zip(self.inverse_mass, motions, strict=True):
            matrix[:dim, :dim] = np.eye(dim) / motion.mass_properties.mass
            matrix[dim:, dim:] = motion.inverse_inertia

    def row(self, body):
        """Number of a body's row, -1 of one that is held and of None."""
        return -1 if body is None else self._rows.get(body.number, -1)


def _least_speed(gaps, restitution, radius, normal_speed, dt, g):
    """Normal speed (k,) [m/s] that contact leaves at least."""
    overlap = -gaps - SINK * radius
    least = np.where(gaps >= 0.0, -gaps, RELIEF * np.maximum(0.0, overlap)) / dt
    meets = (normal_speed < -BOUNCE * g * dt) & (gaps < -normal_speed * dt)
    return np.where(meets & (restitution > 0.0), -restitution * normal_speed, least)


def _turned(omega, arms):
    """omega x arms, rows of omega (k, 1) or (k, 3) and arms (k, dim)."""
    if omega.shape[1] == 3:
        return np.cross(omega, arms)
    return omega * np.stack([-arms[:, 1], arms[:, 0]], axis=1)


def _moment(arm, force):
    """arm x force, (..., 1) in 2-D and (..., 3) in 3-D."""
    if force.shape[-1] == 3:
        return np.cross(arm, force)
    return (arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0])[..., None]
