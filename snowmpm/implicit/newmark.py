"""Newmark's rule: displacements of a step as unknowns, velocity and acceleration from them.

    a1 = u / (beta dt^2) - v0 / (beta dt) - (1 / (2 beta) - 1) a0
    v1 = v0 + dt ((1 - gamma) a0 + gamma a1)

gamma = 1/2, beta = 1/4 is the average acceleration: of second order, stable for every step, and it keeps the energy of
a linear system. A damping delta > 0 takes gamma = 1/2 + delta, beta = (1 + delta)^2 / 4, which takes out what swings
faster than a step follows (delta = 1: backward differences), and is of first order.

A step that starts, from a state whose acceleration nobody knows (time zero, bonds just cut), takes gamma = 1,
beta = 1/2: it needs no a0, and is exact under constant forces.

v0 and a0 of the nodes are those that fit the particles best, with the full mass matrix M v0 = sum_p m v_p w: a motion
that the grid can carry is not smoothed from step to step, as by the lumped mass of explicit MPM. They are only needed
where they reach particles.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import linalg

PRECISION = 1e-13
"""Of the projection, over its right-hand side."""

MOST_ITERATIONS = 2000


@dataclass(frozen=True)
class Newmark:
    """The rule for a step of dt [s]."""

    dt: float
    damping: float = 0.0
    starts: bool = False

    @property
    def gamma(self):
        return 1.0 if self.starts else 0.5 + self.damping

    @property
    def beta(self):
        return 0.5 if self.starts else 0.25 * (1.0 + self.damping) ** 2

    @property
    def inertia(self):
        """c [1/s2] of `balance.Balance`."""
        return 1.0 / (self.beta * self.dt**2)

    def past(self, v0, a0):
        """What M is applied to in H: -a1 at u = 0."""
        return v0 / (self.beta * self.dt) + (0.5 / self.beta - 1.0) * a0

    def acceleration(self, u, v0, a0):
        """a1 [m/s2]."""
        return self.inertia * u - self.past(v0, a0)

    def at_rest(self, v0, a0):
        """u* [m] of a step that ends without velocity, v1 = 0."""
        return (self.past(v0, a0) - (v0 / self.dt + (1.0 - self.gamma) * a0) / self.gamma) / self.inertia

    def gain(self, a0, a1):
        """v1 - v0 [m/s]."""
        return self.dt * ((1.0 - self.gamma) * a0 + self.gamma * a1)


class Projection:
    """Fields of the free nodes that fit momenta of particles: T^T M T v = T^T f."""

    def __init__(self, mesh, held, mass):
        self._W, self._held = mesh.W, held
        self._mass = mass
        self._lumped = np.maximum(mesh.W.T @ mass, 1e-300)
        diagonal = (mesh.W.multiply(mesh.W)).T @ mass
        full = np.repeat(diagonal, mesh.dim)
        squares = held.T.multiply(held.T)
        diagonal = squares.T @ full
        self._per_diagonal = 1.0 / np.where(diagonal > 1e-300, diagonal, 1.0)

    def nodes(self, f):
        """Free components (free,) of the field whose momenta of nodes are f (N, dim), as far as nodes are free."""
        held, b = self._held, self._held.reduced(f)
        if not b.any():
            return b

        def apply(v):
            return held.reduced(self._W.T @ (self._mass[:, None] * (self._W @ held.full(v))))

        operator = linalg.LinearOperator((len(b), len(b)), apply)
        precondition = linalg.LinearOperator((len(b), len(b)), lambda x: self._per_diagonal * x)
        first = (f / self._lumped[:, None]).ravel()[held.free]  # is it already where all move alike
        v, _ = linalg.cg(operator, b, first, rtol=PRECISION, atol=0.0, maxiter=MOST_ITERATIONS, M=precondition)
        return v

    def momenta(self, field):
        """sum_p m x_p w of a field of particles (n, dim)."""
        return self._W.T @ (self._mass[:, None] * field)

    def at_particles(self, field):
        """The best fit to a field of particles (n, dim): at the particles, in free components, and the momenta of nodes
        that surfaces took of it."""
        f = self.momenta(field)
        free = self.nodes(f)
        fitted = self._W @ self._held.full(free)
        return fitted, free, self.momenta(fitted) - f
