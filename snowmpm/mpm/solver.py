"""Explicit MPM: B-splines, or averaged hats for comparison; PIC, APIC, FLIP or AFLIP transfer, symplectic Euler."""

from dataclasses import replace
from typing import Any

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.parallel import runs_serially
from snowmpm.mpm.boundary import Boundary
from snowmpm.mpm.frame import GridFrame
from snowmpm.mpm.grid import TileGrid
from snowmpm.mpm.grid_energy import grid_kinetic_energy
from snowmpm.mpm.grid_update import Blocks, GridArrays, Step, grid_kernels
from snowmpm.mpm.transfer.arrays import Scheme, Tiles
from snowmpm.mpm.transfer.arrays import Step as GatherStep
from snowmpm.mpm.transfer.gather import gather_kernel
from snowmpm.mpm.transfer.scatter import scatter_kernel
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.sorted_particles import SortedParticles, Sorting
from snowmpm.schemes import TRANSFERS
from snowmpm.stepping import step_report
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.contract import Within, Workload
from snowmpm.stepping.method import Damped, Severing, Solver
from snowmpm.stepping.setting import Setting
from snowmpm.stepping.time_step import BREAKING_CFL, USUAL_ADVECTIVE, critical_cfl, grain_stiffness, usual_cfl

PARTICLE_TIME = {2: 6e-8, 3: 1e-7}
"""Of a step on one thread [s], about, by dimension."""


