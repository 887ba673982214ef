"""Explicit finite-strain SPH: updated Lagrangian, staggered leapfrog.

    v^{n+1/2} = v^{n-1/2} + dt a(x^n, tau^n)        momentum.py
    f = I + dt L(v^{n+1/2}, x^n),  tau^{n+1} = law  update.py
    x^{n+1} = x^n + dt v^{n+1/2}

(Favero Neto & Borja 2018, doi:10.1007/s11440-017-0628-9; choices beyond theirs from Bui & Nguyen 2021,
doi:10.1016/j.compgeo.2021.104315, and Peng et al. 2015, doi:10.1007/s11440-015-0398-1.) Stress and velocity are never
advanced from the same level, which is forward Euler and blows up.
"""

import math

import numpy as np
import taichi as ti

from snowmpm import report as report_of
from snowmpm import runtime
from snowmpm.arrays import int_array, real_array
from snowmpm.blocks import EDGE
from snowmpm.frame import Frame
from snowmpm.materials.packs import LANES
from snowmpm.parallel import alone
from snowmpm.solver import Solver
from snowmpm.sorted_particles import SortedParticles
from snowmpm.sph.boundary import Boundary
from snowmpm.sph.extrapolation import extrapolation_kernel
from snowmpm.sph.momentum import momentum_kernel
from snowmpm.sph.neighbourhood import Neighbourhood
from snowmpm.sph.operators import operator_kernel, results
from snowmpm.sph.order import order_kernel
from snowmpm.sph.regularisation import Regularisation
from snowmpm.sph.rows import RowLayout, Rows
from snowmpm.sph.showing import showing_kernels
from snowmpm.sph.surface_forces import tally_width
from snowmpm.sph.update import update_kernel

USUAL_CFL, USUAL_SHARE = 0.3, 0.8
"""C of a scene that gives none: dt = 0.2 h / c at h = 1.5 dx, that of Favero Neto & Borja, or this share of the
critical one where that is less."""

PARTICLE_TIME = {2: 2.5e-7, 3: 1.5e-6}
"""Of a step on one thread [s], about, by dimension."""


def critical_cfl(viscosity, disorder_damping):
    """Largest stable C = c dt / dx: 0.9 of waves, less where explicit damping becomes too strong, 0.9 / (0.64 alpha +
    1.22 gamma). Measured on free elastic blocks of disordered particles, in steps of 0.2: at alpha, gamma = 0.1, 0.5
    stable to 1.1 in 2-D, at 1.0, 0.5 to 0.7, at 0.1, 2.0 to 0.3; in 3-D to 0.9, 0.9, 0.5."""
    return min(0.9, 0.9 / max(0.64 * viscosity + 1.22 * disorder_damping, 1e-9))


