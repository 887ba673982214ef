"""A free rigid body: an obstacle with mass, and the impulses that it has taken."""

import numpy as np

from snowmpm.components.rigid_bodies.probes import probes

HELD = 1.0
"""Cells around a body whose snow contact holds at its velocity, about."""


class Body:
    """A free `solids.Obstacle` among others. impulse: of weight, snow and contact since the start (dim,) [N s].

    Snow is held at the velocity that a body has at the begin of a step, and gives the body what that took. A body
    lighter than the snow that it holds, M < m, would be thrown back by more than it came with, and further each step:
    `held` says how much that is at most.
    """

    def __init__(self, number, obstacle, spacing, friction=0.5, restitution=0.0):
        """number: among the obstacles; spacing [m] of its probes; friction, restitution [-]: where it meets what is not
        snow."""
        self.number, self.obstacle, self.motion, self.name = number, obstacle, obstacle.motion, obstacle.name
        self.friction, self.restitution = friction, restitution
        self._probes, self.probe_radius = probes(obstacle.shape, spacing)
        arms = self._probes - self.motion.start_centre
        self.radius = float(np.linalg.norm(arms, axis=1).max()) + self.probe_radius
        self._arms = arms
        self.begin()

    def begin(self):
        """At the start, with nothing taken."""
        self.motion.begin()
        self.impulse, self.gone = np.zeros(len(self.motion.centre)), False

    def held(self, density, dx):
        """Mass and moment of inertia of what it holds of snow of this density [kg/m3] on a grid of dx [m], over its own
        [-]; the smallest moment counts."""
        vertices, facets = self.obstacle.shape.drawing()
        corners = vertices[facets]
        if corners.shape[1] == 2:
            area = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).sum()
        else:
            area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                                        axis=1).sum()
        mass, own = density * area * HELD * dx, self.motion.mass_properties
        # Of a shell: a third of the square of its largest radius, for what is long
        return mass / own.mass, mass * self.radius**2 / 3.0 / float(np.linalg.eigvalsh(own.inertia)[0])

    @property
    def probes(self):
        """Points (k, dim) [m] on its surface where it is now, and the radius of the balls around them."""
        return self.motion.centre + self._arms @ self.motion.rotation.T, self.probe_radius

    @property
    def bounds(self):
        """Lower and upper corner (dim,) [m] of a box that holds it where it is now."""
        return self.obstacle.bounds_at(np.inf)

    @property
    def speed(self):
        """A bound of the speed of its points [m/s]."""
        return float(np.linalg.norm(self.motion.velocity) + np.linalg.norm(self.motion.omega) * self.radius)

    def advance(self, gain, gravity, dt):
        """Take what the snow gave (dim + 1 or 3,), and the weight of a step."""
        motion, dim = self.motion, len(gravity)
        motion.velocity = motion.velocity + gain[:dim] / motion.mass_properties.mass + dt * gravity
        motion.spin = motion.spin + gain[dim:]
        self.impulse += gain[:dim] + motion.mass_properties.mass * dt * gravity

    def push(self, impulse, moment):
        """Take an impulse (dim,) [N s] and its moment about the centre [N m s]."""
        motion = self.motion
        motion.velocity = motion.velocity + impulse / motion.mass_properties.mass
        motion.spin = motion.spin + moment
        self.impulse += impulse

    def query(self, points):
        """Distance and normal of its surface where it is now."""
        return self.obstacle.query_at(points, np.inf)

    @property
    def residual(self):
        """M (v - v_start) less the impulses taken (dim,) [N s], and the size of both."""
        motion = self.motion
        mass = motion.mass_properties.mass
        gained = mass * (motion.velocity - motion.first_velocity)
        return gained - self.impulse, np.linalg.norm(self.impulse) + mass * np.linalg.norm(motion.velocity)

    def state(self):
        """All that a continuation needs, by name."""
        return {**self.motion.state(), "impulse": self.impulse.copy(), "gone": self.gone}

    def restore(self, state):
        """Take over what `state()` gave."""
        self.motion.restore(state)
        self.impulse, self.gone = np.array(state["impulse"], float), bool(state["gone"])
