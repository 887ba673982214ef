"""Motion of a free rigid body: where its momenta have taken it."""

import numpy as np

from snowmpm.components.rigid_bodies import quaternion
from snowmpm.components.rigid_bodies.mass_properties import MassProperties
from snowmpm.solids.motion import Pose, RigidMotion
from snowmpm.solids.rotation import no_turn, rotation_matrix

MIDPOINTS = 20
"""Iterations, at most, for the angular velocity in the middle of a step; they converge as (omega dt)^k."""


class FreeMotion(RigidMotion):
    """State of a rigid body with mass.

    centre (dim,) [m] of mass; velocity (dim,) [m/s] of it; turn: angle (1,) [rad] in 2-D, unit quaternion (4,) in 3-D,
    from its position at the start; spin: angular momentum about the centre, (1,) or (3,) [kg m2/s]. Until `start` [s],
    and while the snow settles, it is held where it was at the start.
    """

    def __init__(self, mass_properties, velocity=None, omega=None, start=0.0):
        super().__init__(mass_properties.centre)
        self.mass_properties, self.start, self.still = mass_properties, start, False
        self._own_inverse = np.linalg.inv(mass_properties.inertia)
        dim = len(mass_properties.centre)
        self.first_velocity = np.zeros(dim) if velocity is None else np.asarray(velocity, float)
        self._first_omega = np.atleast_1d(no_turn(dim) if omega is None else np.asarray(omega, float))
        self.begin()

    @classmethod
    def of_shape(cls, spec, shape):
        """Motion of a scene's table `free` of an obstacle with this `SolidShape`."""
        mass_properties = MassProperties.of(shape, spec.density, spec.mass)
        return cls(mass_properties, spec.velocity, np.radians(spec.angular_velocity), spec.start)

    def begin(self):
        """Take the state of the start."""
        dim = len(self.start_centre)
        self.centre, self.velocity = np.array(self.start_centre), np.array(self.first_velocity)
        self.turn = np.zeros(1) if dim == 2 else np.array(quaternion.NO_TURN)
        self.spin = self.mass_properties.inertia @ self._first_omega
        self._turned()

    def _turned(self):
        """After another turn: R (dim, dim) from the position at the start, and the inverse (1, 1) or (3, 3) of the
        inertia [1/(kg m2)]."""
        self.rotation = rotation_matrix(self.turn[0]) if len(self.turn) == 1 else quaternion.matrix(self.turn)
        self.inverse_inertia = self._inverse_inertia(self.rotation)

    def _inverse_inertia(self, rotation):
        own = self._own_inverse
        return own if len(own) == 1 else rotation @ own @ rotation.T

    @property
    def omega(self):
        """Angular velocity (1,) or (3,) [rad/s]."""
        return self.inverse_inertia @ self.spin

    @property
    def energy(self):
        """Kinetic energy [J]."""
        return 0.5 * float(self.mass_properties.mass * self.velocity @ self.velocity + self.spin @ self.omega)

    def pose(self, time):
        """`Pose` now, of which `time` [s] tells only whether it is still held."""
        dim = len(self.start_centre)
        if time < self.start:
            return Pose(self.start_centre, np.eye(dim), np.zeros(dim), no_turn(dim))
        omega = self.omega
        return Pose(self.centre, self.rotation, self.velocity, float(omega[0]) if dim == 2 else omega)

    def drift(self, dt):
        """Move for dt [s] with the momenta that it has.

            x' = x + dt v,   R' = exp(dt omega_m) R,   omega_m = I(R_m)^-1 L,   R_m = exp(dt/2 omega_m) R

        the midpoint rule on the rotations: angular momentum L is kept exactly, energy to third order a step.
        """
        self.centre = self.centre + dt * self.velocity
        omega = self.omega
        if len(self.turn) == 1:
            self.turn = self.turn + dt * omega
            self._turned()
            return
        for _ in range(MIDPOINTS):
            middle = quaternion.product(quaternion.of_turn(0.5 * dt * omega), self.turn)
            last, omega = omega, self._inverse_inertia(quaternion.matrix(middle)) @ self.spin
            if np.abs(omega - last).max() <= 1e-15 * np.abs(omega).max():
                break
        turn = quaternion.product(quaternion.of_turn(dt * omega), self.turn)
        self.turn = turn / np.linalg.norm(turn)
        self._turned()

    def stop(self):
        """Take all momentum away."""
        self.velocity, self.spin = np.zeros_like(self.velocity), np.zeros_like(self.spin)

    def state(self):
        """All that a continuation needs, by name."""
        return {"centre": self.centre.copy(), "velocity": self.velocity.copy(), "turn": self.turn.copy(),
                "spin": self.spin.copy()}

    def restore(self, state):
        """Take over what `state()` gave."""
        for name in ("centre", "velocity", "turn", "spin"):
            setattr(self, name, np.array(state[name], float))
        self._turned()