class MpmSolver(Solver, Severing, Damped, Within):
    """Particles, their grid, and one step of both."""

    BAD = "is no longer finite, turned inside out or crossed more than a cell in a step"

    def __init__(self, population, laws, *, transfer="apic", flip_ratio=0.97, kernel="quadratic", gradient="affine",
                 atomic=None, **setting):
        """population: `Population`; laws: one per material index; setting: fields of `Setting`.

        transfer: "pic", "apic", "flip" or "aflip"; flip_ratio: share of FLIP in the last two.
        kernel: a name of `schemes.BASES`; gradient: "affine" (moving least squares) or "shape", see `mpm.scatter`.
        atomic: scatter with atomics, the GPU way; by default as the backend asks. By default cfl follows the state
        (`time_step`).
        """
        given = Setting(**setting)
        self.dim = dim = given.dim
        self.adapters = Adapters(given.adapters)
        self.dx, self.precision, self._real = given.dx, given.precision, runtime.DTYPES[given.precision][0]
        self.atomic = runtime.fine_grained() if atomic is None else atomic
        moving = TRANSFERS[transfer]
        self.flip, self._hands_on = moving.flip, moving.affine
        self.flip_ratio = flip_ratio if moving.flip else 0.0
        self.basis, self._gradient = kernel, gradient
        stiffness = max(grain_stiffness(law, dim) for law in laws)
        self.scheme_name = f"{transfer} ({kernel} kernel, {gradient} gradient, {dim}-D, these materials)"
        self.critical_cfl = critical_cfl(kernel, gradient, transfer, stiffness)
        self.usual_cfl = usual_cfl(self.critical_cfl)
        self.cfl = given.cfl or self.usual_cfl
        self.breaking_cfl = given.cfl or min(BREAKING_CFL, self.cfl)
        self.advective_cfl = given.cfl or min(USUAL_ADVECTIVE, self.cfl)
        frame = self.frame = given.frame(GridFrame)
        period = frame.period(given.walls)
        self.boundary = Boundary(frame, given.walls, given.obstacles, given.ground)
        self.surfaces, self.obstacles = self.boundary.surfaces, self.boundary.obstacles
        self.particles = SortedParticles(
            population, laws, frame, given.gravity,
            Sorting(STENCILS[kernel].drift_limit, self.second_moment(), self.atomic), period,
            self.adapters.of_particles)
        self._begin(population, given.gravity)
        self.serial = runs_serially(PARTICLE_TIME[dim] * max(given.expected, len(population.volumes)))
        fields = next((make(self, population) for make in self.adapters.field_pairs), None)
        self.grid = TileGrid(dim, self.precision, self.surfaces, self.flip, fields, joins=not (fields or period.any()),
                             adapters=self.adapters)
        self._bind_kernels()
        self._reports: Any = None
        self._impulses: Any = None
        self._report = np.zeros(step_report.N_REPORT)
        self._rebuild_for_blocks()
        self.adapters.begin(self)

    @classmethod
    def of(cls, population, laws, options, **setting):
        """Of the choices of a scene's solver table (`snowmpm.methods.MethodEntry`)."""
        return cls(population, laws, kernel=options.kernel, gradient=options.gradient, transfer=options.transfer,
                   flip_ratio=options.flip_ratio, **setting)

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        with runtime.precision(self.precision):
            if self.particles.strayed:
                self.sort()
            pushed = self._act(dt)
            if self.boundary.basal:
                self.boundary.basal.update(self.particles, self.extremes.speed * dt)
            for act in self.adapters.before_scatter:
                act(pushed)
            self.particles_to_grid(pushed)
            for act in self.adapters.after_scatter:
                act(dt, pushed)
            self.update_grid(dt, pushed)
            self.grid_to_particles(dt)
        self._advance_clock(dt, pushed)

    @property
    def contact_work(self):
        """Energy that terrain, sides, obstacles and contact between bodies took [J]."""
        between = self.grid.fields.lost if self.grid.fields else 0.0
        return float(between + self.boundary.work)

    @property
    def obstacle_totals(self):
        """`stepping.contract.PushesObstacles.obstacle_totals`."""
        return self.boundary.given_to_obstacles

    def particles_to_grid(self, dt):
        grid, store = self.grid, self.particles
        owners, work = self._work()
        self._scatter(store.arrays, owners, Tiles(grid.tiles, grid.active_nodes, grid.n_tiles), dt, self.dx, work)

    def update_grid(self, dt, pushed):
        grid = self.grid
        # While an initial state settles, nothing is set in motion yet
        place = self.time + dt if self.damping_factor == 1.0 else -1.0
        if self.boundary.move_to(place):
            grid.rebuild_contact()
        update, write_back = self._update
        arrays = GridArrays(grid.tiles, grid.active_nodes, grid.nodes, grid.contact_offset, grid.first_tile,
                            grid.tiles_at)
        update(arrays, Blocks(grid.node_coordinates, grid.contact.index),
               Step(self._gravity, self._loads, self._n_loads, pushed, self.damping_factor), self._impulses,
               self._loaded, grid.n_node_blocks, grid.node_chunk_bounds)
        if grid.contact.n:
            def to_tiles():
                write_back(arrays, grid.contact.node_block, grid.contact.chunk_bounds)

            if not any([act(dt) for act in self.adapters.meet_surfaces]):
                grid.apply_contact(self.dx)
            for act in self.adapters.after_surfaces:
                act(to_tiles)
            to_tiles()

    def grid_to_particles(self, dt):
        grid, store = self.grid, self.particles
        owners, work = self._work()
        report = self._report
        report.fill(0.0)
        for act in self.adapters.before_gather:
            act(dt)
        self._gather(store.arrays, owners, Tiles(grid.tiles, grid.active_nodes, grid.n_tiles),
                     GatherStep(dt, self.dx, self.flip_ratio), self._reports, report, work)
        for act in self.adapters.after_gather:
            act(dt)
        self._read(report)

    @property
    def _pushing_speed(self):
        """Of the fastest obstacle [m/s]."""
        return self.boundary.speed_at(self.time)

    def _read(self, report):
        super()._read(report)
        self.particles.drift = report[step_report.EXCURSION]

    def sort(self):
        """Bring every particle to its block; those outside the domain are removed and counted."""
        self.particles.sort(self.extremes.speed)
        self._rebuild_for_blocks()

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        self.particles.remove(gone)
        self._rebuild_for_blocks()

    def receive(self, population, numbers):
        """Take in a `Population` with numbers (n,) that no particle has yet."""
        self.particles.add(population, numbers)
        self.extremes = replace(self.extremes, speed=max(self.extremes.speed, float(
            np.linalg.norm(population.velocities, axis=1).max(initial=0.0))))
        self._rebuild_for_blocks()

    def accelerate(self, gain):
        """Add `gain` (n, dim) [m/s] to the velocities, in the order of the rows; counts as a load."""
        self.add_impulse(self.particles.masses() @ gain)
        self.particles.accelerate(gain)
        self.extremes = replace(self.extremes, speed=self.extremes.speed + float(
            np.linalg.norm(gain, axis=1).max(initial=0.0)))

    def _rebuild_for_blocks(self):
        blocks = self.particles.blocks
        self.grid.rebuild(blocks)
        if self._reports is None or self._reports.shape[0] < max(1, len(blocks)):
            self._reports = ti.ndarray(ti.f64, (int(1.25 * len(blocks)) + 8, step_report.N_REPORT))
        if self._impulses is None or self._impulses.shape[0] < max(1, self.grid.n_node_blocks):
            self._impulses = ti.ndarray(ti.f64, (int(1.25 * self.grid.n_node_blocks) + 8, self.dim))

    def _work(self):
        """Which block owns which particles, and how the work is cut: first particles and chunks for the threads of a
        CPU; or the block of each particle and their number."""
        particles = self.particles
        if self.atomic:
            return particles.block_of, particles.count
        return particles.start, particles.chunk_bounds

    def _begin_damping(self):
        self._usual_flip_ratio, self.flip_ratio = self.flip_ratio, 0.0  # FLIP would keep noise that no node sees

    def _end_damping(self):
        self.flip_ratio = self._usual_flip_ratio

    def _step_at(self, elastic, advective):
        dt, cause = super()._step_at(elastic, advective)
        for shorter in self.adapters.limit_dt:
            dt = shorter(dt, self.critical_cfl, elastic)
        return dt, cause

    # ---- set-up -----------------------------------------------------------------------------------------------

    def _bind_kernels(self):
        layout, real, flip = self.particles.layout, self._real, self.flip
        scheme = Scheme(flip, self.basis, self._gradient, self._hands_on)
        how = self.atomic, self.serial, self.adapters.inlined
        self._scatter = scatter_kernel(layout, real, scheme, *how)
        self._update = grid_kernels(self.dim, real, flip, self.serial)
        self._gather = gather_kernel(layout, real, self.materials.functions, scheme, *how)
        self.boundary.bind(real, self.basis, flip, self.serial,
                           self.grid.fields is not None and self.grid.fields.relief is not None)

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def gradient_form(self):
        """ "affine" or "shape"."""
        return self._gradient

    def second_moment(self):
        """D of the affine transfer [m2], sum w (x_i - x_p)(x_i - x_p)^T = D I; 0 for one without an affine part."""
        if not self._hands_on:
            return 0.0
        return self.dx**2 / STENCILS[self.basis].inverse_second_moment

    def grid_kinetic_energy(self):
        """Kinetic energy of the nodes that the particles would give their momentum to now [J]."""
        with runtime.precision(self.precision):
            if self.particles.strayed:
                self.sort()
            self.particles_to_grid(0.0)
        return grid_kinetic_energy(self.grid)

    def null_space_noise(self, energy):
        """Share of the kinetic energy of the particles [J] that the grid cannot see."""
        return 1.0 - self.grid_kinetic_energy() / energy

    @property
    def memory(self):
        """Bytes of everything but the particles."""
        return self.grid.bytes + self.adapters.bytes

    @property
    def workload(self):
        """`Workload` of a step."""
        elastic = self.cfl
        alone = super()._step_at(elastic, self.advective_cfl or elastic)[0]
        return Workload(len(self.particles.blocks), self.grid.n_node_blocks, self.grid.contact.n, len(self.surfaces),
                        sum(bool(obstacle.moving) for obstacle in self.obstacles), self.serial,
                        components=self.adapters.work(),
                        shortened=self.adapters.shortened(alone, self.critical_cfl, elastic))

    def restart_clock(self):
        """Time zero is now: totals start again."""
        super().restart_clock()
        self.boundary.restart()
        if self.grid.fields:
            self.grid.fields.totals[:] = 0.0

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name: particles, blocks, clock, totals."""
        return {**super().state(), "surfaces": self.boundary.state(),
                "between_fields": self.grid.fields.totals.copy() if self.grid.fields else np.zeros(1)}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """
        super().restore(state)
        self._rebuild_for_blocks()
        self.boundary.restore(state["surfaces"], self.particles)
        if self.grid.fields:
            self.grid.fields.totals[:] = state["between_fields"]
