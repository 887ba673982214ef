"""A block that slides along a profile: by its energy line, and by Voellmy's friction.

Of a block at rest at the upper end, on ground of the angle a and the curvature kappa (above 0 in a hollow),

    d(v²/2)/dl = g sin a - mu (g cos a + kappa v²) - g v² / (xi h)

(Voellmy 1955), with l along the ground, and h the thickness of the flow. On a piece of constant slope and curvature
this is solved exactly: v² tends to v_t² = (g sin a - mu g cos a) / k with exp(-2 k l), k = mu kappa + g / (xi h).
Coulomb friction has xi = infinity; without curvature its block stops where the straight line at the angle atan(mu) from
the upper end meets the ground: the energy line.
"""

import math
from dataclasses import dataclass

import numpy as np

GRAVITY = 9.81


@dataclass(frozen=True)
class Slide:
    """speed (n,) [m/s] at each point of the profile, 0 beyond the stop; runout [m]: length to the stop, None where the
    profile ends before; beyond [m/s]: speed at its end."""

    speed: np.ndarray
    runout: float | None

    @property
    def fastest(self):
        """Largest speed [m/s]."""
        return float(self.speed.max())


def energy_line(profile, angle):
    """`Slide` of a block whose energy falls along a straight line of an angle [degrees] from the upper end."""
    line = profile.z[0] - profile.s * math.tan(math.radians(angle))
    end = profile.where_reached(line) if line[1] > profile.z[1] else 0.0  # else it does not start
    over = np.where(profile.s <= (math.inf if end is None else end), np.maximum(line - profile.z, 0.0), 0.0)
    return Slide(np.sqrt(2.0 * GRAVITY * over), end)


def block(profile, mu, xi=math.inf, thickness=1.0, centrifugal=True):
    """`Slide` of a block with Voellmy's friction: mu [-], xi [m/s2], thickness of the flow [m]. centrifugal: whether
    the curvature of the ground adds to its weight."""
    along = np.radians(profile.angles)
    lengths = np.diff(profile.s) / np.cos(along[1:])
    turns = np.diff(along, prepend=along[0])
    drag = GRAVITY / (xi * thickness)
    squared, speed, runout = 0.0, np.zeros(len(profile.s)), None
    for i, length in enumerate(lengths, start=1):
        # A bend between two pieces acts over the length of the second; a fall over a brow takes off no more than all
        kappa = -turns[i] / length if centrifugal else 0.0
        drive = GRAVITY * (math.sin(along[i]) - mu * math.cos(along[i]))
        rate = drag + mu * max(kappa, -GRAVITY * math.cos(along[i]) / max(squared, 1e-12))
        new = _after(squared, drive, rate, length)
        if new <= 0.0 and drive < 0.0:
            reach = _stop(squared, drive, rate) * math.cos(along[i])
            runout = float(profile.s[i - 1] + min(reach, profile.s[i] - profile.s[i - 1]))
            break
        squared = max(new, 0.0)
        speed[i] = math.sqrt(squared)
    return Slide(speed, runout)


def _after(squared, drive, rate, length):
    """v² after a length with d(v²)/dl = 2 (drive - rate v²)."""
    if abs(rate * length) < 1e-9:
        return squared + 2.0 * (drive - rate * squared) * length
    target = drive / rate
    return target + (squared - target) * math.exp(-2.0 * rate * length)


def _stop(squared, drive, rate):
    """Length on which v² falls to 0."""
    if abs(rate) < 1e-12:
        return squared / (-2.0 * drive)
    return math.log(1.0 - squared * rate / drive) / (2.0 * rate)
