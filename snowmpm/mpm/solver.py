"""Explicit MPM: quadratic or cubic B-splines, PIC, APIC, FLIP or AFLIP transfer, symplectic Euler."""

from dataclasses import asdict, replace

import numpy as np
import taichi as ti

from snowmpm import runtime
from snowmpm.blocks import EDGE, LEAD, BlockMap, sort_kernels
from snowmpm.errors import InputError, SimulationError
from snowmpm.material_table import MaterialTable
from snowmpm.mpm import report as report_of
from snowmpm.mpm.arrays import int_array, real_array
from snowmpm.mpm.body_contact import BodyContact
from snowmpm.mpm.gather import gather_kernel
from snowmpm.mpm.grid import TileGrid, grid_kernels
from snowmpm.mpm.grid_energy import grid_kinetic_energy
from snowmpm.mpm.scatter import scatter_kernel
from snowmpm.mpm.solid_field import SolidField
from snowmpm.mpm.surface import Plane, Surface
from snowmpm.mpm.walls import Walls
from snowmpm.particles import IDENTITY, Layout, ParticleStore
from snowmpm.severing import sever_kernel
from snowmpm.stencil import STENCILS
from snowmpm.timestep import FLIGHT_LIMIT, Extremes, critical_cfl, grain_stiffness, stable_step, usual_cfl


