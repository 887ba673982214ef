"""Snow that does nothing is left out of the step until something wakes it.

A block of particles is calm when for the time sqrt(dx / g) each of them kept to

    |v| <= e sqrt(g dx),    |grad v| dx <= e sqrt(g dx)

so its mean acceleration was below 2 e g: forces balance to a share 2 e of the weight. A block sleeps while it and all
blocks around it are calm. Its particles then stand still: velocity and affine velocity zero, place, strain and stress
as they are. Neither scatter nor gather visits them.

Nodes that sleeping particles reach are held at rest, as by rough ground, for the snow that is awake beside them. The
impulse of this, minus the weight of the sleeping snow, and minus the momentum that it had when it fell asleep, is
`impulse`; the kinetic energy that it had then is `energy`. So both balances close to round-off.

A block wakes when a block next to it is no longer calm: a wave, or snow that comes, is seen in the blocks beside the
sleeping ones, which are always awake. It is looked for every EVERY steps, in which a wave crosses less than a block.
Loads, saw cuts and obstacles keep the snow near them awake; other changes from outside wake all. What presses more on
sleeping snow than when it fell asleep wakes it, too (`mpm.press`). While bonds of a weak layer break, all is awake: the
slab bends far ahead of a crack, slower than calm, and a rigid bed would stop it.
"""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.parallel import chunk_bounds
from snowmpm.mpm.node import block_nodes
from snowmpm.mpm.press import Press
from snowmpm.mpm.sleep_kernels import sleep_kernels
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.sorted_particles import BLOCK_COST
from snowmpm.stepping.calm import calm
from snowmpm.stepping.step_report import GRADIENT2, SPEED2, STRAIN, WAVE2

NAMING = 0x9E3779B97F4A7C15
"""Odd factor that makes numbers of keys whose sums hardly ever agree."""
EVERY = 4
"""Steps between two looks at who is calm."""
PRESSED = 8.0
"""Change of the force on a block that wakes it, over its weight and e. Motion that still counts as calm changes its
mean over the time by up to 4."""
AROUND_LOAD = 2.0
"""Cells beyond the radius of a load within which snow stays awake."""


