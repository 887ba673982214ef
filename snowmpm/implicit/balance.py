"""The equations of a step: forces on the free nodes as a function of their displacements, and the matrix of both.

    R(u) = sum_p V P g + c M u - H - sum_p m b w,    T^T R = 0,    M = sum_p m w w

b: acceleration of weight and loads; c M u - H the inertia by Newmark's rule (`newmark`), nothing at rest; the `Term`s
of components come to it. A pressure around the snow, less that in its pores, is a pull s
beside the stress of the laws,

    P = (tau + s J I) f^-T,    dP_ij / dA_kl = ... + s J (f^-T_ij f^-T_kl - f^-T_il f^-T_kj)
"""

import abc
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from snowmpm.implicit.response import After, respond
from snowmpm.implicit.stiffness import Stiffness

ROUND_OFF = 4e-15
"""Of sums over particles, relative."""


class Term(abc.ABC):
    """External forces of a component that depend on the displacements of a step. force (dim,) [N]: in the last step."""

    force: np.ndarray

    @abc.abstractmethod
    def meet(self, mesh):
        """Take a `Mesh` of the particles as they are now."""

    @abc.abstractmethod
    def at(self, u):
        """Forces on the nodes (N, dim) [N] at displacements u (N, dim) [m]."""

    @abc.abstractmethod
    def matrix(self, u):
        """-d at(u) / du, (dim N, dim N)."""

    @abc.abstractmethod
    def carry(self, u, early, late):
        """The step went by u (N, dim) [m]: count what the forces did, those before it for the time `early` [s], those
        at its end for `late` [s]; -> impulse (dim,) [N s]."""


class Strain(abc.ABC):
    """What the laws see in a step in place of the deformation that nodes give each particle."""

    @abc.abstractmethod
    def seen(self, A):
        """What they see of A (n, dim, dim), and whether that can be."""

    @abc.abstractmethod
    def forces(self, A, after):
        """P (n, dim, dim) [Pa] of the forces on the nodes. A: of the nodes; after: `After` of what the laws saw."""

    @abc.abstractmethod
    def matrix(self, A, after):
        """V C of each particle (n, dim, dim, dim, dim) [J], and the rest of K, sparse (dim N, dim N); after: with
        tangents."""


@dataclass
class Trial:
    """An iterate: v (free,), u (N, dim) [m], what particles make of it, full (N, dim) and free residual [N], the size
    of the forces that it is made of [N], and the residual that round-off leaves [N]. sound: no particle is turned
    inside out, and all numbers are finite."""

    v: np.ndarray
    u: np.ndarray
    after: After
    full: np.ndarray
    free: np.ndarray
    scale: float
    noise: float
    sound: bool


class Balance:
    """Equations of particles on a mesh.

    matter: `MaterialPoints`; materials: `MaterialTable` of float64; body (n, dim): b [m/s2]; dt [s]: what laws see;
    inertia: c [1/s2]; history (N, dim): H [N]; dx [m]. pull (n,): s [Pa], None without.
    """

    def __init__(self, mesh, held, matter, materials, body, dx, dt, inertia=0.0, history=None):
        self.mesh, self.held, self.materials = mesh, held, materials
        self._before, self._dt, self._inertia = matter.before(), dt, inertia
        self.pull = matter.around
        self.volume, self.mass, self._dx = matter.volume, matter.mass, dx
        self._strain = matter.strain(mesh, matter) if matter.strain else None
        self.external = mesh.W.T @ (self.mass[:, None] * body)
        self._history = np.zeros_like(self.external) if history is None else history
        self._stiffness = None
        self._terms = matter.terms
        for term in self._terms:
            term.meet(mesh)

    def internal(self, P):
        """sum_p V P g, (N, dim)."""
        return self.mesh.forces_of(self.volume[:, None, None] * P)

    def at(self, v, tangents=False):
        """`Trial` at v (free,)."""
        u = self.held.full(v)
        after, P, upright = self._response(u, tangents)
        inertia = np.zeros_like(u)
        if self._inertia:
            inertia = self._inertia * (self.mesh.W.T @ (self.mass[:, None] * (self.mesh.W @ u)))
        net = inertia - self._history
        external = self.external
        for term in self._terms:
            external = external + term.at(u)
        full = self.internal(P) + net - external
        pulls = np.linalg.norm(self.volume * np.linalg.norm(P, axis=(1, 2))) / self._dx
        free = self.held.reduced(full)
        sound = bool(np.isfinite(free).all() and upright and (after.growth > 0.0).all())
        scale = pulls + np.linalg.norm(net) + np.linalg.norm(external)
        noise = ROUND_OFF * (np.linalg.norm(inertia) + np.linalg.norm(self._history) + scale)
        return Trial(v, u, after, full, free, float(scale), float(noise), sound)

    def _response(self, u, tangents):
        """`After` of displacements u, with the pull, P of the forces, and whether cells can change their volume so."""
        A, upright = self.mesh.gradient_of(u), True
        if self._strain is not None:
            seen, upright = self._strain.seen(A)
            after = respond(self.materials, self._before, seen, self._dt, tangents)
            return after, self._strain.forces(A, after) if upright else after.P, upright
        after = respond(self.materials, self._before, A, self._dt, tangents)
        if self.pull is None:
            return after, after.P, upright
        turn = turned(A, after.growth)
        size = (self.pull * after.ratio)[:, None, None]
        C = after.C
        if tangents:
            C = C + size[..., None, None] * (np.einsum("nij,nkl->nijkl", turn, turn)
                                             - np.einsum("nil,nkj->nijkl", turn, turn))
        after = after._replace(P=after.P + size * turn, C=C)
        return after, after.P, upright

    def with_tangents(self, trial):
        """The same with the tangents of its particles."""
        return self.at(trial.v, tangents=True)

    def matrix(self, trial):
        """K of a `Trial` with tangents, (dim N, dim N)."""
        if self._stiffness is None:
            self._stiffness = Stiffness(self.mesh)
        if self._strain is None:
            C = self.volume[:, None, None, None, None] * trial.after.C
            return self._with_terms(self._stiffness.matrix(C, self._inertia * self.mass), trial)
        C, shared = self._strain.matrix(self.mesh.gradient_of(trial.u), trial.after)
        plain = self._stiffness.matrix(C, self._inertia * self.mass)
        return self._with_terms(sparse.bsr_array(plain + shared.tobsr(blocksize=plain.blocksize)), trial)

    def _with_terms(self, K, trial):
        """K with what the terms of components add to it."""
        for term in self._terms:
            K = sparse.bsr_array(K + term.matrix(trial.u).tobsr(blocksize=K.blocksize))
        return K


def turned(A, growth):
    """f^-T (n, dim, dim) of f = I + A; that of a particle that is turned inside out is not looked at."""
    f = np.where((growth > 0.0)[:, None, None], A, 0.0) + np.eye(A.shape[1])
    return np.swapaxes(np.linalg.inv(f), 1, 2)
