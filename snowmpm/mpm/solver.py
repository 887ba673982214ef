"""Explicit MPM: quadratic or cubic B-splines, PIC, APIC, FLIP or AFLIP transfer, symplectic Euler."""

from dataclasses import asdict, replace

import numpy as np
import taichi as ti

from snowmpm import report as report_of
from snowmpm import runtime
from snowmpm.arrays import real_array
from snowmpm.errors import SimulationError
from snowmpm.mpm.body_contact import BodyContact
from snowmpm.mpm.frame import GridFrame
from snowmpm.mpm.gather import gather_kernel
from snowmpm.mpm.grid import TileGrid, grid_kernels
from snowmpm.mpm.grid_energy import grid_kinetic_energy
from snowmpm.mpm.scatter import scatter_kernel
from snowmpm.sorted_particles import SortedParticles
from snowmpm.stencil import STENCILS
from snowmpm.timestep import FLIGHT_LIMIT, Extremes, critical_cfl, grain_stiffness, stable_step, usual_cfl


class MpmSolver:
    """Particles, their grid, and one step of both.

    particles: `SortedParticles`. Totals since the start: `impulse` of terrain, sides and loads and `weight_impulse`
    [N s], `contact_work` and `plastic_work` [J], `unconverged` return maps.
    """

    def __init__(self, population, laws, *, dx, precision, origin, lower, upper, gravity, cfl=None, terrain=None,
                 terrain_contact="stick", terrain_friction=0.0, sides=None, transfer="apic", flip_ratio=0.97,
                 kernel="quadratic", gradient="affine", obstacles=(), body_friction=((0.0,),), atomic=None):
        """population: `Population`; laws: one per material index; lower, upper, origin: scene coordinates [m].

        terrain: object with `query(points) -> distance, normal` in scene coordinates, or None.
        transfer: "pic", "apic", "flip" or "aflip"; flip_ratio: share of FLIP in the last two.
        obstacles: `solids.Obstacle`s. body_friction (n, n): Coulomb mu between the velocity fields of the population.
        cfl: share of a cell that a wave or a particle may cross in a step, `timestep.usual_cfl` by default.
        kernel: "quadratic" or "cubic"; gradient: "affine" (moving least squares) or "shape", see `mpm.scatter`.
        sides: (dim, 2) names of `contact.CODES`, "open" by default, or "periodic" at both ends of an axis, whose length
        must be a whole number of blocks (8 cells in 2-D, 4 in 3-D).
        atomic: scatter with atomics, the GPU way; by default as the backend asks.
        """
        self.dim = dim = len(origin)
        self.dx, self.precision = dx, precision
        self.gravity = np.asarray(gravity, float)
        self._gravity = real_array(self.gravity)
        self.atomic = runtime.backend() == "cuda" if atomic is None else atomic
        self.flip = "flip" in transfer
        self._affine_share, self.flip_ratio = float(transfer in ("apic", "aflip")), flip_ratio if self.flip else 0.0
        self.basis, self._gradient = kernel, gradient
        stiffness = max(grain_stiffness(law, dim) for law in laws)
        self.scheme_name = f"{transfer} ({kernel} kernel, {gradient} gradient, {dim}-D, these materials)"
        self.critical_cfl = critical_cfl(kernel, gradient, transfer, stiffness)
        self.cfl = cfl or usual_cfl(self.critical_cfl)
        frame = self.frame = GridFrame(dim, precision, origin, dx, lower, upper)
        sides = sides or [["open", "open"]] * dim
        period = frame.period(sides)
        self.obstacles = [frame.solid(obstacle) for obstacle in obstacles]
        ground = [] if terrain is None else [frame.terrain(terrain, terrain_contact, terrain_friction)]
        self.surfaces = [*ground, *frame.sides(sides), *self.obstacles]
        self.particles = SortedParticles(
            population, laws, dx=dx, precision=precision, origin=frame.origin, limits=frame.limits(period),
            gravity=gravity, home_limit=STENCILS[kernel].home_limit, second_moment=self.second_moment(), period=period,
            keep_block_of=self.atomic)
        self.materials = self.particles.materials
        self.extremes = Extremes(speed=float(np.linalg.norm(population.velocities, axis=1).max(initial=0.0)),
                                 elastic_deviation=float(np.linalg.norm(population.elastic, axis=1).max(initial=0.0)))
        bodies = self._meeting_bodies(population, body_friction)
        self.grid = TileGrid(dim, precision, self.surfaces, self.flip, bodies)
        self._bind_kernels()
        self._reports = self._impulses = None
        self._follow_blocks()
        self.time, self.steps = 0.0, 0
        self.keep = 1.0
        """Share of a node's velocity kept each step: below 1 only while an initial state settles."""
        self._loaded = np.zeros(dim)
        self.weight_impulse = np.zeros(dim)
        self.plastic_work, self.unconverged, self.n_plastic = 0.0, 0, 0
        self.set_loads([])

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        with runtime.precision(self.precision):
            if self.particles.strayed:
                self.sort()
            self.particles_to_grid(dt)
            self.update_grid(dt)
            self.grid_to_particles(dt)
        self.weight_impulse += dt * self.particles.mass * self.gravity
        self.time += dt
        self.steps += 1

    @property
    def impulse(self):
        """Impulse that terrain, sides and loads gave [N s], (dim,)."""
        return self._loaded + sum((surface.total[: self.dim] for surface in self.surfaces), np.zeros(self.dim))

    @property
    def contact_work(self):
        """Energy that terrain, sides, obstacles and contact between bodies took [J]."""
        between = self.grid.bodies.lost[0] if self.grid.bodies else 0.0
        return float(between + sum(surface.total[self.dim] for surface in self.surfaces))

    @property
    def obstacle_totals(self):
        """Impulse [N s], its moment about the centre of rotation [N s m] (1 number in 2-D, 3 in 3-D) and work [J] that
        the snow gave each obstacle, (n, dim + 1 or 3 + 1)."""
        rows = [surface.given_to_solid(self.dx) for surface in self.obstacles]
        return np.array(rows).reshape(len(rows), self.dim + (1 if self.dim == 2 else 3) + 1)

    def particles_to_grid(self, dt):
        grid, store = self.grid, self.particles
        home, work = self._work()
        self._scatter(store.reals, store.turn, store.material, self.materials.numbers, home, grid.boxes, grid.tiles,
                      grid.impulses, dt, self.dx, grid.n_tiles, work)

    def update_grid(self, dt):
        grid = self.grid
        # While an initial state settles, nothing is set in motion yet
        place = self.time + dt if self.keep == 1.0 else -1.0
        strayed = [surface.follow(place, self.frame.origin, self.dx) for surface in self.obstacles if surface.moving]
        if any(strayed):
            grid.fit_contact()
        self._update(grid.tiles, grid.impulses, grid.boxes, grid.nodes, grid.room, grid.first_tile, grid.tiles_at,
                     grid.node_coordinates, grid.contact.index, self._loads, self._gravity, dt, self.keep,
                     self._impulses, self._loaded, self._n_loads, grid.n_node_blocks, grid.node_shares)
        if grid.contact.n:
            grid.act(self.dx)
            self._write_back(grid.tiles, grid.impulses, grid.boxes, grid.nodes, grid.room, grid.first_tile,
                             grid.tiles_at, grid.contact.node_block, grid.contact.shares)

    def grid_to_particles(self, dt):
        grid, store = self.grid, self.particles
        home, work = self._work()
        report = np.zeros(report_of.N_REPORT)
        self._gather(store.reals, store.turn, store.material, self.materials.numbers, self.materials.law_of, home,
                     grid.boxes, grid.tiles, grid.impulses, dt, self.dx, self.flip_ratio, self._reports, report,
                     grid.n_tiles, work)
        self._read(report)

    def stable_dt(self):
        """-> (step for now [s], what limits it), with the margin of cfl."""
        return self._step_at(self.cfl, self.cfl)

    def critical_dt(self):
        """-> (longest step that is not unstable [s], what limits it)."""
        return self._step_at(self.critical_cfl, FLIGHT_LIMIT)

    def _step_at(self, elastic, advective):
        pushed = max((surface.speed_at(self.time) for surface in self.obstacles), default=0.0)
        extremes = replace(self.extremes, speed=max(pushed, self.extremes.speed))
        return stable_step(self.dx, elastic, advective, self.materials.wave_speed, extremes)

    def _read(self, report):
        if report[report_of.BAD]:
            self._fail(int(report[report_of.BAD]) - 1)
        self.extremes = Extremes(speed=report[report_of.SPEED2] ** 0.5, gradient=report[report_of.GRADIENT2] ** 0.5,
                                 elastic_deviation=report[report_of.STRAIN] ** 0.5,
                                 wave_speed=report[report_of.WAVE2] ** 0.5)
        self.particles.drift = report[report_of.EXCURSION]
        self.plastic_work += report[report_of.DISSIPATION]
        self.unconverged += int(report[report_of.UNCONVERGED])
        self.n_plastic = int(report[report_of.PLASTIC])

    def _fail(self, row):
        particle, place = self.particles.describe(row)
        raise SimulationError(
            f"{particle} is no longer finite, turned inside out or crossed more than a cell in a step, at"
            f" t = {self.time:.6g} s, step {self.steps}, {place}:\n"
            "lower solver.cfl or check the stiffness of its material")

    def sort(self):
        """Bring every particle home to its block; those outside the domain are removed and counted."""
        self.particles.sort(self.extremes.speed)
        self._follow_blocks()

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        self.particles.remove(gone)
        self._follow_blocks()

    def _follow_blocks(self):
        blocks = self.particles.blocks
        self.grid.fit(blocks)
        if self._reports is None or self._reports.shape[0] < max(1, len(blocks)):
            self._reports = ti.ndarray(ti.f64, (int(1.25 * len(blocks)) + 8, report_of.N_REPORT))
        if self._impulses is None or self._impulses.shape[0] < max(1, self.grid.n_node_blocks):
            self._impulses = ti.ndarray(ti.f64, (int(1.25 * self.grid.n_node_blocks) + 8, self.dim))

    def _work(self):
        """Particles by block and the shares of the CPU's threads, or the block of each particle and their number."""
        particles = self.particles
        return (particles.block_of, particles.count) if self.atomic else (particles.start, particles.shares)

    def begin_settling(self):
        """Before the damped steps of `settling`."""
        self._usual_flip_ratio, self.flip_ratio = self.flip_ratio, 0.0  # FLIP would keep noise that no node sees

    def end_settling(self):
        """After them."""
        self.keep, self.flip_ratio = 1.0, self._usual_flip_ratio

    # ---- set-up -----------------------------------------------------------------------------------------------

    def _bind_kernels(self):
        real = runtime.DTYPES[self.precision][0]
        layout = self.particles.layout
        self._scatter = scatter_kernel(layout, real, self.atomic, self.flip, self.basis, self._gradient,
                                       self._affine_share > 0.0)
        self._update, self._write_back = grid_kernels(self.dim, real, self.flip)
        for surface in self.surfaces:
            surface.bind(real, self.basis, self.flip)
        self._gather = gather_kernel(layout, real, self.materials.functions, self.materials.n_parameters, self.atomic,
                                     self.flip, self.basis, self._gradient, self._affine_share > 0.0)

    def _meeting_bodies(self, population, friction):
        """`BodyContact` of a population with several velocity fields, else None."""
        fields, volumes = population.field, population.volumes
        if fields.max(initial=0) == 0:
            return None
        masses = volumes * self.materials.density[population.material]
        mass, volume = np.bincount(fields, masses), np.bincount(fields, volumes)
        density = mass / np.where(volume > 0.0, volume, 1.0)
        return BodyContact(self.dim, runtime.DTYPES[self.precision][0], self.flip, friction, density)

    def set_loads(self, loads):
        """loads: [(centre (dim,) [m, scene], radius [m], acceleration (dim,) [m/s2])] that act on grid nodes."""
        rows = [[*((np.asarray(centre) - self.frame.origin) / self.dx), radius / self.dx, *acceleration]
                for centre, radius, acceleration in loads]
        self._n_loads = len(rows)
        self._loads = real_array(rows or [[0.0] * (2 * self.dim + 1)])

    def push(self, numbers, gain, mass):
        """Add `gain` (dim,) [m/s] to the velocity of the particles numbers[0] <= number < numbers[1], whose mass is
        `mass` [kg]; counts as a load."""
        self.particles.push(numbers, gain)
        self._loaded += mass * np.asarray(gain)

    # ---- reading ----------------------------------------------------------------------------------------------

    def second_moment(self):
        """D of the affine transfer [m2], sum w (x_i - x_p)(x_i - x_p)^T = D I; 0 for one without an affine part."""
        return self._affine_share * self.dx**2 / STENCILS[self.basis].inverse_second_moment

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
    def bytes(self):
        """Memory of everything but the particles."""
        return self.grid.bytes

    def restart_clock(self):
        """Time zero is now: totals start again."""
        self.time, self.steps, self.plastic_work, self.unconverged = 0.0, 0, 0.0, 0
        self._loaded[:] = 0.0
        for surface in self.surfaces:
            surface.total[:] = 0.0
        if self.grid.bodies:
            self.grid.bodies.lost[:] = 0.0
        self.weight_impulse[:] = 0.0

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name: particles, blocks, clock, totals."""
        return {
            **self.particles.state(),
            "frame": self.frame.bounds, "extremes": asdict(self.extremes),
            "time": self.time, "steps": self.steps,
            "loaded": self._loaded.copy(), "surfaces": np.array([surface.total for surface in self.surfaces]),
            "weight_impulse": self.weight_impulse.copy(),
            "lost_between_bodies": self.grid.bodies.lost.copy() if self.grid.bodies else np.zeros(1),
            "plastic_work": self.plastic_work, "unconverged": self.unconverged, "n_plastic": self.n_plastic,
        }

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """
        self.frame.check(state["frame"])
        self.particles.restore(state)
        self._follow_blocks()
        self.extremes = Extremes(**state["extremes"])
        self.time, self.steps = state["time"], state["steps"]
        self._loaded[:], self.weight_impulse[:] = state["loaded"], state["weight_impulse"]
        for surface, total in zip(self.surfaces, state["surfaces"], strict=True):
            surface.total[:] = total
        if self.grid.bodies:
            self.grid.bodies.lost[:] = state["lost_between_bodies"]
        self.plastic_work, self.unconverged = state["plastic_work"], state["unconverged"]
        self.n_plastic = state["n_plastic"]
