"""Record of a propagation saw test during the run: the crack, the slab above it, the dissipated energy.

Along the column, in bins that move with the snow:

    broken      the number of particles of the weak layer that have lost `BROKEN` of their strength (the law's
                "damage") is at least that of one row; a law without damage never breaks
    arrival     time at which a bin broke by itself; none where the saw came first
    tip         end of the connected bins that are sawn, or have broken at any time, from the saw's end of the column.
                The saw takes broken particles away: a bin that it has entered, which cuts leaning bins at their lower
                end first, may hold less than a row of them, and stays broken
    slab        displacement and speed of its middle line relative to the state before the cut: settlement (down, normal
                to the slope) and slip (along the slope, in the direction of the saw)
    work        dissipated in the weak layer per area,  sum_p V_p ( int tau : d dt + psi_0 - psi ) / A, d = sym grad v;
                its value at the arrival is the fracture energy; friction and compaction behind the tip add to it; of an
                interface (`particles.interface`) d is the strain of the layer, so that the integral is that of the
                traction over the displacement, and the bins are two points wide

The interval of the record is the time in which a wave crosses one bin, of an interface half a cell, or longer if there
would be more than `MOST_ROWS` rows; work and arrivals of an interface are followed in each step.
"""

from functools import cached_property

import numpy as np

from snowmpm.particles.interface import CUT
from snowmpm.saw_test.prediction import (
    collapse_wave_speed,
    elastic_predictions,
    predictions,
    uncounted_by_theories,
)
from snowmpm.saw_test.result import result_of

BROKEN = 0.99
WORN = 0.1
"""Damage of a particle of the weak layer before the saw comes above which a run warns."""
MOST_BINS, MOST_ROWS = 400, 1500
SERIES = {"time": "s", "saw": "m", "tip": "m", "plastic_work": "J"}
LINES = {"settlement": "m", "settling_speed": "m/s", "slip": "m", "slip_speed": "m/s", "work": "J/m2"}
SYMMETRIC = {2: ((0, 0, 0), (1, 1, 1), (0, 1, 3)),
             3: ((0, 0, 0), (1, 1, 1), (2, 2, 2), (0, 1, 3), (1, 2, 4), (0, 2, 5))}
"""(i, j, number) of the entries of a stress: xx, zz, out of plane, xz; or xx, yy, zz, xy, yz, xz."""
BINS = {"x": "m", "arrival": "s", "fracture_energy": "J/m2", "rest_settlement": "m", "rest_slip": "m",
        "broken_at_rest": "1"}


