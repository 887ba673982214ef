"""Layers thinner than a cell (`.column`) in a step of explicit MPM.

Kernels contain what a point gives to its nodes and the velocity gradient of its layer; ground and sides pass over the
nodes that points reach (`.hidden_nodes`); the step is short enough for the swings of the layer.
"""

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.components.interface_layer.column import COLUMN, CUT, lift_at, point_functions, size, stiffest, swing
from snowmpm.components.interface_layer.cut import cut_points
from snowmpm.components.interface_layer.hidden_nodes import hiding_kernels
from snowmpm.components.interface_layer.impulse import LayerImpulse
from snowmpm.errors import InputError
from snowmpm.mpm.kernel_api import STENCILS, Inlined, block_nodes
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`Layers` of a `Model`."""
    return Layers(model.population, model.laws, model.scene.saw_test is not None)


class OfPoint(Inlined):
    """What kernels contain of a point."""

    column, keeps = COLUMN, True

    def __eq__(self, other):
        return type(other) is OfPoint

    def __hash__(self):
        return hash(OfPoint)

    def impulse(self, dim, real):
        """Traction of the layer on the snow above in place of the particle's own stress; marks its nodes."""
        point = point_functions(dim, real)

        @ti.func
        def to_nodes(impulse, ratio, own, dx):
            b = ti.Vector([own[a] for a in ti.static(range(dim))])
            mark = point.stands(b)
            pull = (mark * dx / ti.max(ratio, 1e-30)) * (impulse @ b)
            turn = (own[ti.static(lift_at(dim))] / dx) * pull.outer_product(point.normal(b))
            return (1.0 - mark) * impulse - mark * turn, pull, mark

        return to_nodes

    def gradient(self, dim, real):
        """Velocity gradient of the layer; its displacement goes on."""
        point = point_functions(dim, real)

        @ti.func
        def of_layer(L, v, ratio, own, dt, dx):
            b, u = ti.Vector.zero(real, dim), ti.Vector.zero(real, dim)
            for a in ti.static(range(dim)):
                b[a], u[a] = own[a], own[dim + a]
            face = point.face_velocity(L, v, b, own[ti.static(lift_at(dim))])
            found = point.gradient(L, face, b, own[ti.static(CUT * dim)], ratio)
            u += point.stands(b) * dt * face
            b = point.left(b, u, dx)
            for a in ti.static(range(dim)):
                own[a], own[dim + a] = b[a], u[a]
            return found, own

        return of_layer


class Layers(Adapter):
    """The layers of an `MpmSolver`, all together."""

    name = "interface_layer"
    inlined = OfPoint()

    def __init__(self, population, laws, followed):
        """population: `Population` with points; laws: one per material index; followed: by a saw test."""
        self.columns = {COLUMN: size(population.positions.shape[1])}
        self._population, self._laws, self._followed = population, laws, followed

    def begin(self, solver):
        """Take a solver's particles and grid. Raises InputError for a transfer without FLIP and bodies that part."""
        if not solver.flip:
            raise InputError('solver.transfer: must be "flip" or "aflip" beside an interface')
        if solver.grid.fields:
            raise InputError("bodies: an interface does not go with bodies that part")
        self._solver, column, dim = solver, self._population.columns[COLUMN], solver.dim
        lift = column[:, lift_at(dim)].max(initial=0.0) / solver.dx
        self._rate = stiffest(self._population, self._laws, dim) * swing(
            lift, STENCILS[solver.basis].inverse_second_moment)
        self._points = int(column[:, :dim].any(axis=1).sum())
        self._hide, self._show = hiding_kernels(runtime.DTYPES[solver.precision][0], solver.serial)
        self._impulse = LayerImpulse(solver.particles, solver.serial)

    def before_scatter(self, pushed):
        """Book the impulse of the layers on the snow above."""
        self._solver.add_impulse(self._solver.damping_factor * self._impulse.of(pushed))

    def before_ground(self, grid):
        """Hide the nodes that points reach."""
        self._hide(grid.nodes, grid.contact_offset, block_nodes(grid.dim) * grid.contact.n)

    def after_ground(self, grid):
        """Show them again."""
        self._show(grid.nodes, grid.contact_offset, block_nodes(grid.dim) * grid.contact.n)

    def limit_dt(self, dt, critical, elastic):
        """dt [s] with the swings of the layer under its points' own mass: frequencies add up by their squares."""
        return dt / np.hypot(1.0, 0.5 * self._rate * dt * critical / elastic) if self._rate > 0.0 else dt

    def cut(self, numbers, reached, state):
        """Cut the points numbers[0] <= number < numbers[1] with x < reached [m]: no stress from now on, and the law's
        severed `state`, if any. What they stored counts as removed energy."""
        store = self._solver.particles
        store.changes += 1
        store.removed["energy"] += cut_points(store, numbers, reached, state or ())

    def work(self):
        """Particles, points at the start; in a saw test also what follows them."""
        counts = {"particle": self._solver.particles.count, "point": self._points, "step": 1}
        if self._followed:
            counts |= {"followed point": self._points, "followed step": 1}
        return counts
