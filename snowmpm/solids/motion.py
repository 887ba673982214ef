"""Motion of an obstacle: position and velocity at any time."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.solids.motion_table import read_motion_table
from snowmpm.solids.rotation import no_turn, rotation_matrix, spin, turn_velocity


@dataclass(frozen=True, eq=False)
class Pose:
    """Position and velocity of a rigid body.

        x = centre + R (X - X_centre),   v(x) = velocity + omega x (x - centre)

    centre (dim,) [m]: of rotation, moves with the body; rotation R (dim, dim) from its position at the start;
    velocity (dim,) [m/s] of the centre; omega [rad/s]: a number in 2-D, (3,) in 3-D (`snowmpm.solids.rotation`).
    """

    centre: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    omega: Any


class RigidMotion:
    """Motion of a rigid body from its initial position.

    still: whether it never moves.
    """

    first_velocity: Any = 0.0
    """of one that forces move, at the start (dim,) [m/s]"""

    def __init__(self, centre, course=None):
        """centre (dim,) [m]: of rotation, at the start; course: `Uniform`, `Tabulated` or None for rest."""
        self.start_centre = np.asarray(centre, float)
        self._course = course
        self.still = course is None or course.still

    @classmethod
    def of(cls, spec, centre, base_dir="."):
        """Motion of a scene's motion table, None for rest; centre (dim,): used where the table names none.

        InputError: a table file that cannot be read or is wrong.
        """
        if spec is None:
            return cls(centre)
        centre = centre if spec.centre is None else spec.centre
        if spec.file is not None:
            return cls(centre, Tabulated(*read_motion_table(spec.file, base_dir, len(centre)), spec.start))
        omega = np.radians(spec.angular_velocity)
        return cls(centre, Uniform(np.asarray(spec.velocity, float), omega, spec.start, spec.stop, spec.ramp))

    def pose(self, time):
        """`Pose` at `time` [s]."""
        dim = len(self.start_centre)
        if self._course is None:
            return Pose(self.start_centre, np.eye(dim), np.zeros(dim), no_turn(dim))
        shift, turn, velocity, omega = self._course.at(time)
        return Pose(self.start_centre + shift, rotation_matrix(turn), velocity, omega)

    def moved(self, points, time):
        """Positions at `time` [s] of the points of the body that are at (k, dim) [m] at the start."""
        pose = self.pose(time)
        return pose.centre + (points - self.start_centre) @ pose.rotation.T

    def placement(self, time, origin):
        """R (dim, dim), b (dim,) [m]: a point x of the body at the start is at R x + b, both relative to `origin`."""
        pose = self.pose(time)
        return pose.rotation, pose.centre - origin + pose.rotation @ (origin - self.start_centre)

    def velocity_at(self, points, time):
        """Velocity (k, dim) [m/s] of the body at points (k, dim) [m] of space, at `time` [s]."""
        pose = self.pose(time)
        return pose.velocity + spin(pose.omega, points - pose.centre)


class Uniform:
    """Constant velocity and angular velocity between `start` and `stop` [s], with ramps at both ends.

    The speed has the share 3 u^2 - 2 u^3 of its full value at u `ramp` seconds after the start, and likewise before the
    stop; displacement and angle are its exact integrals.
    """

    def __init__(self, velocity, omega, start=0.0, stop=None, ramp=0.0):
        self.velocity, self.omega = velocity, omega
        self.start, self.stop, self.ramp = start, np.inf if stop is None else stop, ramp
        self.still = not (np.any(velocity) or np.any(omega))

    def at(self, time):
        """-> shift (dim,) [m], turn [rad], velocity (dim,) [m/s], angular velocity [rad/s]."""
        begun, begun_time = self._grown(time - self.start)
        ended, ended_time = self._grown(time - (self.stop - self.ramp))
        share, passed = begun - ended, begun_time - ended_time
        return passed * self.velocity, passed * self.omega, share * self.velocity, share * self.omega

    def _grown(self, time):
        """Share of the full speed at `time` [s] after the start of the ramp, and its integral over time [s]."""
        if time < 0.0:
            return 0.0, 0.0
        if time >= self.ramp:
            return 1.0, time - 0.5 * self.ramp
        u = time / self.ramp
        return u**2 * (3.0 - 2.0 * u), self.ramp * u**3 * (1.0 - 0.5 * u)


class Tabulated:
    """Displacement and angle from a table, at rest before its first row and after its last.

    Between the rows monotone cubics (F. N. Fritsch and J. Butland (1984), doi:10.1137/0905021): the velocity, their
    derivative, is continuous, and the motion does not overshoot the rows.
    """

    def __init__(self, times, shifts, turns, start=0.0):
        """times (n,) [s]; shifts (n, dim) [m]; turns (n,) or (n, 3) [rad]; start: when time 0 of the table is [s]."""
        from scipy.interpolate import PchipInterpolator  # slow to import, and few scenes have tables

        self.start, self.first, self.last = start, times[0], times[-1]
        self._shift, self._turn = PchipInterpolator(times, shifts), PchipInterpolator(times, turns)
        self._shift_rate, self._turn_rate = self._shift.derivative(), self._turn.derivative()
        self.still = not (np.any(shifts) or np.any(turns))

    def at(self, time):
        """-> shift (dim,) [m], turn [rad], velocity (dim,) [m/s], angular velocity [rad/s]."""
        own = time - self.start
        inside = float(np.clip(own, self.first, self.last))
        moving = float(self.first <= own <= self.last)
        turn = self._turn(inside)[()]
        rate = moving * self._turn_rate(inside)[()]
        return self._shift(inside), turn, moving * self._shift_rate(inside), turn_velocity(turn, rate)
