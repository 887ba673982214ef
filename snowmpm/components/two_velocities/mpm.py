"""Water with particles and a velocity of its own, beside the grains of the skeleton, over each step of explicit MPM.

Both live on the same nodes, where they exchange momentum (`phase_exchange`). A particle of water keeps its
mass for good, so that water that leaves the snow goes on as water, and pools. With theta the logarithm of the volume of
a piece of water over that at rest,

    theta' = theta + dt / n div q,   q = n w + (1 - n) v,   p = -K_w min(theta, 0),   tau = -J p I,   J = 1 / n

n is the share of water around the particle, so that its volume V / n is that of the snow that it fills; V, its volume
in the reference state, is that of the water alone. Water bears no tension: theta > 0 is a gap, which must close again
before it presses. One theta belongs to each cell of the grid, the mean over its particles by volume: velocities within
a cell that no node can tell apart build up no pressure (Bandara and Soga 2015, doi:10.1016/j.compgeo.2014.09.009).
These velocities also carry particles together, which theta does not know of: in thousands of steps water lies too
densely by a tenth. Where the nodes have more water than theta says, W / R e^theta > 1 of the volumes W of the water and
R that the grains leave between walls (`room`), theta falls by the logarithm of that in the time sqrt(dx / g),
so that it spreads; of W / R, theta counts where it is below 0, and what is below `BAND` is not told from noise.

While an initial state settles, water goes with the grains and keeps its pressure, so that the skeleton comes to rest
under its buoyant weight.

The step is explicit in the pressure, and follows waves in undrained snow, swelling along all axes:

    c² = c_skeleton² + dim K_w (1 / rho_w + (1 - n) / (n rho_g))
"""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.components.two_velocities.phase_exchange import LEAST_POROSITY, PhaseExchange
from snowmpm.mpm.kernel_api import MASS as NODE_MASS
from snowmpm.mpm.kernel_api import SECOND, block_nodes, copy_kernel, interpolation, node_size, node_vector
from snowmpm.particles.blocks import EDGE, fields_of, keys_of
from snowmpm.particles.store import accessors
from snowmpm.water.drops import RainedPhases
from snowmpm.water.particle_kernels import N_WATER, PRESSURE, SOLID, read_columns, water_kernels
from snowmpm.water.phases import THETA
from snowmpm.water.phases_from_scene import phases
from snowmpm.water.phases_from_scene import with_water as with_own_water

BAND = 0.02
"""Of the logarithm of how full nodes are: particles that lie anyhow show this much. As a source without end it would
raise the pressure in soil that hardly lets it out."""


def adapter(model):
    """`TwoVelocities` of a `Model`."""
    return phases(model, TwoVelocities)


def with_water(scene, body, part):
    """`Population` of the grains of a body, and of the water in its pores in the second velocity field."""
    return with_own_water(scene, body, part, TwoVelocities.DROP_FIELD)


