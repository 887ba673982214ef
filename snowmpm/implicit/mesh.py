"""The nodes that particles reach in a step, and who reaches which: all sums over particles as sparse products.

With w_I and g_I the weight and the gradient of node I at a particle (`mpm.transfer.stencil`; g is D^-1 w (x_I - x_p) in
the gradient "affine"), and u a field of the nodes,

    u_p = sum_I w_I u_I,      A_p = sum_I u_I (x) g_I,      f_I = sum_p P_p g_I

Weights stay as they are at the start of a step: the nodes move with the iterate, particles keep their place in the
cells until it has converged (Larese et al., ALERT Doctoral School 2020, algorithm 1).
"""

import functools
import itertools

import numpy as np
from scipy import sparse

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import keys_of


class Mesh:
    """Nodes of particles at `cells` (n, dim) [cells].

    nodes (N, dim): coordinates [cells], in the order of their `keys`; weights (n, S), gradients (n, S, dim) [1/m] of
    the S nodes of each particle, reached (n, S); cell_nodes (C, S): nodes of each cell of base nodes that holds
    particles, cell_of (n,). W (n, N): sparse weights; G: dim sparse matrices (n, N) of the gradient's components.
    period (dim,): cells after which an axis repeats, 0 where it does not: nodes that far apart are the same one.
    """

    def __init__(self, cells, dx, kernel, gradient, period=None):
        n, self.dim = cells.shape
        self.period = None if period is None or not np.any(period) else np.asarray(period, np.int64)
        self.width = STENCILS[kernel].width
        self.steps = np.array(list(itertools.product(range(self.width), repeat=self.dim)))
        base = np.empty((n, self.dim), np.int32)
        self.weights = np.empty((n, len(self.steps)))
        self.gradients = np.empty((n, len(self.steps), self.dim))
        with runtime.precision("f64"):
            _stencil_kernel(self.dim, kernel, gradient)(np.ascontiguousarray(cells, np.float64), base, self.weights,
                                                        self.gradients, 1.0 / dx)
        base = self._wrapped(base)
        _, first, self.cell_of = np.unique(keys_of(base), return_index=True, return_inverse=True)
        places = self._wrapped(base[first][:, None, :] + self.steps)
        self.keys, first, nodes = np.unique(keys_of(places.reshape(-1, self.dim)), return_index=True,
                                            return_inverse=True)
        self.nodes = places.reshape(-1, self.dim)[first]
        self.cell_nodes = nodes.reshape(len(places), -1).astype(np.int32)
        self.reached = self.cell_nodes[self.cell_of]
        self.W = self._sparse(self.weights)
        self.G = [self._sparse(np.ascontiguousarray(self.gradients[:, :, a])) for a in range(self.dim)]

    def _sparse(self, values):
        n, size = values.shape
        return sparse.csr_array((values.ravel(), self.reached.ravel(), np.arange(0, n * size + 1, size)),
                                shape=(n, len(self.nodes)))

    def _wrapped(self, nodes):
        """Nodes (..., dim) taken into the period."""
        if self.period is None:
            return nodes
        return np.where(self.period > 0, nodes % np.maximum(self.period, 1), nodes)

    @property
    def n_nodes(self):
        return len(self.nodes)

    def find(self, nodes):
        """Index of nodes with these coordinates (k, dim), -1 where no particle reaches them."""
        keys = keys_of(self._wrapped(nodes))
        at = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        return np.where(self.keys[at] == keys, at, -1)

    def gradient_of(self, u):
        """A (n, dim, dim) of a field u (N, dim)."""
        return np.stack([G @ u for G in self.G], axis=2)

    def forces_of(self, P):
        """sum_p P_p g_I, (N, dim), of P (n, dim, dim)."""
        return sum(G.T @ P[:, :, a] for a, G in enumerate(self.G))

    @functools.cached_property
    def neighbours(self):
        """Index of the node at each of the (2 width - 1)^dim steps from a node, first axis slowest, -1 for none."""
        reach = range(1 - self.width, self.width)
        return np.stack([self.find(self.nodes + np.array(step)) for step in itertools.product(reach, repeat=self.dim)],
                        axis=1).astype(np.int32)

    @functools.cached_property
    def cell_at(self):
        """The cell whose node number s each node is, (N, S), -1 for none."""
        cells = np.full((self.n_nodes, len(self.steps)), -1, np.int32)
        cells[self.cell_nodes, np.arange(len(self.steps))] = np.arange(len(self.cell_nodes))[:, None]
        return cells


@functools.cache
def _stencil_kernel(dim, kernel, gradient):
    """Kernel that finds base node, weights and gradients of particles at positions [cells]."""
    stencil = STENCILS[kernel]
    size, width = stencil.width**dim, stencil.width
    affine = gradient == "affine"

    @taichi_kernel
    def find(cells: ti.types.ndarray(), base: ti.types.ndarray(), weights: ti.types.ndarray(),
             gradients: ti.types.ndarray(), per_dx: ti.f64):
        for p in range(cells.shape[0]):
            f = ti.Vector.zero(ti.f64, dim)
            for a in ti.static(range(dim)):
                first = ti.floor(cells[p, a] - stencil.reach)
                base[p, a] = ti.cast(first, ti.i32)
                f[a] = cells[p, a] - first
            w, slopes = stencil.weights(f), stencil.slopes(f)
            for s in range(size):
                step, weight = ti.Vector.zero(ti.i32, dim), 1.0
                for a in ti.static(range(dim)):
                    step[a] = s // ti.static(width ** (dim - 1 - a)) % width
                    weight *= w[step[a], a]
                weights[p, s] = weight
                for a in ti.static(range(dim)):
                    if ti.static(affine):
                        gradients[p, s, a] = stencil.inverse_second_moment * weight * (step[a] - f[a]) * per_dx
                    else:
                        slope = per_dx
                        for b in ti.static(range(dim)):
                            slope *= slopes[step[b], b] if ti.static(a == b) else w[step[b], b]
                        gradients[p, s, a] = slope

    return find
