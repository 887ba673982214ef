"""SPH of seepage: water that moves between grains at rest, leaves them and pools; two layers of particles.

    m (w' - w) / dt = m g - G^T l - C V / n w',   x' = x + dt w'

of each particle of water, with the forces G^T l of a pressure that is solved for (`projection`), so that water finds
room (`fullness`), and the drag coefficient C at the speed before, times the speed after: drag sets no step. Grains stay
where they are, and what pushes them is booked as what holds them (Bui & Nguyen 2021, doi:10.1016/j.compgeo.2021.104315,
section 4.6, with grains at rest; Bui & Nguyen 2017, doi:10.1016/j.ijsolstr.2017.06.030).

What is too much, as where a drop fell, spreads with the rate `SPREADING` sqrt(g / s), so that it does not burst.

Two more things keep particles in order: differences of speed between neighbours fade with the rate `FADING` sqrt(g /
s), and particles nearer than `NEAREST` s part with up to `PARTING` g, s being the spacing of the water there. Pairs
have no pressure between them, and would else lie in one place.
"""

from dataclasses import replace

import numpy as np

from snowmpm.components.seepage.fullness import REACH, Fullness, Grains, Walls
from snowmpm.components.seepage.projection import Unsolved, pressed
from snowmpm.components.seepage.waters import OWN, SeepingWaters
from snowmpm.errors import SimulationError
from snowmpm.particles.sorted_particles import SortedParticles, Sorting
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.contract import Receives, StepLimits
from snowmpm.stepping.method import Solver
from snowmpm.stepping.setting import Setting

USUAL_CFL, CRITICAL_CFL = 0.3, 0.84
"""Of s over the fall speed: the usual one, and the border of the atlas (`long_seepage_step`)."""

FADING = 0.1
SPREADING = 0.3
NEAREST, PARTING = 0.8, 1.0

MIRRORS = ("slip", "symmetric")
"""Sides of the domain that hold water."""


