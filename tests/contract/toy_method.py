"""A third method, as small as can be: mass points that fly, and slide with Coulomb friction where they meet the ground.

    v <- v + dt g,  x <- x + dt (v_before + v_after) / 2;  below the ground: back onto it along its normal n,
    v_n <- 0,  |v_t| <- max(0, |v_t| - mu |dv_n|)

They have no stress. Exact in free flight, and down a plane.
"""

import math

import numpy as np

from snowmpm.methods import Capabilities, MethodEntry
from snowmpm.particles.coordinates import Frame
from snowmpm.particles.sorted_particles import SortedParticles, Sorting
from snowmpm.stepping.method import Solver
from snowmpm.stepping.time_step import Extremes

CFL, CRITICAL, LONGEST = 0.4, 0.9, 1.0


class Sliding(Solver):
    """Points of a population above a terrain."""

    def __init__(self, population, laws, options, *, dx, precision, origin, lower, upper, gravity, cfl, terrain, sides,
                 terrain_friction=0.0, terrain_contact="separate", obstacles=()):
        self.dim, self.dx, self.precision = len(origin), dx, precision
        self.frame = frame = Frame(self.dim, precision, origin, dx, lower, upper)
        period = frame.period(sides)
        self.particles = SortedParticles(
            population, laws, frame, gravity, Sorting(drift_limit=1.0), period)
        self.surfaces, self._terrain, self._friction = [], terrain, terrain_friction
        self.cfl, self.critical_cfl, self.scheme_name = cfl or CFL, CRITICAL, "sliding points"
        self.contact_work = 0.0
        self._begin(population, gravity)

    def step(self, dt):
        """Advance by dt [s]."""
        store = self.particles
        if store.strayed:
            store.sort(self.extremes.speed)
        pushed = self._act(dt)
        x, v, mass = store.positions(), store.column("velocity"), store.masses()
        before = v.copy()
        v += pushed * self.gravity
        for centre, radius, acceleration in self._acting:
            near = np.linalg.norm(x - centre, axis=1) < radius
            v[near] += pushed * np.asarray(acceleration)
            self.add_impulse(pushed * mass[near].sum() * np.asarray(acceleration))
        way = 0.5 * dt * (before + v)
        if self._terrain is not None:
            self._touch(x, v, way, mass)
        self._write(v, way)
        self._advance_clock(dt, pushed)

    def _touch(self, x, v, way, mass):
        """Points that would be below the ground stay on it."""
        distance, n = self._terrain.query(x + way)
        below = distance < 0.0
        if not below.any():
            return
        n, old, mass = n[below], v[below], mass[below]
        lift = -distance[below, None] * n
        normal = (old * n).sum(axis=1, keepdims=True)
        tangential = old - normal * n
        speed = np.linalg.norm(tangential, axis=1, keepdims=True)
        lost = np.maximum(-normal, 0.0)
        v[below] = tangential * np.maximum(0.0, 1.0 - self._friction * lost / np.maximum(speed, 1e-300))
        v[below] += np.maximum(normal, 0.0) * n
        way[below] += lift
        self.add_impulse(mass @ (v[below] - old))
        taken = 0.5 * ((old**2).sum(axis=1) - (v[below] ** 2).sum(axis=1)) + lift @ self.gravity
        self.contact_work += float(mass @ taken)

    def _write(self, v, way):
        store = self.particles
        table, columns = store.table(), store.layout.columns
        table[:, columns("velocity")] = v
        table[:, columns("position")] += way / self.dx
        store.overwrite(table)
        store.drift += float(np.linalg.norm(way, axis=1).max(initial=0.0)) / self.dx
        self.extremes = Extremes(speed=float(np.linalg.norm(v, axis=1).max(initial=0.0)))

    def stable_dt(self):
        """A share of a cell at the present speed, or in free fall from rest; a second at most."""
        return self._longest(self.cfl), "advective"

    def critical_dt(self):
        """The share of a cell beyond which points would leave their blocks."""
        return self._longest(CRITICAL), "advective"

    def _longest(self, share):
        fall = 2.0 * max(float(np.linalg.norm(self.gravity)), 1e-30) * share * self.dx
        speed = self.extremes.speed
        return min(LONGEST, 2.0 * share * self.dx / (math.sqrt(speed**2 + fall) + speed))

    def set_loads(self, loads):
        """Loads act on points."""
        self._acting = list(loads)

    @property
    def memory(self):
        """There is nothing but the points [bytes]."""
        return 0

    def restart_clock(self):
        super().restart_clock()
        self.contact_work = 0.0

    def state(self):
        return {**super().state(), "contact_work": self.contact_work}

    def restore(self, state):
        super().restore(state)
        self.contact_work = state["contact_work"]


ENTRY = MethodEntry("sliding", Sliding, Capabilities(
    filling=1, obstacles=False, periodic=False, initial_stress=False))
"""The row of `snowmpm.methods.METHODS`: all that the program has to know."""
