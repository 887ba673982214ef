"""Forces on parts of the surface of bodies in a step of explicit MPM.

A force F on a point that a particle carries at an arm r gives node i of the particle the impulse

    dt F (w_i + g_i . r),    g_i = w_i D^-1 (x_i - x_p),   or grad w_i where no affine matrix is kept

with the gradient by which the particle's own deformation is found, so that the work on the nodes is F . delta x of the
point. The forces are those of the start of the step. With FLIP they go where the internal impulse goes.
"""

import functools
from types import SimpleNamespace

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.components.face_loads.faces import OfFaces
from snowmpm.components.face_loads.from_scene import faces_of
from snowmpm.mpm.kernel_api import SECOND, STENCILS, TILE, interpolation, node_vector
from snowmpm.particles.store import IDENTITY, accessors


def adapter(model):
    """`FaceLoads` of the scene of a `Model`."""
    return FaceLoads(faces_of(model))


class FaceLoads(OfFaces):
    """The `Faces` of a `MpmSolver`."""

    def begin(self, solver):
        """Take the solver's particles and grid."""
        self._solver, self._blocks = solver, None
        scheme = solver.basis, solver.gradient_form, solver.flip, solver.second_moment() > 0.0
        self._kernels = face_kernels(solver.particles.layout, runtime.DTYPES[solver.precision][0], *scheme)
        self._rate = self._swing()

    def after_scatter(self, dt, pushed):
        """Give the nodes the forces of the start of the step."""
        solver, store = self._solver, self._solver.particles
        self._find()
        self._forces, self._pushed = self.faces.forces(solver.time, dt, self._there), pushed
        self._before = self._read()
        arms = self.faces.points.arm
        given = np.concatenate([self._forces, np.einsum("ni,nj->nij", self._forces, arms).reshape(len(arms), -1)], 1)
        self._kernels.spread(store.reals, store.slot_offset, self._rows, self._owners, pushed * given,
                             solver.grid.tiles, 1.0 / solver.dx)
        solver.add_impulse(pushed * self._forces.sum(axis=0))

    def after_gather(self, dt):
        """Move the points with the particles."""
        dim, dx, points = self._solver.dim, self._solver.dx, self.faces.points
        after = self._read()
        A = dt * after[:, dim:].reshape(-1, dim, dim)
        way = dx * (after[:, :dim] - self._before[:, :dim]) + np.einsum("nij,nj->ni", A, points.arm)
        A[~self._there], way[~self._there] = 0.0, 0.0
        points.move_with(A, way)
        self.faces.book(self._forces, dt, self._pushed, way)

    def limit_dt(self, dt, critical, elastic):
        """dt [s] with the swings of particles on penalties: frequencies add up by their squares."""
        return dt / float(np.hypot(1.0, 0.5 * self._rate * dt * critical / elastic)) if self._rate > 0.0 else dt

    def _swing(self):
        """A bound of the fastest one [1/s]: omega^2 <= max_p sum_s k_s (1 + D^-1 |r_s|^2) / m_p, as by the inequality
        of Cauchy and Schwarz (w_i + g_i . r)^2 / w_i add up to 1 + D^-1 |r|^2 over the nodes of p."""
        stiffness, points, solver = self.faces.stiffness, self.faces.points, self._solver
        if not stiffness.any():
            return 0.0
        per_moment = STENCILS[solver.basis].inverse_second_moment / solver.dx**2
        size = stiffness * (1.0 + per_moment * (points.arm**2).sum(axis=1))
        labels, masses = solver.particles.labels()[:, IDENTITY], solver.particles.masses()
        of_particle = np.bincount(points.number, size, max(labels.max(initial=0), points.number.max()) + 1)
        return float(np.sqrt((of_particle[labels] / masses).max(initial=0.0)))

    def _find(self):
        """Rows of the particles that carry points, and their blocks, after a sort."""
        store = self._solver.particles
        if store.blocks is self._blocks:
            return
        numbers, self._blocks = self.faces.points.number, store.blocks
        identity = store.identity.to_numpy()[: store.count]
        row_of = np.full(max(identity.max(initial=0), numbers.max()) + 1, -1)
        row_of[identity] = np.arange(store.count)
        rows = row_of[numbers]
        self._there = rows >= 0
        self._rows = np.maximum(rows, 0).astype(np.int32)
        self._owners = (np.searchsorted(store.blocks.start, self._rows, side="right") - 1).astype(np.int32)

    def _read(self):
        """Local positions [cells] and velocity gradients [1/s] of the particles that carry points."""
        store, dim = self._solver.particles, self._solver.dim
        found = np.zeros((len(self._rows), dim + dim * dim))
        self._kernels.read(store.reals, store.slot_offset, self._rows, found)
        return found


@functools.cache
def face_kernels(layout, real, basis, gradient, flip, affine):
    """Kernels for the particles in `rows` (n,): read their position and velocity gradient into `found`; spread `given`
    (n, dim + dim^2), impulses and impulses times arms, over the nodes of particles of blocks `owners` (n,)."""
    access, at, dim = accessors(layout), layout.offsets, layout.dim
    stencil = STENCILS[basis]
    moving = affine or gradient == "affine"
    grid = interpolation(dim, real, basis, moving, not moving, flip)
    of_node, width, edge = node_vector(real, flip), stencil.width, TILE[dim]
    first = SECOND if flip else 0

    @taichi_kernel
    def read(reals: ti.types.ndarray(), slot_offset: int, rows: ti.types.ndarray(), found: ti.types.ndarray()):
        for i in range(rows.shape[0]):
            places, p = access.places(reals, slot_offset), rows[i]
            x = access.load(reals, places, p, at["position"], dim)
            C = access.load(reals, places, p, at["affine"], dim * dim)
            for a in ti.static(range(dim)):
                found[i, a] = ti.cast(x[a], ti.f64)
            for k in ti.static(range(dim * dim)):
                found[i, dim + k] = ti.cast(C[k], ti.f64)

    @taichi_kernel
    def spread(reals: ti.types.ndarray(), slot_offset: int, rows: ti.types.ndarray(), owners: ti.types.ndarray(),
               given: ti.types.ndarray(), tiles: ti.types.ndarray(dtype=of_node, ndim=1), per_dx: real):
        ti.loop_config(serialize=True)  # points share nodes, and sums keep their order
        for i in range(rows.shape[0]):
            x = access.load(reals, access.places(reals, slot_offset), rows[i], at["position"], dim)
            address, f, w, dw = grid.locate(x, owners[i])
            for s in range(ti.static(width**dim)):
                step, node, weight = ti.Vector.zero(ti.i32, dim), address, ti.cast(1.0, real)
                for a in ti.static(range(dim)):
                    step[a] = s // ti.static(width ** (dim - 1 - a)) % width
                    node += step[a] * ti.static(edge ** (dim - 1 - a))
                    weight *= w[step[a], a]
                impulse = ti.Vector.zero(real, dim)
                for c in ti.static(range(dim)):
                    impulse[c] = weight * ti.cast(given[i, c], real)
                for a in ti.static(range(dim)):
                    slope = per_dx
                    if ti.static(moving):
                        slope *= ti.static(stencil.inverse_second_moment) * weight * (ti.cast(step[a], real) - f[a])
                    else:
                        for b in ti.static(range(dim)):
                            slope *= dw[step[b], b] if ti.static(a == b) else w[step[b], b]
                    for c in ti.static(range(dim)):
                        impulse[c] += slope * ti.cast(given[i, dim + dim * c + a], real)
                for c in ti.static(range(dim)):
                    tiles[node][first + c] += impulse[c]

    return SimpleNamespace(read=read, spread=spread)