class SphSolver(Solver):
    """Particles, their neighbours, and one step of both.

    particles: `SortedParticles`, a particle a cell of dx.
    """

    method = "sph"
    BAD = "is no longer finite or turned inside out"
    DAMPED_IMPULSE = False

    def __init__(self, population, laws, *, dx, precision, origin, lower, upper, gravity, scheme, cfl=None,
                 terrain=None, terrain_contact="stick", terrain_friction=0.0, sides=None, obstacles=(), width=None):
        """population: `Population`; laws: one per material index; lower, upper, origin: scene coordinates [m].

        scheme: what `snowmpm.scenes.Sph` has. terrain: object with `query(points) -> distance, normal` in scene
        coordinates, or None. sides: (dim, 2) names of `contact.CODES` or "periodic". obstacles: `solids.Obstacle`s.
        cfl: share of dx that a wave or a particle may cross in a step. width: lanes of a pack, as the backend asks.
        """
        self.dim = dim = len(origin)
        self.dx, self.precision, self.scheme = dx, precision, scheme
        self.width = width or (1 if runtime.fine_grained() else LANES)
        self.critical_cfl = critical_cfl(scheme.viscosity, scheme.disorder_damping)
        self.scheme_name = f"sph ({scheme.kernel} kernel, smoothing {scheme.smoothing:g}, {dim}-D)"
        self.cfl = cfl or min(USUAL_CFL, USUAL_SHARE * self.critical_cfl)
        frame = self.frame = Frame(dim, precision, origin, dx, lower, upper)
        sides = sides or [["open", "open"]] * dim
        period = frame.period(sides)
        self.radius = 2.0 * scheme.smoothing
        self.particles = SortedParticles(
            population, laws, dx=dx, precision=precision, origin=frame.origin, limits=frame.limits(period),
            gravity=gravity, home_limit=1.0, second_moment=0.0, period=period)
        self.boundary = Boundary(frame, self.radius, terrain=terrain, terrain_contact=terrain_contact,
                                 terrain_friction=terrain_friction, sides=sides, obstacles=obstacles, period=period,
                                 first_row=self.particles.capacity)
        self.surfaces = self.boundary.surfaces
        self._begin(population, gravity)
        self._bind()
        self._graded = False

    def _bind(self):
        scheme, store = self.scheme, self.particles
        real = runtime.DTYPES[self.precision][0]
        layout = RowLayout(self.dim, scheme.artificial_stress > 0.0, scheme.disorder_damping > 0.0,
                           scheme.momentum == "corrected")
        self.rows = Rows(layout, self.precision, store.capacity + self.boundary.dummies.count)
        self._speeds = real_array([law.wave_speed() for law in self.materials.laws])
        serial = alone(PARTICLE_TIME[self.dim] * store.count)
        common = (self.width, scheme.kernel, self.radius, scheme.momentum)
        self._kick = momentum_kernel(
            layout, real, self.width, scheme.kernel, self.radius, scheme.momentum,
            round(2.0 * scheme.artificial_stress_power) if layout.tension else 2, scheme.walls, scheme.barrier,
            scheme.confining_pressure > 0.0, scheme.quadratic_viscosity > 0.0, serial)
        of_particles = store.layout, layout, real, self.materials.functions, self.materials.n_parameters
        self._update = update_kernel(*of_particles, *common, scheme.gradient, scheme.artificial_stress, serial)
        self._show, self._correct = showing_kernels(*of_particles, *common[1:], scheme.artificial_stress)
        self._order = order_kernel(store.layout)
        self._near = Neighbourhood(self.boundary, self.precision, self.width, self.radius)
        if self.boundary.dummies.count:
            self._follow, self._follow_velocity = (
                extrapolation_kernel(layout, real, *common, scheme.walls, moved, serial) for moved in (False, True))
        self._regularisation = Regularisation(scheme, store.layout, layout.pairs, self.precision)
        self._reports = None

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        with runtime.precision(self.precision):
            if self._near.stale:
                self.sort()
            elif self._seen != self.particles.changes:
                self._show_rows()
            if self.boundary.dummies.moving:
                self.boundary.dummies.carry(self.rows, self._place)
            self.lead_dummies(self._follow if self._has_dummies else None, self.rows.source)
            if self._bare and self.rows.layout.full:
                packs = self._near.packs
                self._correct(packs.table, self.rows.source, *self._near.lists.arguments, packs.n)
            self._bare = False
            self.kick(dt)
            self.lead_dummies(self._follow_velocity if self._has_dummies else None, self.rows.moved)
            self.regularise(dt)
            self.update(dt)
        self._near.age(dt / self.dx * max(2.0 * self._near.deviation, self.extremes.speed + self._pushing_speed))
        self._advance_clock(dt)

    @property
    def _place(self):
        """Time [s] that obstacles are where they are at: while an initial state settles, nothing is set in motion."""
        return self.time if self.keep == 1.0 else -1.0

    def lead_dummies(self, follow, rows):
        """Let the dummies follow the particles near them."""
        if self._has_dummies and self._near.dummy_packs.n:
            packs, dummies = self._near.dummy_packs, self.boundary.dummies
            follow(packs.table, rows, self.rows.source, *self._near.dummy_lists.arguments, dummies.frames,
                   dummies.surface_of, dummies.first_row, self.boundary.table, self._gravity, self.dx, packs.n,
                   packs.shares)

    def kick(self, dt):
        """Forces, and the velocities that they lead to."""
        lists, packs, scheme, dummies = self._near.lists, self._near.packs, self.scheme, self.boundary.dummies
        totals = np.zeros((len(self.surfaces) + 1, tally_width(self.dim)))
        covered = scheme.surface_coverage if scheme.surface_coverage < 1.0 else math.inf
        self._kick(packs.table, self.rows.source, self.rows.moved, *lists.arguments, lists.ints, dummies.frames,
                   dummies.first_row, self.boundary.table, self._corners, self._loads, self._n_loads, self._tallies,
                   self._tally_of, self._gravity, self.dx, dt, self.keep, scheme.viscosity, scheme.quadratic_viscosity,
                   scheme.disorder_damping, scheme.confining_pressure, covered, self._n_tallies, totals, packs.n,
                   packs.shares)
        if self._n_tallies:
            self._loaded += self.boundary.add(totals, self._place)

    def regularise(self, dt):
        """Smooth the elastic strains of the particles, where the scheme asks for it."""
        if self._regularisation.due(self.steps + 1):
            self._regularisation.smooth(self.particles, self._operate, self.materials.wave_speed * dt / self.dx)

    def operate(self, kind, values, parity=None):
        """One of the operators of `sph.operators` on `values` (n,) or (n, k) of the particles, in their order; ->
        (n, k, dim) of gradients [1/cell], (n, k) of all others (Laplacians: [1/cell2]).

        Raises ValueError before the particles have been sorted.
        """
        values = np.asarray(values)
        values = values.reshape(len(values), -1)
        real, numpy_real = runtime.DTYPES[self.precision]
        n, k = values.shape
        with runtime.precision(self.precision):
            if not self._near.known:
                raise ValueError("the particles must be sorted first")
            fields = ti.ndarray(ti.types.vector(k, real), (max(1, n),))
            fields.from_numpy(np.ascontiguousarray(values, numpy_real))
            out = np.zeros((max(1, n), k * results(kind, self.dim)), numpy_real)
            self._operate(kind, fields, out, parity or ((),) * k)
        return out[:n].reshape(n, k, self.dim) if results(kind, self.dim) > 1 else out[:n]

    def _operate(self, kind, fields, out, parity):
        packs = self._near.packs
        operator_kernel(self.rows.layout, runtime.DTYPES[self.precision][0], self.width, self.scheme.kernel,
                        self.radius, kind, tuple(parity))(
            packs.table, self.rows.moved, fields, out, *self._near.lists.arguments, self.boundary.dummies.first_row,
            packs.n, packs.shares)

    def update(self, dt):
        """Velocity gradients, stresses, places."""
        packs, store, report = self._near.packs, self.particles, np.zeros(report_of.N_REPORT)
        self._update(packs.table, store.reals, store.turn, store.material, self.materials.numbers,
                     self.materials.law_of, self._speeds, self.rows.source, self.rows.moved,
                     *self._near.lists.arguments, self._near.mean_velocity, dt, self.dx, self._reports, report, packs.n,
                     packs.shares)
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
        """Of the fastest obstacle [m/s]."""
        return max((obstacle.speed_at(self.time) for obstacle in self._obstacles), default=0.0)

    @property
    def _obstacles(self):
        return [surface.obstacle for surface in self.surfaces if surface.obstacle is not None]

    @property
    def _has_dummies(self):
        return self.boundary.dummies.count > 0

    def _read(self, report):
        super()._read(report)
        self._near.deviation = report[report_of.EXCURSION] ** 0.5

    def sort(self):
        """Bring every particle home to its block and find its neighbours anew; those outside the domain are removed
        and counted."""
        store = self.particles
        with runtime.precision(self.precision):
            store.sort(math.inf)
            self._order(store.reals, store.turn, store.start, store.target, store.shares)
            store.move(store.count)
            self._follow_blocks()
            if not self._graded:
                self._grade()

    def _grade(self):
        """The velocity gradient that the particles start with, which the damping of disorder takes for order."""
        self._graded, store = True, self.particles
        table, columns = store.table(), store.layout.columns
        velocity = table[:, columns("velocity")]
        if len(velocity) and np.ptp(velocity, axis=0).any():
            table[:, columns("affine")] = self.operate("corrected_gradient", velocity).reshape(len(table), -1) / self.dx
            store.overwrite(table)
            self._show_rows()

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        self.particles.remove(gone)
        self._near.forget()

    def _follow_blocks(self):
        """Lists for particles that lie in the order of their blocks."""
        self._show_rows()
        with runtime.precision(self.precision):
            self._near.begin(self.rows, self.particles.blocks, self._shown, self._place)
        self._make_tallies()

    def _show_rows(self):
        """Rows of the particles, from the store."""
        store = self.particles
        self._show(store.reals, store.turn, store.material, self.materials.numbers, self.materials.law_of, self._speeds,
                   self.rows.source, self.rows.moved, self.dx, store.count)
        self._seen, self._bare = store.changes, True

    @property
    def _shown(self):
        """Rows of the particles as they are."""
        return self.rows.source.to_numpy()[: self.particles.count].copy()  # of all rows most may be dummies

    def _make_tallies(self):
        """Sums of what surfaces give, one for each pack that may meet one."""
        blocks, packs = self.particles.blocks, self._near.packs
        self._corners = int_array(EDGE[self.dim] * blocks.coordinates)
        met = np.ones(packs.n, bool) if self._n_loads else self._near.lists.meets_surfaces(packs)
        self._tally_of = int_array(np.where(met, np.cumsum(met) - 1, -1))
        self._n_tallies = int(met.sum())
        shape = max(1, self._n_tallies), len(self.surfaces) + 1, tally_width(self.dim)
        self._tallies = ti.ndarray(ti.f64, shape)
        if self._reports is None or self._reports.shape[0] < packs.n:
            self._reports = ti.ndarray(ti.f64, (int(1.25 * packs.n) + 8, report_of.N_REPORT))

    def set_loads(self, loads):
        """loads: [(centre (dim,) [m, scene], radius [m], acceleration (dim,) [m/s2])] that act on particles."""
        before = bool(getattr(self, "_n_loads", 0))
        super().set_loads(loads)
        if bool(self._n_loads) != before:
            self._near.forget()  # packs that loads push want a tally

    # ---- reading ----------------------------------------------------------------------------------------------

    def begin_settling(self):
        """Before the damped steps of `settling`."""

    def end_settling(self):
        """After them."""
        self.keep = 1.0

    def null_space_noise(self, energy):
        """There is no grid that could miss some of the motion."""
        return 0.0

    def second_moment(self):
        """No affine part of the motion carries energy [m2]."""
        return 0.0

    def restart_clock(self):
        """Time zero is now: totals start again."""
        super().restart_clock()
        self.boundary.clear()

    @property
    def bytes(self):
        """Memory of everything but the particles."""
        return self.rows.bytes + self._near.bytes + self.boundary.dummies.bytes

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name: particles, blocks, clock, totals, lists."""
        return {**super().state(), **self.boundary.state(), "neighbours": self._near.state(self._shown)}

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
            self._make_tallies()
            self._seen, self._bare = self.particles.changes, False