class TwoVelocities(RainedPhases):
    """`RainedPhases` of an `MpmSolver`."""

    name = "two_velocities"
    DROP_FIELD = 1

    _kept = None

    def field_pairs(self, solver, population):
        """`PhaseExchange` of its grid."""
        real = runtime.DTYPES[solver.precision][0]
        return PhaseExchange(solver.dim, real, (self.grains, self.density), self.drag, solver.serial)

    def begin(self, solver):
        """Take the solver, at time zero."""
        super().begin(solver)
        self._note(solver, solver.particles.column("volume_ratio")[self._wet(solver), 0])

    def _wet(self, solver):
        store = solver.particles
        return store.material.to_numpy()[: store.count] == self.material

    def _note(self, solver, ratio):
        """Keep what the choice of the next step needs: the speed of waves; ratio: J = 1 / n of the water."""
        most = max(1.0, float(ratio.max(initial=1.0)))  # (1 - n) / n = J - 1
        stiff = solver.dim * self.bulk_modulus * (1.0 / self.density + (most - 1.0) / self.grains)
        self.wave_speed = float(np.sqrt(solver.materials.fastest_wave**2 + stiff))

    def fullness(self, water):
        """Volume at rest over that which the water takes now."""
        return np.exp(-water[:, THETA])

    # ---- the step -------------------------------------------------------------------------------------------------

    def before_step(self, dt, pushed):
        """Rain, and the pressure of the water, before the forces of a step."""
        self.fall(dt)
        solver, store = self._solver, self._solver.particles
        water_kernels(store.layout, runtime.DTYPES[solver.precision][0]).pressurise(
            store.reals, store.slot_offset, store.count)
        store.changes += 1
        return pushed

    def after_scatter(self, dt, pushed):
        """Grains and water meet next."""
        solver = self._solver
        solver.grid.fields.begin(dt, pushed, solver.gravity, held=solver.damping_factor < 1.0)

    def after_surfaces(self, write_back):
        """Before nodes go back to the particles: div q [1/s], n and the filling around the particles of water."""
        solver = self._solver
        grid, store = solver.grid, solver.particles
        real = runtime.DTYPES[solver.precision][0]
        self._flow = np.zeros((store.count, 3))
        first = int(np.searchsorted(fields_of(store.blocks.keys, solver.dim), 1))
        if first == len(store.blocks):
            return
        copy, n = copy_kernel(node_size(True), real), grid.contact.n * block_nodes(grid.dim)
        if self._kept is None or self._kept.shape[0] < n:
            self._kept = ti.ndarray(node_vector(real, True), (int(1.25 * n) + 64,))
        copy(grid.nodes, grid.contact_offset, self._kept, 0, n)
        grid.fields.mix(grid)
        write_back()
        find = flow_kernel(store.layout, real, solver.basis, solver.gradient_form)
        find(store.reals, store.slot_offset, store.start, grid.tiles, 1.0 / solver.dx, first, self._flow,
             store.chunk_bounds)
        copy(self._kept, 0, grid.nodes, grid.contact_offset, n)

    def end_step(self, dt):
        """After a step of dt [s]: the pressure that its flow gives."""
        with runtime.precision(self._solver.precision):
            self._press(self._solver, dt)

    def _press(self, solver, dt):
        store, wet = solver.particles, self._wet(solver)
        if not wet.any():
            return
        columns, width = read_columns(solver.dim)
        rows, real = np.empty((store.count, width)), runtime.DTYPES[solver.precision][0]
        water_kernels(store.layout, real).read(store.reals, store.slot_offset, rows, store.count)
        water, volume = np.ascontiguousarray(rows[:, columns["water"]]), rows[wet, columns["volume"]]
        own, (growth, n, filling) = water[wet], self._flow[wet].T
        grown, n = dt * growth, np.clip(n, LEAST_POROSITY, 1.0)
        self.budget.work += float((volume * (1.0 + own[:, SOLID]) * own[:, PRESSURE]) @ grown)
        if solver.damping_factor == 1.0:  # pressures hold while an initial state settles
            cell = self._cells(store, rows[wet, columns["position"]], wet)
            held = np.bincount(cell, volume)
            theta = (np.bincount(cell, volume * (own[:, THETA] + grown / n)) / held)[cell]
            filled = np.maximum((np.bincount(cell, volume * filling) / held)[cell], 1e-3)
            packed = np.log(filled) + np.minimum(theta, 0.0)
            theta -= dt * np.sqrt(np.linalg.norm(solver.gravity) / solver.dx) * np.maximum(packed - BAND, 0.0)
            own[:, THETA], own[:, PRESSURE] = theta, self.bulk_modulus * np.maximum(-theta, 0.0)
        own[:, SOLID] = 1.0 / n - 1.0
        water[wet] = own
        fill_kernel(store.layout, real)(
            store.reals, store.slot_offset, water, wet.astype(np.int32), store.count)
        store.changes += 1
        self._note(solver, 1.0 / n)

    @staticmethod
    def _cells(store, local, wet):
        """Number of the cell of each of the particles of water, (k,); local (k, dim): positions in their blocks."""
        blocks = store.blocks
        corner = EDGE[store.dim] * np.repeat(blocks.coordinates, np.diff(blocks.start), axis=0)[wet]
        cells = np.floor(local).astype(np.int64) + corner
        period = np.maximum(store.period, 1)
        return np.unique(keys_of(np.where(store.period > 0, cells % period, cells)), return_inverse=True)[1]

    # ---- cost, checkpoint -----------------------------------------------------------------------------------------

    def work(self):
        """Particles."""
        return {"particle": self._solver.particles.count, "step": 1}

    def restore(self, state):
        """Take over what `state()` gave."""
        super().restore(state)
        solver = self._solver
        self._note(solver, solver.particles.column("volume_ratio")[self._wet(solver), 0])


@functools.cache
def flow_kernel(layout, real, basis, gradient):
    """Kernel: div of the velocity, and volume and first of the velocity in the second half of the nodes, around the
    particles of blocks from `first` on, into `found` (n, 3)."""
    dim, shape = layout.dim, gradient == "shape"
    access, at = accessors(layout), layout.offsets
    of_node = node_vector(real, True)
    grid = interpolation(dim, real, basis, not shape, shape, True)

    @taichi_kernel
    def find(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(),
             tiles: ti.types.ndarray(dtype=of_node, ndim=1), inverse_dx: real, first: int,
             found: ti.types.ndarray(dtype=ti.f64, ndim=2), chunk_bounds: ti.types.ndarray()):
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(reals, slot_offset)
                for b in range(ti.max(begin, first), end):
                    for p in range(start[b], start[b + 1]):
                        address, f, w, dw = grid.locate(access.load(reals, places, p, at["position"], dim), b)
                        v, moments, slopes = grid.interpolate(tiles, address, w, dw)
                        _C, L = grid.gradients(f, v, moments, slopes, inverse_dx)
                        found[p, 0] = ti.cast(L.trace(), ti.f64)
                        found[p, 1] = ti.cast(v[ti.static(SECOND + NODE_MASS)], ti.f64)
                        found[p, 2] = ti.cast(v[SECOND], ti.f64)

    return find


@functools.cache
def fill_kernel(layout, real):
    """Kernel: column "water" from rows (n, N_WATER), and J = 1 + its entry SOLID, of particles with wet[p] = 1."""
    access, at = accessors(layout), layout.offsets

    @taichi_kernel
    def fill(reals: ti.types.ndarray(), slot_offset: int, rows: ti.types.ndarray(dtype=ti.f64, ndim=2),
             wet: ti.types.ndarray(dtype=ti.i32, ndim=1), count: int):
        for p in range(count):
            if wet[p] == 1:
                places = access.places(reals, slot_offset)
                held = ti.Vector([ti.cast(rows[p, c], real) for c in ti.static(range(N_WATER))])
                access.store(reals, places, p, at["water"], held)
                access.store(reals, places, p, at["volume_ratio"], ti.Vector([1.0 + held[SOLID]]))

    return fill
