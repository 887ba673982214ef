"""Five cases of case I9, each by explicit and by implicit MPM: error against processor seconds, and against the step.

Each function takes a `Way` and returns a `Found`. Explicit steps are APIC's, in double precision as the implicit ones
are; a case that ends at rest is damped as its own verification case is.
"""

import time
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.stepping.settling import settle
from snowmpm.study.problems import elastic_saw_test
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, lattice
from snowmpm.study.problems.self_weight_column import SNOW, SOFT, G, exact_height
from tests.support.implicit_saw_test import at_rest
from tests.support.implicit_steps import implicit


@dataclass(frozen=True)
class Way:
    """cells: of the case's own length; step: implicit: cells that a wave crosses in a step, or for rest the steps of
    the whole load; explicit: of the usual step, or for rest what the case says; implicit: which of both."""

    implicit: bool
    cells: int
    step: float = 1.0


@dataclass(frozen=True)
class Found:
    """error [-]; seconds: of the processor, of the steps alone; steps; dt [s], their mean."""

    error: float
    seconds: float
    steps: int
    dt: float


class Clock:
    """Processor seconds and number of the steps of a solver."""

    def __init__(self):
        self.seconds, self.steps, self.end = 0.0, 0, 0.0

    def follow(self, solver):
        """Time the steps of a solver from now on; -> it."""
        step = solver.step

        def timed(dt):
            start = time.process_time()
            step(dt)
            self.seconds += time.process_time() - start
            self.steps, self.end = self.steps + 1, self.end + dt

        solver.step = timed
        return solver

    def found(self, error):
        return Found(float(error), self.seconds, self.steps, self.end / max(1, self.steps))


def _solver(way, x, volumes, law, dx, upper, sides, gravity, time="newmark", gradient="affine"):
    """Solver in the box from 0 to `upper`, and its `Clock`."""
    clock = Clock()
    if way.implicit:
        solver = implicit(x, volumes, law, dx, upper=upper, sides=sides, gravity=gravity, time=time,
                          solver={"gradient": gradient})
    else:
        solver = Scheme("apic", gradient=gradient).solver(
            Population(x, volumes, 0), [law], dx=dx, origin=np.zeros(2), lower=np.zeros(2), upper=np.asarray(upper),
            gravity=np.asarray(gravity), sides=sides)
    return clock.follow(solver), clock


def _swing(solver, way, law, end, exact, read):
    """Root mean square of the difference of read() from exact(t) over time to `end` [s], over the largest exact."""
    dt = way.step * solver.dx / law.wave_speed() if way.implicit else way.step * solver.stable_dt()[0]
    steps = int(np.ceil(end / dt))
    off = []
    every = max(1, steps // 400)
    for k in range(steps):
        solver.step(end / steps)
        if k % every == 0 or k == steps - 1:
            off.append(read() - exact(solver.time))
    size = max(abs(exact(t)) for t in np.linspace(0.0, end, 200))
    return np.sqrt(np.mean(np.square(off))) / size


def column(way):
    """A column 1 m high on which weight falls all at once, for two periods: its top, in time."""
    length, c = 1.0, SNOW.wave_speed()
    dx = length / way.cells
    x, volumes = lattice([0.0, 0.0], [4.0 * dx, length], dx)
    solver, clock = _solver(way, x, volumes, SNOW, dx, [4.0 * dx, 1.1],
                            [["slip", "slip"], ["stick", "open"]], [0.0, -G])
    states = ParticleStates(solver)
    top = states.reference[:, 1] > length - 0.5 * dx
    Y = states.reference[top, 1].mean()
    k = 0.5 * np.pi * (2.0 * np.arange(400) + 1.0) / length
    share = 2.0 / (length * k**3) * np.sin(k * Y)

    def exact(t):
        return -G / c**2 * (length * Y - 0.5 * Y**2 - share @ np.cos(c * k * t))

    error = _swing(solver, way, SNOW, 8.0 * length / c, exact, lambda: states.positions()[top, 1].mean() - Y)
    return clock.found(error)


RUBBER = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.0)
BEAM = (1.0, 0.05)
"""Length and thickness [m] of the beam."""


def beam(way):
    """A cantilever of L / t = 20 on which weight falls all at once, for one and a half periods: its end, in time."""
    length, thickness = BEAM
    dx = thickness / way.cells
    x, volumes = lattice([0.0, 0.0], [length, thickness], dx)
    x = x + np.array([0.0, 1.0])
    gravity = 0.08 * 1e6 * thickness**2 / 12.0 / 1000.0 / length**3  # the end hangs by 0.01 L
    solver, clock = _solver(way, x, volumes, RUBBER, dx, [1.5, 2.0], [["stick", "open"], ["open", "open"]],
                            [0.0, -gravity], gradient="shape")
    states = ParticleStates(solver)
    end = states.reference[:, 0] > length - 0.5 * dx
    omega, share = timoshenko(length, thickness, RUBBER)
    period = 2.0 * np.pi / omega[0]

    def exact(t):
        return -gravity * share @ ((1.0 - np.cos(omega * t)) / omega**2)

    height = states.reference[end, 1].mean()
    return clock.found(_swing(solver, way, RUBBER, 1.5 * period, exact,
                              lambda: states.positions()[end, 1].mean() - height))


