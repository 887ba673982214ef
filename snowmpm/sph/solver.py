"""Explicit finite-strain SPH: updated Lagrangian, staggered leapfrog.

    v^{n+1/2} = v^{n-1/2} + dt a(x^n, tau^n)        momentum.py
    f = I + dt L(v^{n+1/2}, x^n),  tau^{n+1} = law  update.py
    x^{n+1} = x^n + dt v^{n+1/2}

(Favero Neto & Borja 2018, doi:10.1007/s11440-018-0700-3; choices beyond theirs from Bui & Nguyen 2021,
doi:10.1016/j.compgeo.2021.104315, and Peng et al. 2015, doi:10.1007/s11440-015-0399-3.) Stress and velocity are never
advanced from the same level, which is forward Euler and blows up.
"""

import math
from typing import Any

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.parallel import runs_serially
from snowmpm.materials.packs import LANES
from snowmpm.particles.sorted_particles import SortedParticles, Sorting
from snowmpm.sph.boundary import Boundary
from snowmpm.sph.courant import critical_cfl, usual_cfl
from snowmpm.sph.extrapolation import Extrapolation, extrapolation_kernel
from snowmpm.sph.forces import Forces, terms_of
from snowmpm.sph.lengths import Support, largest, least
from snowmpm.sph.momentum import momentum_kernel
from snowmpm.sph.neighbourhood import Neighbourhood
from snowmpm.sph.operators import Operators
from snowmpm.sph.order import order_kernel
from snowmpm.sph.regularisation import Regularisation
from snowmpm.sph.row_cache import RowCache, row_kernels
from snowmpm.sph.rows import RowLayout, Rows
from snowmpm.sph.smoothing import KERNELS
from snowmpm.sph.update import Report, Step, Terms, update_kernel
from snowmpm.stepping import step_report
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.contract import Workload
from snowmpm.stepping.method import Damped, Severing, Solver
from snowmpm.stepping.setting import Setting
from snowmpm.stepping.time_step import BREAKING_CFL

PARTICLE_TIME = {2: 2.5e-7, 3: 1.5e-6}
"""Of a step on one thread [s], about, by dimension."""


