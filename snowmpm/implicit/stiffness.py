"""The matrix of a step: stiffness of all particles, and inertia.

    K_IK = sum_p V g_I . C . g_K + c m w_I w_K I

C from `response`, c = 1 / (beta dt^2) of Newmark's rule, 0 at rest. Each row of nodes is added up by one worker, from
the cells around it: no two write to the same place, whatever the number of threads, and sums keep their order.
"""

import functools
import itertools
from typing import NamedTuple

import numpy as np
from scipy import sparse

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunk_bounds, chunks, is_worker


class Reach(NamedTuple):
    """Who reaches whom: cell_at (N, S), cell_nodes (C, S), first particle of each cell (C + 1,), particles in the order
    of cells (n,), place of each neighbour's block in the matrix (N, (2 width - 1)^dim), step from a node to another of
    the same cell (S, S)."""

    cell_at: Array
    first: Array
    order: Array
    slots: Array
    step: Array


class Particles(NamedTuple):
    """weights (n, S), gradients (n, S, dim), V C (n, dim, dim, dim, dim), c m (n,)."""

    weights: Array
    gradients: Array
    C: Array
    inertia: Array


class Stiffness:
    """Matrices on a `Mesh`; their pattern is found once."""

    def __init__(self, mesh):
        self.mesh = mesh
        used = mesh.neighbours >= 0
        self._indices = mesh.neighbours[used]
        self._starts = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
        slots = np.where(used, np.cumsum(used).reshape(used.shape) - 1, -1).astype(np.int32)
        order = np.argsort(mesh.cell_of, kind="stable").astype(np.int32)
        counts = np.bincount(mesh.cell_of, minlength=len(mesh.cell_nodes))
        first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        edge = 2 * mesh.width - 1
        digits = edge ** np.arange(mesh.dim - 1, -1, -1)
        step = ((mesh.steps[None] - mesh.steps[:, None] + mesh.width - 1) * digits).sum(axis=2).astype(np.int32)
        self._reach = Reach(mesh.cell_at.ravel(), first, order, slots.ravel(), step.ravel())
        around = np.where(mesh.cell_at >= 0, counts[mesh.cell_at], 0).sum(axis=1)
        self._bounds = chunk_bounds(around + 1)

    @property
    def bytes(self):
        """Of the matrix."""
        return len(self._indices) * (8 * self.mesh.dim**2 + 4)

    def matrix(self, C, inertia):
        """K, sparse with blocks of dim x dim. C (n, dim, dim, dim, dim): times the volume; inertia (n,): c m."""
        dim, n = self.mesh.dim, self.mesh.n_nodes
        data = np.zeros((len(self._indices), dim, dim))
        flat = (np.ravel(one) for one in (self.mesh.weights, self.mesh.gradients, C, inertia))
        with runtime.precision("f64"):
            _row_kernel(dim, len(self.mesh.steps), self.mesh.neighbours.shape[1])(
                self._reach, Particles(*flat), data.reshape(-1), self._bounds)
        if self.mesh.period is None:
            return sparse.bsr_array((data, self._indices, self._starts), shape=(dim * n, dim * n))
        # A node may be the neighbour of another one on both sides; adding these up changes the pattern in its place
        matrix = sparse.bsr_array((data, self._indices.copy(), self._starts.copy()), shape=(dim * n, dim * n))
        matrix.sum_duplicates()
        return matrix


@functools.cache
def _row_kernel(dim, size, steps):
    entries = list(itertools.product(range(dim), repeat=3))

    @grouped_kernel(ti.f64, plain=True)
    def add_rows(reach: Reach, particles: Particles, data: Array, bounds: Array):
        for i in range(chunks(bounds)):
            if is_worker(i):
                begin, end = chunk(i, bounds)
                for node in range(begin, end):
                    for s in range(size):
                        cell = reach.cell_at[node * size + s]
                        if cell >= 0:
                            for q in range(reach.first[cell], reach.first[cell + 1]):
                                p = reach.order[q]
                                at, row = p * size + s, ti.Vector.zero(ti.f64, dim)
                                for j in ti.static(range(dim)):
                                    row[j] = particles.gradients[at * dim + j]
                                own = particles.inertia[p] * particles.weights[at]
                                B = ti.Matrix.zero(ti.f64, dim, dim * dim)  # g_I . C
                                for a, k, b in ti.static(entries):
                                    for j in ti.static(range(dim)):
                                        place = ti.static(((a * dim + j) * dim + k) * dim + b)
                                        B[a, k * dim + b] += row[j] * particles.C[p * ti.static(dim**4) + place]
                                for t in range(size):
                                    column, other = ti.Vector.zero(ti.f64, dim), p * size + t
                                    for b in ti.static(range(dim)):
                                        column[b] = particles.gradients[other * dim + b]
                                    mass = own * particles.weights[other]
                                    slot = dim * dim * reach.slots[node * steps + reach.step[s * size + t]]
                                    for a, k in ti.static(ti.ndrange(dim, dim)):
                                        entry = data[slot + ti.static(a * dim + k)]
                                        if ti.static(a == k):
                                            entry += mass
                                        for b in ti.static(range(dim)):
                                            entry += B[a, k * dim + b] * column[b]
                                        data[slot + ti.static(a * dim + k)] = entry  # += would be atomic

    return add_rows
