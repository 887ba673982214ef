"""Friction of the ground under particles, by the laws of depth-averaged flow (`snowmpm.ground`).

A law gives the shear stress tau(sigma, v, h) of a flow with the mean speed v and the thickness h over the ground under
the normal stress sigma. Over each node of the grid in plan, these are those of the particles around it,

    v = sum m |v| / sum m,   h = cos (sum V) / area,   sigma = rho g h cos

with rho and V at the initial density. At an edge of the snow, which covers an unknown part of that area, h is that of
the nearest place that it covers; where there is none, h = 2 cos (sum m (z - b) / sum m), twice the mean height above
the ground b, as of an even layer. Contact takes the coefficient tau / sigma in place of Coulomb's mu, of the normal
force that it finds. So dry friction stays in proportion to that force, and friction stops snow without turning it back.

Where the law does not depend on the speed, coefficients are computed again only once the snow may have moved by
`STALE`.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors

MASS, LIFT, SPEED, VOLUME, HEIGHT = range(5)
"""Numbers of a node in plan: sums over particles of m, m (z - b), m |v| and V, and b [m]."""
AROUND = 3
"""Nodes along each axis over whose sums means are taken."""
FULL = 0.5
"""Least mass of all nodes around one, over the largest of them, where the snow covers their area."""
BESIDE = 3
"""Nodes from one that is covered within which snow is taken as deep as there: its edge."""
LEAST_THICKNESS = 0.25
"""[cells]: snow counts as at least as thick."""
STALE = 0.25
"""[cells] that the snow moves at most before coefficients are computed again: a twelfth of the width of the means."""
PROBED = (300.0, 1000.0, 1.0)
"""Density [kg/m3], normal stress [Pa] and thickness [m] at which a law is asked whether it depends on the speed."""
ROOM = 3
"""Nodes beyond the domain that contact may ask for."""


@functools.cache
def _sums_kernel(layout, real):
    """Kernel that adds particles to the nodes in plan around them, in linear shares. ints: slot offset, first node
    along x and y, blocks; lengths: dx [m], height of the origin [m]. One thread, so that sums do not depend on their
    number."""
    edge, at, dim = EDGE[layout.dim], layout.offsets, layout.dim
    access = accessors(layout)

    @taichi_kernel
    def add_up(reals: ti.types.ndarray(), material: ti.types.ndarray(), materials: ti.types.ndarray(),
               start: ti.types.ndarray(), coordinates: ti.types.ndarray(), table: ti.types.ndarray(),
               ints: ti.types.ndarray(), lengths: ti.types.ndarray()):
        ti.loop_config(serialize=True)
        for b in range(ints[3]):
            places = access.places(reals, ints[0])
            for p in range(start[b], start[b + 1]):
                x = access.load(reals, places, p, at["position"], dim)
                cell = ti.Vector.zero(ti.f64, 2)
                for a in ti.static(range(dim - 1)):
                    cell[a] = ti.cast(edge * coordinates[b, a], ti.f64) + x[a] - ints[1 + a]
                low = ti.floor(cell, ti.i32)
                if 0 <= low[0] < table.shape[0] - 1 and 0 <= low[1] < ti.max(1, table.shape[1] - 1):
                    u, ground = cell - low, ti.cast(0.0, ti.f64)
                    for i in ti.static(range(2)):
                        for j in ti.static(range(dim - 1)):
                            share = ti.select(i == 0, 1.0 - u[0], u[0]) * ti.select(j == 0, 1.0 - u[1], u[1])
                            ground += share * table[low[0] + i, low[1] + j, HEIGHT]
                    z = lengths[1] + lengths[0] * (ti.cast(edge * coordinates[b, dim - 1], ti.f64) + x[dim - 1])
                    volume = ti.cast(access.load(reals, places, p, at["volume"], 1)[0], ti.f64)
                    mass = volume * materials[material[p], DENSITY]
                    if ti.static(layout.mass_at >= 0):
                        mass += volume * ti.cast(access.load(reals, places, p, layout.mass_at, 1)[0], ti.f64)
                    speed = access.load(reals, places, p, at["velocity"], dim).norm()
                    for i in ti.static(range(2)):
                        for j in ti.static(range(dim - 1)):
                            share = ti.select(i == 0, 1.0 - u[0], u[0]) * ti.select(j == 0, 1.0 - u[1], u[1])
                            table[low[0] + i, low[1] + j, MASS] += share * mass
                            table[low[0] + i, low[1] + j, LIFT] += share * mass * (z - ground)
                            table[low[0] + i, low[1] + j, SPEED] += share * mass * speed
                            table[low[0] + i, low[1] + j, VOLUME] += share * volume

    return add_up


class BasalStates(NamedTuple):
    """The flow over the nodes in plan of a window: `there` (nx, ny) where there is snow, `first` node along x and y,
    `rows` (k,) of these places among all nodes, `states` (k, 4): density [kg/m3], normal stress [Pa], speed [m/s] and
    thickness [m]; volumes (k,): of the particles of each node alone [m3]; cosines (k,): of the slope of the ground;
    gaps (k,): how far the snow would have to fall on the ground, from its mean height above it [m]."""

    there: Any
    first: tuple[int, int]
    rows: Any
    states: Any
    volumes: Any
    cosines: Any
    gaps: Any


class OverGround:
    """Nodes in plan over the ground, and what particles make of them. plan (n, dim - 1) [m]: their places; shape: along
    x and y; cosines: of the slope there; holes: where there is no ground; gravity: magnitude [m/s2]."""

    def __init__(self, lower, upper, dx, height, gravity):
        """lower, upper (dim,) [m]; height(plan) -> (n,), NaN where there is no ground; gravity (dim,) [m/s2]."""
        self._dx, self._base, self.gravity = dx, float(lower[-1]), float(np.linalg.norm(gravity))
        axes = len(lower) - 1
        count = np.ceil((np.asarray(upper) - lower)[:axes] / dx).astype(int) + 1 + 2 * ROOM
        self.shape = (int(count[0]), int(count[1]) if axes == 2 else 1)
        places = [lower[a] + dx * (np.arange(count[a]) - ROOM) for a in range(axes)]
        self.plan = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, axes)
        z = np.asarray(height(self.plan), float).reshape(self.shape)
        self.holes = np.isnan(z)
        if self.holes.any():
            from scipy.ndimage import distance_transform_edt  # slow to import

            z = z[tuple(distance_transform_edt(self.holes, return_distances=False, return_indices=True))]
        self._heights = z
        slopes = [np.gradient(z, dx, axis=a) for a in range(axes)]
        self.cosines = 1.0 / np.sqrt(1.0 + sum(slope**2 for slope in slopes))
        self._rows = np.arange(len(self.plan)).reshape(self.shape)

    def states(self, store):
        """`BasalStates` of the particles (`particles.SortedParticles`) as they are now."""
        edge, axes = EDGE[store.dim], store.dim - 1
        blocks = store.blocks.coordinates[:, :axes]
        # A particle may stray from its block before the next sort; contact asks for nodes beyond it
        low = [int(v) for v in edge * (blocks.min(axis=0) - 1) + ROOM - 2]
        high = [int(v) for v in edge * (blocks.max(axis=0) + 2) + ROOM + 3]
        part = tuple(slice(max(0, min(a, n - 1)), max(1, min(b, n)))
                     for a, b, n in zip([*low, 0], [*high, 1], self.shape, strict=False))
        table = np.zeros((*self._heights[part].shape, 5))
        table[..., HEIGHT] = self._heights[part]
        first = part[0].start - ROOM, part[1].start - ROOM if axes == 2 else 0
        with runtime.precision(store.precision):
            _sums_kernel(store.layout, runtime.DTYPES[store.precision][0])(
                store.reals, store.material, store.materials.numbers, store.start, store.coordinates, table,
                np.array([store.slot_offset, *first, len(store.blocks)], np.int32), np.array([self._dx, self._base]))
        from scipy.ndimage import uniform_filter

        around = (AROUND, AROUND if axes == 2 else 1, 1)
        sums = uniform_filter(table[..., :HEIGHT], size=around, mode="constant")
        there = sums[..., MASS] > 1e-12 * sums[..., MASS].max()
        mass, lift, speed, volume = sums[there].T
        cosine, density = self.cosines[part][there], mass / volume
        depth = _depths(table[..., MASS], sums, self._dx**axes)[there]
        thick = np.maximum(cosine * depth, LEAST_THICKNESS * self._dx)
        sigma = density * self.gravity * thick * cosine
        return BasalStates(there, first, self._rows[part][there],
                           np.column_stack([density, sigma, speed / mass, thick]), table[..., VOLUME][there], cosine,
                           lift / mass - 0.5 * thick / cosine)


class BasalFriction:
    """coefficients: Taichi (nx, ny) of a window of the nodes in plan; window: first node of it along x and y, and how
    many there are (ints)."""

    def __init__(self, law, nodes, dx):
        """law(plan (n, dim - 1)) -> function(rows (k,), states (k, 4)) -> dry part and rate (k, 2) of the law at the
        places of these rows (`ground.states`); nodes: `OverGround`."""
        self._dx, self._nodes = dx, nodes
        self._stress = law(nodes.plan)
        self.window, self.coefficients = (0, 0, 1, 1), real_array(np.zeros((1, 1)))
        self._in_every_step = self._depends_on_speed()
        self._moved, self._changes = np.inf, 0

    def _depends_on_speed(self):
        density, sigma, thick = PROBED
        rows = np.arange(len(self._nodes.plan))
        slow, fast = (self._stress(rows, np.tile([density, sigma, v, thick], (len(rows), 1))) @ [1.0, v]
                      for v in (0.0, 10.0))
        return not np.array_equal(slow, fast)

    def update(self, store, distance):
        """Coefficients under the particles (`particles.SortedParticles`) as they are before a step, in which they move
        by at most `distance` [m]."""
        if not len(store.blocks):
            return
        stale = (self._in_every_step or self._changes != store.changes
                 or self._moved + distance > STALE * self._dx)
        self._moved, self._changes = distance + (0.0 if stale else self._moved), store.changes
        if stale:
            self._compute(store)

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"coefficients": self.coefficients.to_numpy(), "window": self.window, "moved": self._moved}

    def restore(self, state, store):
        """Take over a `state()`, that of the particles in `store` as they are now."""
        self.coefficients = real_array(np.array(state["coefficients"], float))
        first_x, first_y, nx, ny = (int(v) for v in state["window"])
        self.window, self._moved = (first_x, first_y, nx, ny), float(state["moved"])
        self._changes = store.changes

    def _compute(self, store):
        over = self._nodes.states(store)
        sigma, speed = over.states[:, 1:3].T
        dry, rate = self._stress(over.rows, over.states).T
        mu = np.zeros(over.there.shape)
        mu[over.there] = np.maximum(0.0, dry + rate * speed) / np.maximum(sigma, 1e-12)
        self.coefficients, self.window = real_array(mu), (*over.first, *mu.shape)


def _depths(mass, sums, area):
    """Vertical depth [m] at nodes (nx, ny) with `mass` and mean `sums` around them; area: of a node in plan [m2]."""
    from scipy.ndimage import distance_transform_edt, maximum_filter, minimum_filter

    size = tuple(min(AROUND, n) for n in mass.shape)
    wide = tuple(min(AROUND + 2, n) for n in mass.shape)
    full = minimum_filter(mass, size=size, mode="constant") > FULL * maximum_filter(mass, size=wide, mode="constant")
    depth = 2.0 * sums[..., LIFT] / np.maximum(sums[..., MASS], 1e-300)
    inner = sums[..., VOLUME] / area
    if full.any():
        far, nearest = distance_transform_edt(~full, return_indices=True)
        depth = np.where(far <= BESIDE, inner[tuple(nearest)], depth)
    return depth