class CrackRecord:
    """Rows of `SERIES` (k,) and `LINES` (k, bins), and `BINS` (bins,), of a simulation with a saw test.

    x: middle of each bin along the weak layer; broken_at_rest: 1 where it had broken before the saw began;
    rest_settlement, rest_slip: displacement of the slab's middle line at time zero against the unstressed column. NaN:
    no value (yet).
    """

    def __init__(self, simulation, saw):
        """simulation: `snowmpm.running.simulation.Simulation` at rest before the cut; saw: its `Saw`."""
        scene, solver, population = simulation.scene, simulation.solver, simulation.model.population
        dx = scene.solver.dx
        spec = scene.saw_test.drawn(dx)
        self._scene, self._solver, self._saw = scene, solver, saw
        names = [body.name for body in scene.bodies]
        self._law = simulation.law_of_body(names.index("weak_layer"))
        self._points = spec.weak_layer.interface
        width = 2.0 * dx / (self._points or 1)
        self._count_bins(spec.length, max(width, spec.length / MOST_BINS), spec.width_in(scene.dimension))
        wave = solver.particles.materials.wave_speed
        self.interval = max((0.5 * dx if self._points else self.bin) / wave, scene.end_time / MOST_ROWS)

        x, total = population.positions, len(population.volumes)
        spacing = scene.solver.spacing(scene.dimension)
        weak = np.flatnonzero(simulation.model.body_of == names.index("weak_layer"))
        middle = spec.slab_bottom + 0.5 * spec.slab_thickness
        slab = np.flatnonzero(np.abs(x[:, -1] - middle) < 1.01 * spacing)
        self._probe = solver.particles.probe(np.concatenate([weak, slab]), total)
        self._weak, self._slab = slice(len(weak)), slice(len(weak), None)  # its parts
        along = x[:, 0] - spec.lean * (x[:, -1] - spec.slab_bottom)
        if self._points:
            along[weak] = x[weak, 0]  # of their place on the face
        self._weak_bin, self._slab_bin = (self._bin_of(along[chosen]) for chosen in (weak, slab))
        self._in_bin = np.bincount(self._weak_bin, minlength=len(self.x))
        self._row = self._in_bin / (1 if self._points else max(1, round(spec.weak_layer.thickness / spacing)))
        self._start = x[slab]

        self._dissipated = np.zeros(len(weak))  # int tau : d dt + psi_0 [J/m3]
        stress, state = self._stress_and_state()
        self._power, self._read_at = self._load(stress), solver.time
        self._dissipated += self._elastic(stress, state)
        self._rest = 0.0
        moved = self._moved()
        broken = self._broken(state)[0]
        damage = np.broadcast_to(self._law.outputs(state).get("damage", 0.0), len(weak))
        worst = int(np.argmax(damage)) if len(weak) else 0
        self.worn_at_rest = (float(damage[worst]), float(along[weak[worst]])) if len(weak) else (0.0, 0.0)
        """Largest damage in the weak layer at time zero [-], and where along the column [m]."""
        self.bins = {"x": self.x, "arrival": np.full(len(self.x), np.nan),
                     "fracture_energy": np.full(len(self.x), np.nan),
                     "rest_settlement": -self._mean(moved[:, -1]), "rest_slip": self._mean(moved[:, 0]),
                     "broken_at_rest": broken.astype(float)}
        self._rest = moved
        self.rows = {name: [] for name in (*SERIES, *LINES)}
        self._taken = 0
        self._measure()

    def _count_bins(self, length, width, across):
        n = max(1, round(length / width))
        self.bin, self._bin_area = length / n, length / n * across
        self.x = (np.arange(n) + 0.5) * self.bin

    def _bin_of(self, along):
        return np.clip((along / self.bin).astype(int), 0, len(self.x) - 1)

    def before_the_saw(self):
        """Warnings: damage of the weak layer before the saw begins."""
        if uncounted := uncounted_by_theories(self._scene):
            yield f"theories of the saw test count the weight of the slab alone, not {' and '.join(uncounted)}"
        broken, (worn, place) = self.bins["broken_at_rest"].mean(), self.worn_at_rest
        if broken > 0.0:
            yield (f"the weak layer has broken over {broken:.0%} of the column before the saw begins: its weight or its"
                   " ends overload it")
        elif worn > WORN:
            yield (f"the weak layer has lost {worn:.0%} of its strength at x = {place:.2f} m before the saw begins: the"
                   " critical length of a cut there is too short; vertical ends, a gentler slope or a lighter slab load"
                   " it less")

    def watch(self):
        """After a step."""
        if self._solver.time >= self._row_at + self.interval:
            self._measure()
        elif self._points:  # whose coarse steps are as long as a bin takes to break
            self._probe.read()
            self._follow_weak_layer(self._solver.time)

    def _measure(self):
        self._probe.read()
        time, row = self._solver.time, self.rows
        self._row_at = time
        moved, velocity = self._moved(), self._probe.column("velocity", self._slab)
        row["time"].append(time)
        row["saw"].append(self._saw.cut_to)
        row["plastic_work"].append(self._solver.totals.plastic_work)
        for name, values in (("settlement", -moved[:, -1]), ("settling_speed", -velocity[:, -1]),
                             ("slip", moved[:, 0]), ("slip_speed", velocity[:, 0])):
            row[name].append(self._mean(values).astype(np.float32))
        stress, state, broken = self._follow_weak_layer(time)
        row["work"].append(self._work(stress, state).astype(np.float32))
        row["tip"].append(self.bin * float(np.argmin(np.append(broken, False))))

    def _follow_weak_layer(self, time):
        """Stress and state of the layer, and which bins (bins,) are broken or sawn."""
        stress, state = self._stress_and_state()
        load = self._load(stress)
        self._dissipated += self._work_between(self._power, load, time - self._read_at)
        self._power, self._read_at = load, time
        cracked, sawn = self._broken(state)
        new = cracked & np.isnan(self.bins["arrival"]) & (time > 0.0)
        if new.any():
            self.bins["arrival"][new] = time
            self.bins["fracture_energy"][new] = self._work(stress, state)[new]
        return stress, state, cracked | sawn | np.isfinite(self.bins["arrival"])

    def _work(self, stress, state):
        """Work per area [J/m2] (bins,) so far."""
        volume = self._probe.column("volume", self._weak)[:, 0]
        return self._sum(volume * (self._dissipated - self._elastic(stress, state))) / self._bin_area

    def _broken(self, state):
        """Which bins have broken, and which were sawn."""
        there = self._there
        failed = self._sum(there & (self._law.outputs(state).get("damage", 0.0) >= BROKEN))
        sawn = self._sum(there) < 0.5 * np.maximum(self._in_bin, 1)
        return (failed >= 0.99 * self._row) & ~sawn, sawn

    def _moved(self):
        """Displacement of the slab's middle particles (n, dim) [m]; against the rest state once there is one."""
        moved = self._probe.positions(self._slab) - self._start
        return moved - self._rest

    def _stress_and_state(self):
        stored, state = (self._probe.column(name, self._weak) for name in ("stress", "state"))
        stress = np.zeros((len(stored), 6))
        stress[:, : stored.shape[1]] = stored
        return stress, state[:, : len(self._law.STATE)]

    def _elastic(self, stress, state):
        """psi [J/m3] of each particle of the weak layer, 0 for those that the saw removed."""
        return np.where(self._there, self._law.elastic_energy(stress, state), 0.0)

    @property
    def _there(self):
        """Particles of the weak layer that no saw has taken or cut."""
        there = self._probe.there[self._weak]
        if self._points:
            there = there & (self._probe.column("interface", self._weak)[:, CUT * self._solver.frame.dim] == 0.0)
        return there

    def _load(self, stress):
        """What the work until the next reading follows from: stress power [W/m3] (n,), or of points of an interface
        traction over thickness [Pa/m] and displacement [m] (n, 2 dim)."""
        return self._traction(stress) if self._points else self._stress_power(stress)

    def _work_between(self, before, after, dt):
        """Work per volume [J/m3] (n,) between two readings, by the mean of both."""
        if not self._points:
            return 0.5 * (before + after) * dt
        dim = self._solver.frame.dim
        return (0.5 * (before + after)[:, :dim] * (after - before)[:, dim:]).sum(axis=1)

    def _traction(self, stress):
        dim, column = self._solver.frame.dim, self._probe.column("interface", self._weak)
        tau = np.zeros((len(stress), dim, dim))
        for i, j, c in SYMMETRIC[dim]:
            tau[:, i, j] = tau[:, j, i] = stress[:, c]
        ratio = self._probe.column("volume_ratio", self._weak)
        return np.hstack([np.einsum("pij,pj->pi", tau, column[:, :dim]) / ratio, column[:, dim : 2 * dim]])

    def _stress_power(self, stress):
        """tau : sym grad v [W/m3] (n,)."""
        dim = self._solver.frame.dim
        d = self._probe.column("affine", self._weak).reshape(-1, dim, dim)
        power = sum(stress[:, c] * (d[:, i, j] + d[:, j, i]) * (0.5 if i == j else 1.0) for i, j, c in SYMMETRIC[dim])
        return np.where(self._probe.there[self._weak], power, 0.0)

    def _sum(self, values):
        return np.bincount(self._weak_bin, values, len(self.x))

    def _mean(self, values):
        """Mean over the slab's middle particles of each bin; NaN where there are none."""
        known = np.isfinite(values)
        count = np.bincount(self._slab_bin, known, len(self.x))
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.bincount(self._slab_bin, np.where(known, values, 0.0), len(self.x)) / count
        if self._points and (full := np.isfinite(mean)).any():
            # Points lie closer than particles
            mean = np.interp(self.x, self.x[full], mean[full])
        return mean

    def values(self):
        """All rows so far and the bins, as arrays by name."""
        return {**{name: np.array(rows) for name, rows in self.rows.items()}, **self.bins}

    def take(self):
        """Rows since the last call, {name: (k,) or (k, bins)}, and the bins as they are now."""
        first, self._taken = self._taken, len(self.rows["time"])
        return {name: np.array(rows[first:]) for name, rows in self.rows.items()}, self.bins

    def description(self):
        """Description for the run file besides the rows: arguments of `io.saw_test.create_saw_test`."""
        spec = self._scene.saw_test
        about = {"slope_angle": spec.slope_angle, "length": spec.length, "slab_thickness": spec.slab_thickness,
                 "weak_layer_thickness": spec.weak_layer.thickness, **self._cut(), **elastic_predictions(self._scene),
                 "theory": self.theory}
        return {"about": about, "series": SERIES, "lines": LINES,
                "bins": {name: (values, BINS[name]) for name, values in self.bins.items()}}

    def _cut(self):
        """How the saw cuts: speed [m/s], start [s], end of the cut and notch [m]."""
        spec = self._scene.saw_test
        return {"saw_speed": spec.saw_speed, "saw_start": spec.saw_start, "saw_length": spec.cut_length,
                "notch": spec.notch}

    @cached_property
    def theory(self):
        """Theories (`saw_test.theory`) that need nothing measured, by name."""
        return predictions(self._scene)

    def result(self):
        """Numbers of the test so far (`saw_test.result`), under "saw" its motion, and under "theory" the theories
        (`saw_test.theory`)."""
        spec = self._scene.saw_test
        found = result_of(self.values(), slab_thickness=spec.slab_thickness, saw_speed=spec.saw_speed)
        return {**found, "saw": self._cut(), "theory": {
            **self.theory, "collapse_wave_speed": collapse_wave_speed(self._scene, found["collapse_height"])}}

    def state(self):
        """All that a continuation needs, by name."""
        return {"rows": {name: np.array(rows) for name, rows in self.rows.items()}, "bins": dict(self.bins),
                "taken": self._taken, "dissipated": self._dissipated, "power": self._power, "read_at": self._read_at,
                "row_at": self._row_at, "rest": self._rest}

    def restore(self, state):
        """Restore the result of `state()`."""
        self.rows = {name: list(rows) for name, rows in state["rows"].items()}
        self.bins = {name: np.array(values) for name, values in state["bins"].items()}
        self._taken, self._read_at = state["taken"], state["read_at"]
        self._row_at = state.get("row_at", self._read_at)
        self._dissipated, self._power, self._rest = state["dissipated"], state["power"], state["rest"]
