"""What acts on the particles of a solver beside contact and stress, over each step, and the work that it does.

    before the step   v <- k v + s a(x, v, t + dt / 2),  C <- k C,  tau <- tau + J p I     (`damping`, `fields`)
    in the step       gravity is its mean over the step; forces act for the time s
    after the step    tau is again that of the law

Without damping k = 1, s = dt. Nothing of it is in the kernels of a step, and a scene without it pays nothing.
"""

import math

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.components.forcing_and_damping.damping import decay
from snowmpm.components.forcing_and_damping.fields import Pressure
from snowmpm.components.forcing_and_damping.particle_kernels import particle_kernels
from snowmpm.stepping.component import Adapter


class Forcing(Adapter):
    """course: `Course` of gravity that changes, or None; fields: `Field`s; damping: `Damping` or None.

    gravity_work: energy [J] that changing gravity gave since the start.
    """

    name = "forcing_and_damping"

    def __init__(self, course=None, fields=(), damping=None):
        self.course, self.fields, self.damping = course, list(fields), damping
        self.gravity_work, self._force_work, self._damping_work = 0.0, 0.0, 0.0

    def begin(self, solver):
        """Take the solver's particles, and its gravity if that changes."""
        self._solver = solver
        if self.course:
            solver.set_gravity(self.course.at(0.0))
            solver.particles.weightless()

    def restart(self):
        """Time zero is now: totals start again."""
        self.gravity_work, self._force_work, self._damping_work = 0.0, 0.0, 0.0

    def force_work(self):
        """By the fields [J]."""
        return self._force_work

    def damping_work(self):
        """Taken by damping [J]."""
        return self._damping_work

    def potential_energy(self):
        """Minus the work of gravity that changes [J]."""
        return -self.gravity_work if self.course else None

    def to_come(self, time):
        """Whether gravity, a force or damping will change after `time` [s], so that snow at rest may move again."""
        acting = [*([self.course] if self.course else []), *self.fields, *([self.damping] if self.damping else [])]
        return any(item.until > time for item in acting)

    # ---- the step -------------------------------------------------------------------------------------------------

    def before_step(self, dt, pushed):
        """Gravity, fields, damping of a step of dt [s]; -> the time for which forces act [s]."""
        solver = self._solver
        settling = solver.damping_factor < 1.0
        time, span = (0.0, 0.0) if settling else (solver.time, dt)
        self._confined, self._c = None, 0.0
        if self.course:
            solver.set_gravity(self.course.mean(time, time + span))
        if self.damping and not settling:
            self._c = self.damping.coefficient(time, dt, solver.extremes.speed)
        damping_factor, pushed = decay(self._c, dt)
        if self._c > 0.0:
            self._slow(solver, damping_factor)
        # While an initial state settles, what acts is what acts at time zero
        shares = [(field, float(field.share(0.0, 1e-9) > 0.0) if settling else field.share(time, dt))
                  for field in self.fields]
        acting = [(field, share) for field, share in shares if share > 0.0]
        if acting:
            self._push(solver, acting, time + 0.5 * span, damping_factor, pushed)
        return pushed

    def around(self):
        """Pressure around the particles [Pa], 0 far from them, in the rows of this step (n,), and what books its work,
        or None: for a solver that puts it among its equations."""
        if self._confined is None:
            return None
        pressure, self._confined = self._confined[2], None
        return pressure, self._book

    def _book(self, work):
        self._force_work += work

    def after_step(self, dt):
        """The work of gravity, damping and pressures."""
        solver = self._solver
        if self._confined is not None:
            force, ratio, _ = self._confined
            self._force_work -= float(force @ (self._read(solver)[:, -1] - ratio))
        if self.course or self._c > 0.0:
            momentum, square = self._sums(solver)
            self.gravity_work += dt * float(momentum @ solver.gravity)
            if self._c > 0.0:
                self._damping_work += 0.5 * math.tanh(self._c * dt) * (self._square + square)

    def _slow(self, solver, damping_factor):
        """Keep the share `damping_factor` of all motion."""
        store = solver.particles
        momentum, self._square = self._sums(solver)
        solver.add_impulse((damping_factor - 1.0) * momentum)
        self._kernels(solver).slow(store.reals, store.slot_offset, damping_factor, store.count)
        store.changes += 1

    def _push(self, solver, acting, time, damping_factor, pushed):
        """Fields with their shares, at `time` [s], for the time `pushed` [s]; damping_factor: what damping left
        of velocities."""
        store, dim = solver.particles, solver.dim
        rows = self._read(solver)
        x, v = store.positions(rows[:, :dim]), rows[:, dim : 2 * dim] / damping_factor
        volume, ratio = rows[:, -2:].T
        density = store.densities()
        number = store.identity.to_numpy()[: store.count]
        acceleration, pressure = np.zeros(x.shape), np.zeros(len(x))
        for field, share in acting:
            if not isinstance(field, Pressure):
                gained = share * field.acceleration(x, v, time)
                if field.numbers is not None:
                    gained[(number < field.numbers[0]) | (number >= field.numbers[1])] = 0.0
                acceleration += gained
                continue
            acceleration -= (share * ratio / density)[:, None] * field.gradient(x, time, solver.dx)
            if field.on_surface:
                pressure += share * field.pressure(x, time)
        gain, mass, kernels = pushed * acceleration, density * volume, self._kernels(solver)
        kernels.push(store.reals, store.slot_offset, gain, store.count)
        # While an initial state settles, the step that follows takes its share of this, too
        solver.add_impulse((mass @ gain) * (solver.damping_factor if solver.DAMPED_IMPULSE else 1.0))
        self._force_work += float(mass @ (gain * (v + 0.5 * gain)).sum(axis=1))
        fluid = np.array([law.IN_PORES for law in store.materials.laws])
        if fluid.any():  # a pressure on the surface bears on the skeleton
            pressure[fluid[store.material.to_numpy()[: store.count]]] = 0.0
        if pressure.any():
            kernels.confine(store.reals, store.slot_offset, ratio * pressure, store.count)
            self._confined = pressure * volume, ratio, pressure
        store.changes += 1

    def _read(self, solver):
        """Local positions [cells], velocities [m/s], reference volume [m3] and J of the particles, in their rows."""
        store = solver.particles
        rows = np.empty((store.count, 2 * solver.dim + 2))
        self._kernels(solver).read(store.reals, store.slot_offset, rows, store.count)
        return rows

    def _sums(self, solver):
        """Momentum (dim,) [kg m/s] and twice the kinetic energy [J] of the particles."""
        store = solver.particles
        of_block = np.empty((len(store.blocks), solver.dim + 1))
        self._kernels(solver).sums(store.reals, store.slot_offset, store.material, store.materials.numbers, store.start,
                                   solver.second_moment(), of_block, len(store.blocks))
        total = of_block.sum(axis=0)
        return total[:-1], float(total[-1])

    @staticmethod
    def _kernels(solver):
        return particle_kernels(solver.particles.layout, runtime.DTYPES[solver.precision][0])

    # ---- checkpoint -----------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"gravity_work": self.gravity_work, "force_work": self._force_work, "damping_work": self._damping_work,
                "damping": self.damping.state() if self.damping else {}}

    def restore(self, state):
        """Take over what `state()` gave."""
        self.gravity_work, self._force_work = state["gravity_work"], state["force_work"]
        self._damping_work = state["damping_work"]
        if self.damping:
            self.damping.restore(state["damping"])
