"""A slab on a layer of material points with a saw through it: what cracks of S3 on slopes are compared with.

The slab is WEAC's Timoshenko `Beam`, here with its inertia, or plane-strain `Elements`. What WEAC takes for springs is
`Springs` that break at a given energy, or a `Layer` of points of the law itself, one under each node of the slab's
lower side and strained over the thickness t by its displacement u:

    F = 1 + (u / t) x e_z,    traction on the slab -P e_z,   P = tau F^-T

Small strains of the slab, linear elements, lumped masses, explicit midpoints; x from the saw's end, uphill where the
slope angle is positive. The stress update is the program's, of which the material tests hold; no grid, no particles.
"""

import numpy as np
from scipy.sparse import coo_array

from snowmpm.materials.stress_update import StressUpdate

SHEAR_FACTOR = 5.0 / 6.0
STEP = 0.5
"""Of the time in which a wave along the slab crosses an element."""
RAMP = 0.075
"""Time in which the weight comes on, and again as long as the slab has to come to rest under it [s]."""
SETTLING = 100.0
"""Damping meanwhile [1/s]."""


def _mass_along(length, h):
    """Nodes along the column and the length that each stands for [m]."""
    width = np.full(round(length / h) + 1, h)
    width[[0, -1]] *= 0.5
    return width


class Beam:
    """slab: `slab_on_layer.Elastic`; length of the column, side of the elements h [m]. Degrees of freedom (3, n): u [m]
    along, w [m] normal to the slope, of the middle line, theta [-]: u at the height z over it is u - theta z."""

    def __init__(self, slab, length, h):
        self.h, self.width, self._height = h, _mass_along(length, h), slab.height
        xx, xz = slab.stiffness[0] @ [1.0, -slab.stiffness[0, 1] / slab.stiffness[1, 1], 0.0], slab.stiffness[2, 2]
        self._stiffnesses = xx * slab.height, xx * slab.height**3 / 12.0, SHEAR_FACTOR * xz * slab.height
        self.speed = np.sqrt(xx / slab.density)
        self.mass = slab.density * slab.height * self.width * np.array([[1.0], [1.0], [slab.height**2 / 12.0]])

    def weight(self, gravity):
        return self.mass * np.array([*gravity, 0.0])[:, None]

    def lower_side(self, moved):
        return np.stack([moved[0] + 0.5 * self._height * moved[2], moved[1]])

    def pulled(self, pull):
        return np.stack([pull[0], pull[1], 0.5 * self._height * pull[0]])

    def forces(self, moved):
        u, w, turn = moved
        stretching, bending, shear = self._stiffnesses
        normal, moment = stretching * np.diff(u) / self.h, bending * np.diff(turn) / self.h
        across = shear * (np.diff(w) / self.h - 0.5 * (turn[1:] + turn[:-1]))
        found = np.zeros_like(moved)
        for row, inner in zip(found, (normal, across, moment), strict=True):
            row[:-1] += inner
            row[1:] -= inner
        found[2, :-1] += 0.5 * self.h * across
        found[2, 1:] += 0.5 * self.h * across
        return found


class Elements:
    """The same slab as squares with four nodes and 2 x 2 Gauss points. Degrees of freedom (2, columns x rows)."""

    def __init__(self, slab, length, h):
        self.h, self.width = h, _mass_along(length, h)
        self._rows = round(slab.height / h) + 1
        self.speed = np.sqrt(slab.stiffness[0, 0] / slab.density)
        corner = (np.arange(len(self.width) - 1)[:, None] * self._rows + np.arange(self._rows - 1)).ravel()
        nodes = np.stack([corner, corner + self._rows, corner + self._rows + 1, corner + 1], axis=1)
        count = len(self.width) * self._rows
        self.mass = 0.25 * slab.density * h**2 * np.bincount(nodes.ravel(), minlength=count) * np.ones((2, 1))
        dofs = np.concatenate([nodes, nodes + count], axis=1)
        K = np.tile(_square(slab).ravel(), len(dofs))
        self._K = coo_array((K, (np.repeat(dofs, 8, axis=1).ravel(), np.tile(dofs, (1, 8)).ravel())),
                            shape=(2 * count, 2 * count)).tocsr()

    def weight(self, gravity):
        return self.mass * np.asarray(gravity)[:, None]

    def lower_side(self, moved):
        return moved[:, :: self._rows]

    def pulled(self, pull):
        found = np.zeros(self.mass.shape)
        found[:, :: self._rows] = pull
        return found

    def forces(self, moved):
        return -(self._K @ moved.ravel()).reshape(moved.shape)