def timoshenko(length, thickness, law, n=200):
    """Frequencies [1/s] of a cantilever, and what each mode adds to its end under an even acceleration: linear elements
    of deflection and rotation, shear at their middles."""
    h, area, second = length / n, thickness, thickness**3 / 12.0
    shear = 5.0 / 6.0 * 0.5 * law.youngs_modulus / (1.0 + law.poisson_ratio) * area
    bending = law.youngs_modulus * second
    K, M = np.zeros((2, 2 * n + 2, 2 * n + 2))
    strain, curve = np.array([-1.0 / h, -0.5, 1.0 / h, -0.5]), np.array([0.0, -1.0 / h, 0.0, 1.0 / h])
    mass = h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    for i in range(n):
        at = slice(2 * i, 2 * i + 4)
        K[at, at] += h * (shear * np.outer(strain, strain) + bending * np.outer(curve, curve))
        M[2 * i:2 * i + 4:2, 2 * i:2 * i + 4:2] += law.density * area * mass
        M[2 * i + 1:2 * i + 4:2, 2 * i + 1:2 * i + 4:2] += law.density * second * mass
    K, M = K[2:, 2:], M[2:, 2:]
    squares, modes = linalg.eigh(K, M, subset_by_index=[0, 15])
    evenly = np.zeros(2 * n)
    evenly[::2] = 1.0
    return np.sqrt(squares), (modes.T @ M @ evenly) * modes[-2]


def settling(way):
    """A soft column that comes to rest under its weight (M5). Explicit: `initial.stress = "settle"`, to a tolerance of
    way.step."""
    length = 10.0
    dx = length / way.cells
    x, volumes = lattice([0.0, 0.0], [4.0 * dx, length], dx)
    solver, clock = _solver(way, x, volumes, SOFT, dx, [4.0 * dx, 1.1 * length],
                            [["slip", "slip"], ["stick", "open"]], [0.0, -G], "quasi_static")
    states = ParticleStates(solver)
    if way.implicit:
        _load(solver, 0.0, 1.0, int(way.step))
    else:
        settle(solver, way.step, length)
    return clock.found(_sunk(states, length))


def _sunk(states, length, gravity=G):
    """Largest error of a height in a soft column, over the settlement of its top."""
    law = SOFT.model_copy(update={"density": SOFT.density * gravity / G})
    Y = states.reference[:, 1]
    exact = exact_height(law, length, Y)
    return np.abs(states.positions()[:, 1] - exact).max() / (length - exact_height(law, length, length))


def _load(solver, first, last, steps):
    """Steps at rest from one share of the weight to another."""
    for share in np.linspace(first, last, steps + 1)[1:]:
        solver.set_gravity([0.0, -G * share])
        solver.step(1.0)


LEVELS = np.arange(1, 11) / 10.0


def slow_loading(way):
    """The same column while its weight grows: at ten levels of it. Explicit: over way.step periods of its first swing,
    without damping; implicit: way.step steps from level to level."""
    length = 10.0
    dx, period = length / way.cells, 4.0 * length / SOFT.wave_speed()
    x, volumes = lattice([0.0, 0.0], [4.0 * dx, length], dx)
    solver, clock = _solver(way, x, volumes, SOFT, dx, [4.0 * dx, 1.1 * length],
                            [["slip", "slip"], ["stick", "open"]], [0.0, -G * LEVELS[0]], "quasi_static")
    states, off = ParticleStates(solver), []
    for last, level in zip((0.0, *LEVELS[:-1]), LEVELS, strict=True):
        if way.implicit:
            _load(solver, last, level, int(way.step))
        else:
            while solver.time < level * way.step * period:
                solver.set_gravity([0.0, -G * min(1.0, solver.time / (way.step * period))])
                solver.step(solver.stable_dt()[0])
        off.append(_sunk(states, length, G * level))
    return clock.found(np.sqrt(np.mean(np.square(off))))


class _TimedScheme:
    """A `Scheme` whose simulations are timed."""

    def __init__(self, clock):
        self.clock = clock

    def simulation(self, *given):
        found = Scheme("apic").simulation(*given)
        self.clock.follow(found.solver)
        return found


def saw_test(way):
    """Deflection of the free end of a cut slab at rest (S1); way.cells: in the height of the slab."""
    clock, cut, dx = Clock(), elastic_saw_test.CUTS[1], elastic_saw_test.SLAB_HEIGHT / way.cells
    if way.implicit:
        _, end = at_rest(cut, dx=dx, follow=clock.follow)
    else:
        _, end = elastic_saw_test.at_rest(_TimedScheme(clock), cut, 0.0, dx)
    return clock.found(abs(end / elastic_saw_test.FLAT[1] - 1.0))


def ways(explicit, implicits):
    """[Way] of (cells, step)."""
    return [Way(False, *one) for one in explicit] + [Way(True, *one) for one in implicits]


CASES = {
    column: ways([(8, 1.0), (16, 1.0), (32, 1.0), (64, 1.0), (32, 0.5)],
                 [(32, 10.0), (32, 4.0), (16, 2.0), (32, 2.0)]),
    beam: ways([(3, 1.0), (4, 1.0), (6, 1.0)], [(3, 400.0), (4, 400.0), (4, 200.0)]),
    settling: ways([(16, 2e-2), (16, 2e-3), (32, 2e-2), (32, 2e-3), (32, 2e-4), (64, 2e-3)],
                   [(16, 1), (32, 1), (64, 1), (32, 4)]),
    saw_test: ways([(20, 1.0)], [(20, 1)]),
    slow_loading: ways([(16, 4.0), (16, 16.0), (32, 2.0), (32, 4.0), (32, 16.0), (32, 32.0)],
                       [(16, 1), (32, 1), (32, 4), (64, 1)]),
}
"""What is measured of each, the cheapest of both kinds first."""
