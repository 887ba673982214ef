"""Frameworks for tests: a portal, what it does at rest, and its frequencies by exact beam functions."""

import numpy as np
from scipy.optimize import brentq

from snowmpm.components.structures.framework import Framework
from snowmpm.components.structures.framework_mesh import Member
from snowmpm.components.structures.section import Section

HEIGHT, SPAN, WIDTH = 3.0, 4.0, 0.06
BAR = Section.tube(WIDTH, 0.5 * WIDTH, 2.1e11, 7850.0)
JOINTS = {"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, HEIGHT), "c": (SPAN, 0.0, HEIGHT), "d": (SPAN, 0.0, 0.0)}
PAIRS = (("a", "b"), ("b", "c"), ("c", "d"))


def portal(feet="fixed", *, section=BAR, segments=2, pinned=(), damping=1.0, plane=True):
    """A portal in the plane y = 0; pinned: (member's name, joint) that passes on no moment."""
    members = [Member(*pair, section, segments, tuple(joint for name, joint in pinned if name == "-".join(pair)))
               for pair in PAIRS]
    return Framework(JOINTS, {"a": feet, "d": feet}, members, damping=damping, plane=plane)


def pushed(one, loads, periods=3.5, pieces=1):
    """The framework after it came to rest under forces (3,) [N] at joints, {name: force}."""
    forces = np.zeros_like(one.x)
    for name, force in loads.items():
        forces[one.mesh.joints[name]] = force
    for _ in range(pieces):
        one.advance(periods / pieces * 2.0 * np.pi / one.modes.first, forces)
    return one


def moved(one, name):
    """Displacement (3,) [m] of a joint."""
    i = one.mesh.joints[name]
    return one.x[i] - one.mesh.places[i]


def decay_rate(values, step):
    """Rate [1/s] at which the maxima of a swing fall, by parabolas through their three values; step [s]."""
    before, at, after = np.array([values[:-2], values[1:-1], values[2:]])
    top = np.flatnonzero((at > before) & (at >= after) & (at > 0.0))
    assert len(top) >= 3
    slope, bend = 0.5 * (after - before)[top], (after - 2.0 * at + before)[top]
    return -np.polyfit(step * (top - slope / bend), np.log(at[top] - 0.5 * slope**2 / bend), 1)[0]


def sway_frequency(section):
    """Lowest angular frequency [rad/s] of a fixed `portal` that does not stretch, of beams with mass all along them
    (V. Kolousek (1973), Dynamics in Engineering Structures): both joints turn and shift alike."""
    bend, mass = section.bending, section.line_mass

    def stiffness(omega, length):
        """Ends' force, moment by shift, turn of a beam that vibrates, from its four solutions."""
        k = (mass * omega**2 / bend) ** 0.25

        def solutions(x, derivative):
            s, c, sh, ch = np.sin(k * x), np.cos(k * x), np.sinh(k * x), np.cosh(k * x)
            rows = [[c, s, ch, sh], [-s, c, sh, ch], [-c, -s, ch, sh], [s, -c, sh, ch]]
            return k**derivative * np.array(rows[derivative])

        ends = np.array([solutions(x, d) for x in (0.0, length) for d in (0, 1)])
        forces = bend * np.array([solutions(0.0, 3), -solutions(0.0, 2), -solutions(length, 3), solutions(length, 2)])
        return forces @ np.linalg.inv(ends)

    def determinant(omega):
        column, beam = stiffness(omega, HEIGHT), stiffness(omega, SPAN)
        # Upper ends of two columns, and a beam whose ends turn alike and which is shifted along itself
        K = 2.0 * column[2:, 2:]
        K[1, 1] += beam[1, 1] + beam[1, 3] + beam[3, 1] + beam[3, 3]
        K[0, 0] -= mass * SPAN * omega**2
        return np.linalg.det(K) / bend**2

    unit = np.sqrt(bend / mass) / HEIGHT**2
    grid = np.linspace(0.1, 8.0, 400) * unit
    values = [determinant(omega) for omega in grid]
    first = next(i for i in range(len(grid) - 1) if values[i] > 0.0 >= values[i + 1])
    return brentq(determinant, grid[first], grid[first + 1])