def _square(slab):
    """Stiffness (8, 8) [Pa] of a square of any size: four u, then four w, counter-clockwise from below."""
    s, t = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    K = np.zeros((8, 8))
    for a in (-np.sqrt(1.0 / 3.0), np.sqrt(1.0 / 3.0)):
        for b in (-np.sqrt(1.0 / 3.0), np.sqrt(1.0 / 3.0)):
            along, across, none = 0.5 * s * (1.0 + t * b), 0.5 * t * (1.0 + s * a), np.zeros(4)
            B = np.array([[*along, *none], [*none, *across], [*across, *along]])
            K += 0.25 * B.T @ slab.stiffness @ B
    return K


class Layer:
    """n points of a law over the thickness t [m]."""

    def __init__(self, law, thickness, n):
        self._law, self._t, self._update = law, thickness, StressUpdate(law, 2, "f64")
        self._state, self._F = self._update.initial_state(n), np.tile(np.eye(2), (n, 1, 1))
        self._h = np.tile([*np.diag(law.h_from_stress(np.zeros((3, 3)))), 0.0], (n, 1))

    def traction(self, moved):
        """(2, n) along and normal to the layer [Pa], for displacements (2, n) [m] of its upper side."""
        F = np.tile(np.eye(2), (len(self._F), 1, 1))
        F[:, :, 1] += moved.T / self._t
        made = self._update(self._h, self._state, (F - self._F) @ np.linalg.inv(self._F))
        self._h, self._state, self._F = made.h, made.state, F
        return made.stress[:, [3, 1]].T / F[:, 1, 1]  # entries xx, zz, out of plane, xz

    def broken(self):
        return self._law.outputs(self._state)["damage"] >= 0.99


class Springs:
    """n pairs of springs, stiffness (2,) [Pa/m] along and normal to the layer, until both hold `energy` [J/m2]."""

    def __init__(self, stiffness, energy, n):
        self._k, self._energy, self._broken = np.asarray(stiffness)[:, None], energy, np.zeros(n, bool)

    def traction(self, moved):
        self._broken |= 0.5 * (self._k * moved**2).sum(axis=0) >= self._energy
        return np.where(self._broken, 0.0, self._k * moved)

    def broken(self):
        return self._broken


def saw(slab, layer, slope_angle, *, saw_speed, saw_length, end, g=9.81):
    """x of the points [m], and when the crack came to each [s] after the saw started at x = 0: NaN where the saw was
    first, or it has not come until `end` [s]."""
    angle = np.radians(slope_angle)
    weight = slab.weight([-g * np.sin(angle), -g * np.cos(angle)])
    x, arrival = slab.h * np.arange(len(slab.width)), np.full(len(slab.width), np.nan)
    moved, velocity = np.zeros(slab.mass.shape), np.zeros(slab.mass.shape)
    time, dt = -2.0 * RAMP, STEP * slab.h / slab.speed
    while time < end:
        moved, time = moved + dt * velocity, time + dt
        held = x > min(saw_speed * time, saw_length)
        pull = -layer.traction(slab.lower_side(moved)) * slab.width * (held | (time < 0.0))
        force = slab.forces(moved) + slab.pulled(pull) + weight * min(1.0, time / RAMP + 2.0)
        velocity = velocity + dt * force / slab.mass
        if time < 0.0:
            velocity /= 1.0 + dt * SETTLING
            continue
        arrival[layer.broken() & held & np.isnan(arrival)] = time
        if not (held & np.isnan(arrival)).any():
            break
    return x, arrival