class SphSolver(Solver, Severing, Damped):
    """Particles, their neighbours, and one step of both.

    particles: `SortedParticles`, a particle a cell of dx.
    """

    BAD = "is no longer finite or turned inside out"
    DAMPED_IMPULSE = False

    def __init__(self, population, laws, *, scheme, width=None, **setting):
        """population: `Population`; laws: one per material index; setting: fields of `Setting`, of which cfl is less
        while bonds break where it is not given. scheme: what `snowmpm.scenes.Sph` has. width: lanes of a pack, as the
        backend asks."""
        given = Setting(**setting)
        self.dim = dim = given.dim
        self.dx, self.precision, self.scheme = given.dx, given.precision, scheme
        self.adapters = Adapters(given.adapters)
        self.width = width or (1 if runtime.fine_grained() else LANES)
        self.critical_cfl = least(scheme.lengths) * critical_cfl(scheme.viscosity, scheme.disorder_damping)
        self.scheme_name = f"sph ({scheme.kernel} kernel, smoothing {scheme.smoothing:g}, {dim}-D)"
        self.usual_cfl = usual_cfl(self.critical_cfl)
        self.cfl = given.cfl or self.usual_cfl
        self.breaking_cfl = given.cfl or min(BREAKING_CFL, self.cfl)
        frame = self.frame = given.frame()
        period = frame.period(given.walls)
        self.radius = KERNELS[scheme.kernel].reach * scheme.smoothing
        self.particles = SortedParticles(population, laws, frame, given.gravity, Sorting(drift_limit=1.0), period,
                                         self.adapters.of_particles)
        self.reach = self.radius * largest(scheme.lengths, dim)
        self.boundary = Boundary(frame, self.reach, ground=given.ground, sides=given.walls, obstacles=given.obstacles,
                                 period=period, first_row=self.particles.capacity)
        self.surfaces = self.boundary.surfaces
        self._begin(population, given.gravity)
        self._bind()
        self._graded = False
        self.adapters.begin(self)

    @classmethod
    def of(cls, population, laws, options, **setting):
        """Solver with `options`, the scene's table solver.sph."""
        return cls(population, laws, scheme=options, **setting)

    def _bind(self):
        """Compile what the scheme asks for, on rows that have room for all particles and dummies."""
        scheme, store, dummies = self.scheme, self.particles, self.boundary.dummies
        real = runtime.DTYPES[self.precision][0]
        layout = RowLayout(self.dim, scheme.artificial_stress > 0.0, scheme.disorder_damping > 0.0,
                           scheme.momentum == "corrected")
        self.rows = Rows(layout, self.precision, store.capacity + dummies.count)
        self._speeds = real_array([law.wave_speed() for law in self.materials.laws])
        serial = self.serial = runs_serially(PARTICLE_TIME[self.dim] * store.count)
        packs = self.width, Support(scheme.kernel, self.radius, scheme.lengths)
        tension = scheme.artificial_stress, scheme.artificial_stress_form
        of_particles = store.layout, layout, real, self.materials.functions
        self._update = update_kernel(*of_particles, *packs,
                                     Terms(scheme.momentum, scheme.gradient, tension, scheme.volumes), serial)
        self._row_cache = RowCache(self.rows, store, row_kernels(
            *of_particles, packs[1], scheme.momentum, tension, scheme.volumes), self._speeds, self.dx)
        self._order = order_kernel(store.layout)
        self._near = Neighbourhood(self.boundary, self.rows, self.precision, self.width, self.reach)
        self._forces = Forces(self.rows, self._near, self.boundary, scheme,
                              momentum_kernel(layout, real, *packs, terms_of(scheme, layout), serial),
                              gravity=self._gravity, dx=self.dx)
        self._extrapolation = Extrapolation(self.rows, self._near, self.boundary, self._gravity, self.dx, [
            extrapolation_kernel(layout, real, *packs, scheme.momentum, scheme.walls, moved, serial)
            for moved in (False, True)])
        self._operators = Operators(self.rows, self._near, dummies.first_row, self.precision, *packs)
        self._regularisation = Regularisation(scheme, store.layout, layout.pairs, self.precision)
        self._reports: Any = None

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        with runtime.precision(self.precision):
            if self._near.stale:
                self.sort()
            pushed = self._act(dt)
            if not self._row_cache.current:
                self._row_cache.write_rows()
            if self.boundary.dummies.moving:
                self.boundary.dummies.carry(self.rows, self._place)
            self._extrapolation.extrapolate_all()
            self._row_cache.correct(self._near.packs, self._near.lists)
            self.kick(pushed)
            self._extrapolation.extrapolate_velocities()
            self.regularise(dt)
            self.update(dt)
        self._near.age(dt / self.dx * max(2.0 * self._near.deviation, self.extremes.speed + self._pushing_speed))
        self._advance_clock(dt, pushed)

    @property
    def _place(self):
        """Time [s] at which obstacles are placed; -1, before all motion, while an initial state settles."""
        return self.time if self.damping_factor == 1.0 else -1.0

    def kick(self, dt):
        """First half of a step: change the velocities by the forces that act for dt [s]."""
        totals = self._forces.kick(dt, self.damping_factor, self._loads, self._n_loads)
        if totals is not None:
            self._loaded += self.boundary.add(totals, self._place)

    def regularise(self, dt):
        """Smooth the elastic strains of the particles in a step of dt [s], if the scheme asks for it in this step."""
        if self._regularisation.due(self.steps + 1):
            self._regularisation.smooth(self.particles, self._operators.write,
                                        self.materials.wave_speed * dt / self.dx)

    def operate(self, kind, values, parity=None):
        """Apply one of the `sph.operators` to `values` (n,) or (n, k) of the particles; see `Operators.of`."""
        with runtime.precision(self.precision):
            return self._operators.of(kind, values, parity)

    def update(self, dt):
        """Second half of a step of dt [s]: velocity gradients, stresses and positions from the present velocities.

        It changes the particles and their rows, not the velocities, and reads the report of the step.
        Raises SimulationError if a particle is no longer finite.
        """
        packs, store, report = self._near.packs, self.particles, np.zeros(step_report.N_REPORT)
        for act in self.adapters.before_gather:
            act(dt)
        self._update(self._near.of_particles, store.arrays, self.rows.tables,
                     Report(self._near.mean_velocity, self._reports, report), Step(self._speeds, dt, self.dx), packs.n,
                     packs.chunk_bounds)
        for act in self.adapters.after_gather:
            act(dt)
        self._read(report)

    @property
    def contact_work(self):
        """Energy that terrain, sides and obstacles took [J]."""
        return -float(sum(surface.total[-1] for surface in self.surfaces))

    @property
    def obstacle_totals(self):
        """Impulse [N s], its moment about the centre of rotation [N s m] (1 number in 2-D, 3 in 3-D) and work [J] that
        the snow gave each obstacle, (n, dim + 1 or 3 + 1)."""
        return self.boundary.obstacle_totals

    @property
    def _pushing_speed(self):
        """Speed of the fastest obstacle [m/s], 0 without one."""
        return max((obstacle.speed_at(self.time) for obstacle in self._obstacles), default=0.0)

    @property
    def _obstacles(self):
        return [surface.obstacle for surface in self.surfaces if surface.obstacle is not None]

    def _read(self, report):
        super()._read(report)
        self._near.deviation = report[step_report.EXCURSION] ** 0.5

    def sort(self):
        """Bring every particle to its block and find its neighbours anew; those outside the domain are removed
        and counted."""
        store = self.particles
        with runtime.precision(self.precision):
            store.sort(math.inf)
            self._order(store.reals, store.slot_offset, store.start, store.target, store.chunk_bounds)
            store.move(store.count)
            self._rebuild_lists()
            if not self._graded:
                self._grade()

    def _grade(self):
        """Give the particles the gradient of their initial velocities, which the damping of disorder leaves alone."""
        self._graded, store = True, self.particles
        table, columns = store.table(), store.layout.columns
        velocity = table[:, columns("velocity")]
        if len(velocity) and np.ptp(velocity, axis=0).any():
            table[:, columns("affine")] = self.operate("corrected_gradient", velocity).reshape(len(table), -1) / self.dx
            store.overwrite(table)
            self._row_cache.write_rows()

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        self.particles.remove(gone)
        self._near.forget()

    def _rebuild_lists(self):
        """Build the rows and lists of neighbours of particles that lie in the order of their blocks."""
        self._row_cache.write_rows()
        with runtime.precision(self.precision):
            self._near.begin(self.rows, self.particles.blocks, self._row_cache.current_rows, self._place)
        self._sum_up()

    _n_loads = 0

    def _sum_up(self):
        """Make room for the sums and reports of each pack."""
        packs = self._near.packs
        self._forces.begin(self.particles.blocks, bool(self._n_loads))
        if self._reports is None or self._reports.shape[0] < packs.n:
            self._reports = ti.ndarray(ti.f64, (int(1.25 * packs.n) + 8, step_report.N_REPORT))

    def set_loads(self, loads):
        """loads: [(centre (dim,) [m, scene], radius [m], acceleration (dim,) [m/s2])] that act on particles."""
        before = bool(self._n_loads)
        super().set_loads(loads)
        if bool(self._n_loads) != before and self._near.known:
            self._sum_up()  # packs that loads push want a tally; the lists stay, as in a run that is resumed

    # ---- reading ----------------------------------------------------------------------------------------------

    def restart_clock(self):
        """Time zero is now: totals start again."""
        super().restart_clock()
        self.boundary.clear()

    @property
    def workload(self):
        """`Workload` of a step."""
        return Workload(len(self.particles.blocks), surfaces=len(self.surfaces), components=self.adapters.work())

    @property
    def memory(self):
        """Bytes of everything but the particles."""
        return self.rows.bytes + self._near.bytes + self.boundary.dummies.bytes + self.adapters.bytes

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name: particles, blocks, clock, totals, lists."""
        return {**super().state(), **self.boundary.state(),
                "neighbours": self._near.state(self._row_cache.current_rows)}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """
        super().restore(state)
        self.boundary.restore(state)
        self._near.forget()
        self._graded = True
        if state["neighbours"]:
            with runtime.precision(self.precision):
                self._near.restore(state["neighbours"], self.rows, self.particles.blocks)
            self._sum_up()
            self._row_cache.restored()