class MpmSolver:
    """Particles, their grid, and one step of both.

    Lengths inside are cells from `origin` (scene coordinates of grid node 0). Totals since the start: `impulse` of
    terrain, sides and loads and `weight_impulse` [N s], `contact_work` and `plastic_work` [J], `unconverged` return
    maps, and `removed` (count, mass [kg], momentum [kg m/s], energy [J]: kinetic, elastic and -m g.x) of the particles
    that left through open sides.
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
        self.origin, self.gravity = np.asarray(origin, float), np.asarray(gravity, float)
        self.lower, self.upper = ((np.asarray(b, float) - self.origin) / dx for b in (lower, upper))
        self.atomic = runtime.backend() == "cuda" if atomic is None else atomic
        self.flip = "flip" in transfer
        self._affine_share, self.flip_ratio = float(transfer in ("apic", "aflip")), flip_ratio if self.flip else 0.0
        self.basis, self._gradient = kernel, gradient
        self._home_limit = STENCILS[kernel].home_limit
        self.materials = MaterialTable(laws, precision)
        stiffness = max(grain_stiffness(law, dim) for law in laws)
        self.critical_cfl = critical_cfl(kernel, gradient, transfer, stiffness)
        self.cfl = cfl or usual_cfl(self.critical_cfl)
        self._gravity = real_array(self.gravity)
        sides = sides or [["open", "open"]] * dim
        self._period = self._periods(sides)
        self._limits = (np.where(self._period > 0, -np.inf, self.lower), np.where(self._period > 0, np.inf, self.upper))
        self.surfaces = self._sides(sides)
        if terrain is not None:
            geometry = Walls(dim, precision, self._wall_distance(terrain))
            self.surfaces.insert(0, Surface(geometry, dim, terrain_contact, terrain_friction))
        self.obstacles = [self._solid(obstacle) for obstacle in obstacles]
        self.surfaces += self.obstacles
        self._populate(population)
        bodies = self._meeting_bodies(population, body_friction)
        self.grid = TileGrid(dim, precision, self.surfaces, self.flip, bodies)
        self._bind_kernels()
        self._follow_blocks()
        self.time, self.steps, self.sorts = 0.0, 0, 0
        self.keep = 1.0
        """Share of a node's velocity kept each step: below 1 only while an initial state settles."""
        self._loaded = np.zeros(dim)
        self.weight_impulse = np.zeros(dim)
        self.plastic_work, self.unconverged, self.n_plastic = 0.0, 0, 0
        self.removed = {"count": 0, "mass": 0.0, "energy": 0.0, "momentum": np.zeros(dim)}
        self.set_loads([])

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        with runtime.precision(self.precision):
            if self._excursion >= self._home_limit:
                self.sort()
            self.particles_to_grid(dt)
            self.update_grid(dt)
            self.grid_to_particles(dt)
        self.weight_impulse += dt * self.mass * self.gravity
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
        strayed = [surface.follow(place, self.origin, self.dx) for surface in self.obstacles if surface.moving]
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
        self._excursion = report[report_of.EXCURSION]
        self.plastic_work += report[report_of.DISSIPATION]
        self.unconverged += int(report[report_of.UNCONVERGED])
        self.n_plastic = int(report[report_of.PLASTIC])

    def _fail(self, p):
        x = self.positions()[p]
        identity = self.particles.labels()[p, IDENTITY]
        raise SimulationError(
            f"particle {identity} is no longer finite, turned inside out or crossed more than a cell in a step, at"
            f" t = {self.time:.6g} s, step {self.steps}, near {np.array2string(x, precision=3)} m:\n"
            "lower solver.cfl or check the stiffness of its material")

    # ---- blocks -----------------------------------------------------------------------------------------------

    def sort(self):
        """Bring every particle home to its block; those outside the domain are removed and counted."""
        blocks, store = self.blocks, self.particles
        counts = int_array(np.zeros((len(blocks), 3**self.dim)))
        lower, upper = (ti.Vector(limit) for limit in self._limits)
        lead = LEAD * self._home_limit
        ahead = lead / max(self.extremes.speed, 1e-30)
        self._count_moves(store.reals, store.turn, self.grid.start, self.grid.coordinates, lower, upper, ahead, lead,
                          counts, store.target, self.grid.shares)
        counts = counts.to_numpy()[: len(blocks)]
        alive = int(counts.sum())
        if alive < store.count:
            self._count_removed()
        used = counts > 0
        keys, block_of_move = np.unique(blocks.neighbours()[used], return_inverse=True)
        order = np.argsort(block_of_move, kind="stable")
        sizes = counts[used]
        first = np.empty(len(sizes), np.int64)
        first[order] = np.cumsum(sizes[order]) - sizes[order]
        target = np.zeros(counts.shape, np.int64)
        target[used] = first
        self._aim(store.reals, store.turn, self.grid.start, int_array(target), store.target, self.grid.shares)
        store.move(alive)
        self.blocks = BlockMap(keys, np.bincount(block_of_move, sizes, len(keys)).astype(np.int64), self.dim,
                               self._period)
        self._follow_blocks()
        self.sorts += 1

    def _follow_blocks(self):
        self.grid.fit(self.blocks)
        if self._reports is None or self._reports.shape[0] < max(1, len(self.blocks)):
            self._reports = ti.ndarray(ti.f64, (int(1.25 * len(self.blocks)) + 8, report_of.N_REPORT))
        if self._impulses is None or self._impulses.shape[0] < max(1, self.grid.n_node_blocks):
            self._impulses = ti.ndarray(ti.f64, (int(1.25 * self.grid.n_node_blocks) + 8, self.dim))
        if self.atomic:
            self._block_of = int_array(np.repeat(np.arange(len(self.blocks)), np.diff(self.blocks.start)))
        self._excursion = 0.0

    def _count_removed(self):
        cells = (self.positions() - self.origin) / self.dx
        self._tally_removed(~((cells >= self._limits[0]) & (cells < self._limits[1])).all(axis=1))

    def _tally_removed(self, gone):
        mass = self.masses()[gone]
        self.removed["count"] += int(gone.sum())
        self.removed["mass"] += float(mass.sum())
        self.mass -= float(mass.sum())
        velocity, affine = self.column("velocity")[gone], self.column("affine")[gone]
        self.removed["momentum"] += mass @ velocity
        square = (velocity**2).sum(axis=1) + self.second_moment() * (affine**2).sum(axis=1)
        elastic = self.materials.elastic_energy(*(values[gone] for values in (
            self.particles.labels()[:, 0], self.column("stress"), self.column("state"), self.column("volume")[:, 0])))
        self.removed["energy"] += float(mass @ (0.5 * square - self.positions()[gone] @ self.gravity)) + elastic

    def _work(self):
        """Particles by block and the shares of the CPU's threads, or the block of each particle and their number."""
        return (self._block_of, self.particles.count) if self.atomic else (self.grid.start, self.grid.shares)

    # ---- set-up -----------------------------------------------------------------------------------------------

    def _populate(self, population):
        layout = Layout(self.dim, self.materials.state_size, by_row=runtime.backend() == "cpu")
        cells = (population.positions - self.origin) / self.dx
        self.blocks, order, local = BlockMap.from_cells(cells, self.dim, self._period, population.field)
        self.particles = ParticleStore(layout, len(order), self.precision)
        material = population.material[order]
        columns = {"position": local, "velocity": population.velocities[order], "volume": population.volumes[order],
                   "volume_ratio": np.ones(len(order)), "state": self.materials.initial_state[material],
                   "elastic": population.elastic[order], "stress": population.stress[order]}
        self.particles.fill(columns, material, order)
        self.mass = float(population.volumes @ self.materials.density[population.material])
        self.extremes = Extremes(speed=float(np.linalg.norm(population.velocities, axis=1).max(initial=0.0)),
                                 elastic_deviation=float(np.linalg.norm(population.elastic, axis=1).max(initial=0.0)))
        self._reports = self._impulses = self._block_of = None

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
        self._count_moves, self._aim = sort_kernels(layout)

    def _wall_distance(self, terrain):
        def wall_distance(nodes):
            distance, normal = terrain.query(self.origin + self.dx * nodes)
            return distance / self.dx, normal
        return wall_distance

    def _sides(self, sides):
        """Surfaces of the sides that are not open; sides (dim, 2) names."""
        levels = np.stack([self.lower, self.upper], axis=1)
        return [Surface(Plane(axis, 1 - 2 * end, levels[axis, end]), self.dim, sides[axis][end])
                for axis in range(self.dim) for end in range(2) if sides[axis][end] not in ("open", "periodic")]

    def _meeting_bodies(self, population, friction):
        """`BodyContact` of a population with several velocity fields, else None."""
        fields, volumes = population.field, population.volumes
        if fields.max(initial=0) == 0:
            return None
        masses = volumes * self.materials.density[population.material]
        mass, volume = np.bincount(fields, masses), np.bincount(fields, volumes)
        density = mass / np.where(volume > 0.0, volume, 1.0)
        return BodyContact(self.dim, runtime.DTYPES[self.precision][0], self.flip, friction, density)

    def _solid(self, obstacle):
        geometry = SolidField(obstacle, dim=self.dim, precision=self.precision, origin=self.origin, dx=self.dx)
        surface = Surface(geometry, self.dim, obstacle.contact, obstacle.friction, tracked=True,
                          moving=not obstacle.still)
        surface.follow(0.0, self.origin, self.dx)
        return surface

    def _periods(self, sides):
        """Blocks after which each axis repeats, 0 where it does not, (dim,)."""
        period, edge = np.zeros(self.dim, np.int64), EDGE[self.dim]
        for axis, names in enumerate(sides):
            if "periodic" in names:
                blocks = (self.upper[axis] - self.lower[axis]) / edge
                if abs(blocks - round(blocks)) > 1e-6 or round(blocks) < 1 or abs(self.lower[axis]) > 1e-9:
                    raise InputError("domain.boundary = periodic: the domain must be a whole number of"
                                     f" {edge * self.dx:g} m ({edge} cells) long, not {blocks * edge * self.dx:g} m")
                period[axis] = round(blocks)
        return period

    def set_loads(self, loads):
        """loads: [(centre (dim,) [m, scene], radius [m], acceleration (dim,) [m/s2])] that act on grid nodes."""
        rows = [[*((np.asarray(centre) - self.origin) / self.dx), radius / self.dx, *acceleration]
                for centre, radius, acceleration in loads]
        self._n_loads = len(rows)
        self._loads = real_array(rows or [[0.0] * (2 * self.dim + 1)])

    # ---- reading ----------------------------------------------------------------------------------------------

    def column(self, name):
        """Copy of one column group of the particle table, float64, (n, size)."""
        return self.particles.table()[:, self.particles.layout.columns(name)].astype(np.float64)

    def positions(self, local=None, blocks=None):
        """Scene coordinates of the particles [m], (n, dim); local: their position columns when already at hand, blocks:
        the `BlockMap` that they belong to."""
        local = self.column("position") if local is None else local
        blocks = blocks or self.blocks
        home = np.repeat(blocks.coordinates, np.diff(blocks.start), axis=0)
        cells = EDGE[self.dim] * home + local
        length = EDGE[self.dim] * self._period
        return self.origin + self.dx * np.where(length > 0, cells % np.maximum(length, 1), cells)

    def second_moment(self):
        """D of the affine transfer [m2], sum w (x_i - x_p)(x_i - x_p)^T = D I; 0 for one without an affine part."""
        return self._affine_share * self.dx**2 / STENCILS[self.basis].inverse_second_moment

    def grid_kinetic_energy(self):
        """Kinetic energy of the nodes that the particles would give their momentum to now [J]."""
        with runtime.precision(self.precision):
            if self._excursion >= self._home_limit:
                self.sort()
            self.particles_to_grid(0.0)
        return grid_kinetic_energy(self.grid)

    def rewrite(self, table):
        """Put back a changed copy of `particles.table()`; positions and volumes must stay."""
        self.particles.overwrite(table)

    def sever(self, line, radius, numbers, state):
        """Cut the bonds of the particles numbers[0] <= number < numbers[1] within `radius` [m] of a line in plan
        (k, dim - 1) [m]: no stress, and the law's severed `state`."""
        real, numpy_real = runtime.DTYPES[self.precision]
        line = np.ascontiguousarray((line - self.origin[:-1]) / self.dx, numpy_real)
        store, grid = self.particles, self.grid
        with runtime.precision(self.precision):
            return sever_kernel(store.layout, real)(
                store.reals, store.turn, store.identity, grid.start, grid.coordinates, line, radius / self.dx, *numbers,
                np.array(state, numpy_real), grid.n_tiles)

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        keep = ~np.asarray(gone, bool)
        self._tally_removed(~keep)
        table, labels = self.particles.table()[keep], self.particles.labels()[keep]
        home = np.repeat(np.arange(len(self.blocks)), np.diff(self.blocks.start))[keep]
        counts = np.bincount(home, minlength=len(self.blocks))
        filled = counts > 0
        columns = {name: table[:, self.particles.layout.columns(name)] for name in self.particles.layout.sizes}
        self.particles.fill(columns, labels[:, 0], labels[:, 1])
        self.blocks = BlockMap(self.blocks.keys[filled], counts[filled], self.dim, self._period)
        excursion = self._excursion
        self._follow_blocks()
        self._excursion = excursion

    def masses(self):
        """Masses of the particles [kg] (per metre of width in 2-D), (n,)."""
        return self.column("volume")[:, 0] * self.materials.density[self.particles.labels()[:, 0]]

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
            "reals": np.ascontiguousarray(self.particles.table()), "labels": self.particles.labels(),
            "keys": self.blocks.keys, "start": self.blocks.start, "excursion": self._excursion,
            "frame": np.array([self.origin, self.lower, self.upper]), "extremes": asdict(self.extremes),
            "time": self.time, "steps": self.steps, "sorts": self.sorts, "mass": self.mass,
            "loaded": self._loaded.copy(), "surfaces": np.array([surface.total for surface in self.surfaces]),
            "weight_impulse": self.weight_impulse.copy(),
            "lost_between_bodies": self.grid.bodies.lost.copy() if self.grid.bodies else np.zeros(1),
            "plastic_work": self.plastic_work, "unconverged": self.unconverged, "n_plastic": self.n_plastic,
            "removed": {**self.removed, "momentum": self.removed["momentum"].copy()},
        }

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """
        reals, frame = state["reals"], np.array([self.origin, self.lower, self.upper])
        if reals.shape[1:] != (self.particles.layout.width,) or reals.dtype != self.particles.numpy_dtype:
            raise InputError("the particles of the checkpoint carry other columns: it is from another version")
        if not np.array_equal(frame, state["frame"]):
            raise InputError("the domain is not the checkpoint's: without domain.min and domain.max it follows"
                             " end_time, which then must stay as it was")
        self.particles.replace(reals, state["labels"])
        self.blocks = BlockMap(state["keys"], np.diff(state["start"]), self.dim, self._period)
        self._follow_blocks()
        self._excursion, self.extremes = state["excursion"], Extremes(**state["extremes"])
        self.time, self.steps, self.sorts, self.mass = (state[name] for name in ("time", "steps", "sorts", "mass"))
        self._loaded[:], self.weight_impulse[:] = state["loaded"], state["weight_impulse"]
        for surface, total in zip(self.surfaces, state["surfaces"], strict=True):
            surface.total[:] = total
        if self.grid.bodies:
            self.grid.bodies.lost[:] = state["lost_between_bodies"]
        self.plastic_work, self.unconverged = state["plastic_work"], state["unconverged"]
        self.n_plastic, self.removed = state["n_plastic"], dict(state["removed"])
