"""Contact of free bodies in a step: impulses that keep them from sinking into anything."""

import numpy as np

from snowmpm.rigid.impulses import impulses
from snowmpm.rigid.touch import tangents

SINK = 1e-4
"""Overlap, over the radius of a body, that is left as it is: more is taken out by degrees."""

RELIEF = 0.2
"""Share of the overlap beyond that which is taken out in a step."""

BOUNCE = 4.0
"""Speed of approach over what gravity adds in a step, above which restitution acts: resting bodies do not jump."""


def resolve(acting, touches, dt, g, warm):
    """Give bodies the impulses of their `Touch`es in a step of dt [s] under gravity g [m/s2].

    acting: `Body`s that move; others are held. warm: impulses (dim,) [N s] of the step before by touch, from which the
    sweeps begin; -> those of this step, and whether the sweeps came to an end.
    """
    dim = len(acting[0].motion.centre)
    width = dim + len(acting[0].motion.spin)
    column = {body.number: i * width for i, body in enumerate(acting)}
    frames = [np.concatenate([touch.normals[:, None], tangents(touch.normals)], axis=1) for touch in touches]
    rows, speeds, biases = [], [], []
    for touch, frame in zip(touches, frames, strict=True):
        jacobian, relative = np.zeros((len(frame), dim, len(acting) * width)), -touch.velocity
        for body, sign in ((touch.first, 1.0), (touch.second, -1.0)):
            if body is None or body.number not in column:
                continue
            relative = relative + sign * body.velocity_at(touch.points)
            at = column[body.number]
            jacobian[..., at : at + dim] = sign * frame
            jacobian[..., at + dim : at + width] = sign * _moment((touch.points - body.motion.centre)[:, None], frame)
        along = np.einsum("kad,kd->ka", frame, relative)
        rows.append(jacobian)
        speeds.append(along)
        biases.append(_least_speed(touch, along[:, 0], dt, g))
    jacobian = np.concatenate(rows).reshape(-1, len(acting) * width)
    frame = np.concatenate(frames)
    keys = [(touch.first.number, touch.surface, int(number)) for touch in touches for number in touch.numbers]
    # Kept in space, so that a patch that turns keeps its friction
    start = np.einsum("kad,kd->ka", frame, np.array([warm.get(key, np.zeros(dim)) for key in keys]))
    friction = np.concatenate([np.full(len(touch.gaps), touch.friction) for touch in touches])
    found, settled = impulses(jacobian @ _inverse_mass(acting, width) @ jacobian.T, np.concatenate(speeds),
                              np.concatenate(biases), friction, start)
    given = (jacobian.T @ found.ravel()).reshape(len(acting), width)
    for body, push in zip(acting, given, strict=True):
        body.push(push[:dim], push[dim:])
    return dict(zip(keys, np.einsum("kad,ka->kd", frame, found), strict=True)), settled


def _least_speed(touch, normal_speed, dt, g):
    """Normal speed (k,) [m/s] that contact leaves at least."""
    overlap = -touch.gaps - SINK * touch.first.radius
    least = np.where(touch.gaps >= 0.0, -touch.gaps, RELIEF * np.maximum(0.0, overlap)) / dt
    meets = (normal_speed < -BOUNCE * g * dt) & (touch.gaps < -normal_speed * dt)
    return np.where(meets & (touch.restitution > 0.0), -touch.restitution * normal_speed, least)


def _inverse_mass(bodies, width):
    inverse = np.zeros((len(bodies) * width, len(bodies) * width))
    for i, body in enumerate(bodies):
        dim, at = len(body.motion.centre), i * width
        inverse[at : at + dim, at : at + dim] = np.eye(dim) / body.motion.matter.mass
        inverse[at + dim : at + width, at + dim : at + width] = body.motion.inverse_inertia
    return inverse


def _moment(arm, force):
    """arm x force, (..., 1) in 2-D and (..., 3) in 3-D."""
    if force.shape[-1] == 3:
        return np.cross(arm, force)
    return (arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0])[..., None]