class Sleep:
    """Who sleeps, of the blocks of a `SortedParticles`; `solver` tells it what happens.

    asleep (n,): of each block; share: mass asleep over all; impulse (dim,) [N s] and energy [J]: see above. floors:
    the largest |be - I|^2 and squared wave speed of the sleeping snow, for the next step's length.
    """

    def __init__(self, solver, tolerance, layout, real, basis):
        """tolerance: e above."""
        self._solver, self._kernels = solver, sleep_kernels(layout, real, basis, solver.flip)
        speed, self._window = calm(tolerance, solver.dx, solver.gravity)
        self._speed2 = speed**2
        pull = float(np.linalg.norm(solver.gravity))
        weight = solver.particles.materials.density.max() * pull * (EDGE[solver.dim] * solver.dx) ** solver.dim
        self._press = Press(solver.dim, self._window, PRESSED * tolerance * weight)
        self.impulse, self.energy = np.zeros(solver.dim), 0.0
        self._elapsed, self._steps = 0.0, 0
        self._wake(0)
        self._changes = solver.particles.changes

    def _wake(self, n):
        """n blocks, all awake and not calm yet."""
        self._calm, self.asleep = np.zeros(n), np.zeros(n, bool)
        self._stiffness, self._masses = np.zeros((n, 2)), np.zeros(n)

    # ---- what the solver tells ----------------------------------------------------------------------------------

    def follow(self):
        """The particles have been sorted, some are gone, or they are those of a checkpoint."""
        particles = self._solver.particles
        n, moved = len(particles.blocks), particles.moved
        self._around = None
        if moved is not None and len(self.asleep):
            old, new = moved
            before, asleep, stiffness = self._calm[old], self.asleep[old], self._stiffness[old]
            self._wake(n)
            self._calm[:] = np.inf
            np.minimum.at(self._calm, new, before)
            self.asleep[:] = True
            self.asleep[new[~asleep]] = False
            np.maximum.at(self._stiffness, new, stiffness)
        elif len(self.asleep) != n:
            self._wake(n)
        self._lull(np.flatnonzero(self.asleep))
        self._listed = False
        self.list_work()

    def before_step(self):
        """Whoever changed particles from outside has woken all."""
        if self._changes != self._solver.particles.changes:
            self.stir(np.ones(len(self.asleep), bool))

    def after_step(self, dt, pushed, reports, held):
        """A step of dt [s] has been done in which forces acted for the time `pushed` [s]; its reports, a row a
        block; held: impulses that held node blocks, in the last `dim` of its columns."""
        self.impulse -= pushed * self._masses.sum() * self._solver.gravity
        self._elapsed += dt
        self._steps += 1
        if self._steps < EVERY:
            return
        rows = reports.to_numpy()[: len(self.asleep)]
        loud = (rows[:, SPEED2] > self._speed2) | (rows[:, GRADIENT2] * self._solver.dx**2 > self._speed2)
        loud &= ~self.asleep
        cracks = self._solver.extremes.breaking > 0
        self._calm = np.where(loud | self._kept_awake() | cracks, 0.0, self._calm + self._elapsed)
        if self.asleep.any():
            self._feel(held.to_numpy()[:, self._solver.dim :] / dt)
        self._elapsed, self._steps = 0.0, 0
        self._arrange(rows)

    def _feel(self, forces):
        """Blocks that more presses on than when they fell asleep are no longer calm; forces [N] on node blocks."""
        solver = self._solver
        names = solver.particles.blocks.keys.astype(np.uint64) * np.uint64(NAMING)
        numbers, keys, pattern = solver.grid.held_blocks(self.asleep, names)
        pressed = numbers[self._press.add(keys, pattern, forces[numbers], self._elapsed)]
        if len(pressed):
            self._calm[solver.grid.tiles_around(pressed) & self.asleep] = 0.0

    def stir(self, blocks):
        """Blocks (n,) true are no longer calm: they and those around them are awake from now on."""
        self._changes = self._solver.particles.changes
        self._calm[blocks] = 0.0
        self._arrange()

    def stir_along(self, line, radius):
        """The same around a line in plan (k, dim - 1) [m], in a box that lies `radius` [m] and a cell beyond it."""
        solver = self._solver
        corners = (np.atleast_2d(line) - solver.frame.origin[:-1]) / solver.dx
        lower = EDGE[solver.dim] * solver.particles.blocks.coordinates[:, :-1]
        margin = radius / solver.dx + 1.0
        near = (lower <= corners.max(axis=0) + margin) & (lower + EDGE[solver.dim] >= corners.min(axis=0) - margin)
        self.stir(near.all(axis=1))

    def _kept_awake(self):
        """Blocks beside obstacles, whose load is wanted, and within loads."""
        solver = self._solver
        kept = solver.grid.tiles_near_obstacles
        if not len(solver.load_rows):
            return kept
        kept = kept.copy()
        lower, dim = EDGE[solver.dim] * solver.particles.blocks.coordinates, solver.dim
        for centre, radius in ((row[:dim], row[dim]) for row in solver.load_rows):
            apart = np.maximum(np.maximum(lower - centre, centre - lower - EDGE[dim]), 0.0)
            kept |= (apart**2).sum(axis=1) <= (radius + AROUND_LOAD) ** 2
        return kept

    # ---- who sleeps -----------------------------------------------------------------------------------------------

    def _arrange(self, rows=None):
        """Put to sleep and wake as the calm of the blocks says; rows: reports of the last step, without which nobody
        falls asleep."""
        restless = self._calm < self._window
        awake = restless
        if not restless.all() and restless.any():
            awake = restless[self._neighbours()].any(axis=1)
        if rows is None:
            awake = awake | ~self.asleep
        if np.array_equal(awake, ~self.asleep):
            return
        falling = np.flatnonzero(~awake & ~self.asleep)
        if len(falling):
            self._stiffness[falling] = rows[falling][:, [STRAIN, WAVE2]]
        self.asleep = ~awake
        self._lull(falling)
        self._masses[awake] = 0.0
        self.list_work()

    def _neighbours(self):
        """Numbers of the blocks around each block; its own where there is none, (n, 3^dim)."""
        if self._around is None:
            blocks = self._solver.particles.blocks
            keys = blocks.neighbours()
            number = np.minimum(np.searchsorted(blocks.keys, keys), len(blocks) - 1)
            self._around = np.where(blocks.keys[number] == keys, number, np.arange(len(blocks))[:, None])
        return self._around

    def _lull(self, chosen):
        """Stop the particles of these blocks, and book what they had."""
        if not len(chosen):
            return
        solver, particles = self._solver, self._solver.particles
        sums = np.zeros((len(chosen), 3 + solver.dim))
        with runtime.precision(solver.precision):
            self._kernels.lull(particles.reals, particles.slot_offset, particles.material, particles.materials.numbers,
                               particles.start, chosen.astype(np.int32), solver.grid.active_nodes, sums)
        self._masses[chosen] = sums[:, 0]
        self.energy += 0.5 * float(sums[:, 1].sum() + solver.second_moment() * sums[:, 2].sum())
        self.impulse -= sums[:, 3:].sum(axis=0)

    def list_work(self):
        """Tell the step which tiles, node blocks and contact blocks it has to visit."""
        solver, particles = self._solver, self._solver.particles
        if not self.asleep.any() and not self._listed:
            self.tiles, self.n_tiles = solver.grid.everyone, len(self.asleep)
            self.chunk_bounds = particles.chunk_bounds
            return
        awake = np.flatnonzero(~self.asleep)
        costs = np.diff(particles.blocks.start)[awake] + BLOCK_COST
        self.tiles, self.chunk_bounds, self.n_tiles = int_array(awake), int_array(chunk_bounds(costs)), len(awake)
        emptied, self._listed = solver.grid.visit(self.asleep), bool(self.asleep.any())
        if len(emptied):
            with runtime.precision(solver.precision):
                self._kernels.clear(solver.grid.nodes, solver.grid.contact_offset, block_nodes(solver.dim), emptied)

    # ---- reading ------------------------------------------------------------------------------------------------

    @property
    def all_asleep(self):
        """Whether a step would do nothing."""
        return self.n_tiles == 0 and not any(obstacle.moving for obstacle in self._solver.obstacles)

    @property
    def share(self):
        """Mass that sleeps over all."""
        return min(1.0, float(self._masses.sum() / max(self._solver.particles.mass, 1e-300)))  # but for round-off

    @property
    def floors(self):
        """Largest |be - I|^2 and squared wave speed of the sleeping snow."""
        return self._stiffness[self.asleep].max(axis=0, initial=0.0)

    def restart(self):
        """Time zero is now: all is awake."""
        self.impulse[:], self.energy, self._elapsed, self._steps = 0.0, 0.0, 0.0, 0
        self.stir(np.ones(len(self.asleep), bool))

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"calm": self._calm.copy(), "asleep": self.asleep.copy(), "stiffness": self._stiffness.copy(),
                "impulse": self.impulse.copy(), "energy": self.energy, "elapsed": self._elapsed, "steps": self._steps,
                "press": self._press.state()}

    def restore(self, state):
        """Take over a `state()`; `follow` comes next."""
        self._wake(len(state["asleep"]))
        self._calm[:], self.asleep[:], self._stiffness[:] = state["calm"], state["asleep"], state["stiffness"]
        self.impulse[:], self.energy = state["impulse"], float(state["energy"])
        self._elapsed, self._steps = float(state["elapsed"]), int(state["steps"])
        self._press.restore(state["press"])
        self._changes = self._solver.particles.changes