class SeepageSolver(Solver, Receives):
    """Particles of water and of grains, and steps of the water."""

    surfaces = ()
    contact_work = 0.0
    _pushing_speed = 0.0

    def __init__(self, population, laws, **setting):
        """setting: fields of `Setting`, among its adapters `waters.SeepingWaters` of the population."""
        given = Setting(**setting)
        self.dim, self.dx, self.precision = given.dim, given.dx, given.precision
        self.frame = given.frame()
        self.scheme_name = f"seepage ({self.dim}-D)"
        self.critical_cfl, self.usual_cfl = CRITICAL_CFL, USUAL_CFL
        self.cfl = given.cfl or USUAL_CFL
        self.adapters = Adapters(given.adapters)
        self.particles = SortedParticles(population, laws, self.frame, given.gravity, Sorting(drift_limit=1.0),
                                         carried=self.adapters.of_particles)
        self._begin(population, given.gravity)
        bounds = np.array([given.lower, given.upper], float)
        self.walls = Walls([(axis, bounds[end, axis]) for axis, ends in enumerate(given.walls)
                            for end, name in enumerate(ends) if name in MIRRORS])
        self.phases = phases = next(one for one in self.adapters if isinstance(one, SeepingWaters))
        self.contact_work, self.passes = 0.0, 0
        self._grains = None
        self.spacing = self.dx * float(min(phases.porosity)) ** (1.0 / self.dim)
        """of free water [m]"""
        self.adapters.begin(self)

    @classmethod
    def of(cls, population, laws, options, **setting):
        """Solver of a scene (`snowmpm.methods.MethodEntry`); options, those of SPH, have no effect on it."""
        return cls(population, laws, **setting)

    # ---- the step -------------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]. Raises SimulationError when the pressure is not found."""
        pushed = self._act(dt)
        store = self.particles
        wet = store.labels()[:, 0] == self.phases.material
        held = float(store.masses()[~wet].sum())
        self._loaded -= dt * held * self.gravity
        if wet.any():
            self._move(dt, wet)
        self._advance_clock(dt, pushed)

    def receive(self, population, numbers):
        """Take in a `Population` with numbers (n,) that no particle has yet."""
        self.particles.add(population, numbers)

    def _move(self, dt, wet):
        store, phases, g = self.particles, self.phases, self.gravity
        x_all, w_all, water = store.positions(), store.column("velocity"), store.column("water")
        ratios = store.column("volume_ratio")[:, 0]
        x, w, volume = x_all[wet], w_all[wet], store.column("volume")[wet, 0]
        if not (np.isfinite(x).all() and np.isfinite(w).all()):
            self._fail(int(np.flatnonzero(wet)[~np.isfinite(x + w).all(axis=1)][0]))
        room = self._room(x_all, wet)
        full = Fullness(x, volume, room, self.walls, REACH * self.dx)
        mass, share = phases.density * volume, full.share
        speed = np.linalg.norm(w, axis=1)
        drag = dt * phases.mobile(full.medium, full.solid, speed) / (share * phases.density)
        held = 1.0 / (1.0 + drag)
        parting = dt * self._parting(full)
        self._loaded += mass @ parting
        ahead = held[:, None] * (w + dt * g + parting)
        own = water[wet, OWN]
        squeezed = own / phases.bulk_modulus
        over = full.f - 1.0 - squeezed
        over = np.where(over > 0.0, min(1.0, SPREADING * dt * self._rate) * over, over)
        excess = squeezed + over + dt * sum(G @ ahead[:, a] for a, G in enumerate(full.gradients))
        weight = volume / share
        try:
            load, self.passes = pressed(full.gradients, dt * dt * held / mass, 1.0 / (phases.bulk_modulus * weight),
                                        excess, own * weight)
        except Unsolved as error:
            raise SimulationError(f"the pressure of the water is not found in {error} passes, at t = {self.time:.6g} s,"
                                  f" step {self.steps}:\nlower solver.cfl or water.bulk_modulus") from None
        force = -np.stack([G.T @ load for G in full.gradients], axis=1)
        after = ahead + (dt * held / mass)[:, None] * force
        self._loaded += dt * force.sum(axis=0) - (mass * drag) @ after
        self.contact_work += float((mass * drag) @ (after * (w + after)).sum(axis=1)) / 2.0
        after = self._smoothed(dt, full, after, volume, mass)
        place = x + dt * after
        lower, upper = self.frame.origin + self.dx * self.frame.lower, self.frame.origin + self.dx * self.frame.upper
        before = mass @ after
        self.walls.held(place, after, lower, upper)
        self._loaded += mass @ after - before
        x_all[wet], w_all[wet], rows = place, after, water[wet]
        ratios[wet] = phases.noted(rows, (full.mean(weight, load / weight), load / weight), share, full.f)
        water[wet] = rows
        self.extremes = replace(self.extremes, speed=float(np.linalg.norm(after, axis=1).max()))
        heavy = store.mass
        store.place((x_all - self.frame.origin) / self.dx, {"velocity": w_all, "water": water, "volume_ratio": ratios})
        self.weight_impulse += dt * (heavy - store.mass) * g  # of those that have just left

    @property
    def _rate(self):
        """sqrt(g / s) [1/s]."""
        return float(np.sqrt(np.linalg.norm(self.gravity) / self.spacing))

    def _parting(self, full):
        """Acceleration (n, dim) [m/s2] that parts those that are too near."""
        spacing = self.dx * full.share ** (1.0 / self.dim)
        wanted = 0.5 * NEAREST * (spacing[full.i] + spacing[full.owner])
        lack = np.maximum(1.0 - full.length / wanted, 0.0) / np.maximum(full.length, 1e-12 * self.dx)
        return PARTING * float(np.linalg.norm(self.gravity)) * full.apart(lack[:, None] * full.way)

    def _smoothed(self, dt, full, after, volume, mass):
        """Speeds after a step, with a part of their differences gone."""
        fading = min(FADING * dt * self._rate, 0.5)
        unlike = full.sign * after[full.owner] - after[full.i]
        smooth = after + fading * full.apart((volume[full.owner] * full.value)[:, None] * unlike)
        self._loaded += mass @ (smooth - after)
        return smooth

    def _room(self, x, wet):
        """`Grains` of those that there are."""
        if self._grains is None:
            store, dry = self.particles, ~wet
            porosity = self.phases.porosity[store.labels()[dry, 0]]
            self._grains = Grains(x[dry], store.column("volume")[dry, 0], porosity, self.walls, REACH * self.dx)
        return self._grains

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        self.particles.remove(gone)
        self._grains = None

    # ---- how long a step may be -----------------------------------------------------------------------------------

    @property
    def limits(self):
        """`StepLimits`."""
        return StepLimits(self.cfl, self.critical_cfl, self.scheme_name, self.usual_cfl)

    def _step_at(self, elastic, advective):
        fall = np.sqrt(float(np.linalg.norm(self.gravity)) * self.spacing)
        return elastic * self.spacing / max(fall + self.extremes.speed, 1e-30), "speed of the water"

    def stable_dt(self):
        """-> (step for now [s], what limits it)."""
        return self._step_at(self.cfl, self.cfl)

    @property
    def memory(self):
        """Bytes of everything but the particles: of pairs with about 40 neighbours in the plane, 160 in space."""
        return self.particles.count * {2: 40, 3: 160}[self.dim] * 120

    # ---- checkpoint -----------------------------------------------------------------------------------------------

    def restart_clock(self):
        """Time zero is now: totals start again."""
        super().restart_clock()
        self.contact_work = 0.0

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {**super().state(), "contact_work": self.contact_work}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene.

        Raises InputError when it does not fit.
        """
        self.particles.make_room(len(state["reals"]))
        super().restore(state)
        self.contact_work, self._grains = state["contact_work"], None
