"""Record of a propagation saw test during the run: the crack, the slab above it, the dissipated energy.

Along the column, in bins that move with the snow:

    broken      the number of particles of the weak layer that have lost their strength (`layer_work.BROKEN` of the
                law's "damage") is at least that of one row; a law without it never breaks
    arrival     time at which a bin broke by itself; none where the saw came first
    tip         end of the connected bins that are sawn, or have broken at any time, from the saw's end of the column.
                The saw takes broken particles away: a bin that it has entered, which cuts leaning bins at their lower
                end first, may hold less than a row of them, and stays broken
    slab        displacement and speed of its middle line relative to the state before the cut: settlement (down, normal
                to the slope) and slip (along the slope, in the direction of the saw)
    work        dissipated in the weak layer per area (`saw_test.layer_work`); its value at the arrival is the fracture
                energy; friction and compaction behind the tip add to it

The interval of the record is that of the weak layer (`saw_test.weak_layer`), the time in which a wave crosses one bin,
or longer if there would be more than `MOST_ROWS` rows. A layer whose steps are as long as a bin takes to break tells of
arrivals in each of them.
"""

from functools import cached_property

import numpy as np

from snowmpm.saw_test.prediction import (
    collapse_wave_speed,
    elastic_predictions,
    predictions,
    uncounted_by_theories,
)
from snowmpm.saw_test.result import result_of
from snowmpm.saw_test.weak_layer import weak_layer_of

WORN = 0.1
"""Damage of a particle of the weak layer before the saw comes above which a run warns."""
MOST_BINS, MOST_ROWS = 400, 1500
SERIES = {"time": "s", "saw": "m", "tip": "m", "plastic_work": "J"}
LINES = {"settlement": "m", "settling_speed": "m/s", "slip": "m", "slip_speed": "m/s", "work": "J/m2"}
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
        law = simulation.law_of_body(names.index("weak_layer"))
        layer = self._kind = weak_layer_of(scene)
        width = spec.resolution or max(2.0 * layer.finest, spec.length / MOST_BINS)
        self._count_bins(spec.length, width, spec.width_in(scene.dimension))
        wave = solver.particles.materials.wave_speed
        self.interval = max(layer.interval(self.bin, wave), scene.end_time / MOST_ROWS)

        x = population.positions
        spacing = scene.solver.spacing(scene.dimension)
        weak = np.flatnonzero(simulation.model.body_of == names.index("weak_layer"))
        middle = spec.slab_bottom + 0.5 * spec.slab_thickness
        slab = np.flatnonzero(np.abs(x[:, -1] - middle) < 1.01 * spacing)
        along = x[:, 0] - spec.lean * (x[:, -1] - spec.slab_bottom)
        along[weak] = layer.along(x[weak], spec.lean, spec.slab_bottom)
        self._weak_bin, self._slab_bin = (self._bin_of(along[chosen]) for chosen in (weak, slab))
        self._in_bin = np.bincount(self._weak_bin, minlength=len(self.x))
        self._row = self._in_bin / layer.rows(spacing)
        self._start = x[slab]

        self._probe, self._slab, self._layer = layer.followed(solver, weak, slab, population, law)
        self._rest = 0.0
        moved = self._moved()
        settlement, slip = self._means(-moved[:, -1], moved[:, 0])
        broken, damage = self._broken()[0], self._layer.damage()
        worst = int(np.argmax(damage)) if len(weak) else 0
        self.worn_at_rest = (float(damage[worst]), float(along[weak[worst]])) if len(weak) else (0.0, 0.0)
        """Largest damage in the weak layer at time zero [-], and where along the column [m]."""
        self.bins = {"x": self.x, "arrival": np.full(len(self.x), np.nan),
                     "fracture_energy": np.full(len(self.x), np.nan),
                     "rest_settlement": settlement, "rest_slip": slip,
                     "broken_at_rest": broken.astype(float)}
        self._rest = moved
        self.rows = {name: [] for name in (*SERIES, *LINES)}
        self._taken, self._overdue = 0, bool(broken.any())  # at time zero nothing arrives
        self._wait()
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
            ends = "" if self._scene.saw_test.ends == "vertical" else "vertical ends, "
            yield (f"the weak layer has lost {worn:.0%} of its strength at x = {place:.2f} m before the saw begins: the"
                   f" critical length of a cut there is too short; {ends}a gentler slope or a lighter slab load it"
                   " less")

    def watch(self):
        """After a step."""
        if self._solver.time >= self._row_at + self.interval:
            self._measure()
        elif self._kind.EACH_STEP and (self._layer.add_work() or self._overdue):
            self._look_for_arrivals()

    def _measure(self):
        self._probe.read()
        self._layer.add_work()
        time, row = self._solver.time, self.rows
        self._row_at = time
        moved, velocity = self._moved(), self._probe.column("velocity", self._slab)
        row["time"].append(time)
        row["saw"].append(self._saw.cut_to)
        row["plastic_work"].append(self._solver.totals.plastic_work)
        names = "settlement", "settling_speed", "slip", "slip_speed"
        means = self._means(-moved[:, -1], -velocity[:, -1], moved[:, 0], velocity[:, 0])
        for name, values in zip(names, means, strict=True):
            row[name].append(values.astype(np.float32))
        broken = self._look_for_arrivals()
        row["work"].append((self._sum(self._layer.work()) / self._bin_area).astype(np.float32))
        row["tip"].append(self.bin * float(np.argmin(np.append(broken, False))))

    def _look_for_arrivals(self):
        """Which bins (bins,) are broken or sawn; those that have just broken have arrivals from now on."""
        cracked, sawn = self._broken()
        self._overdue &= self._solver.time == 0.0
        new = cracked & np.isnan(self.bins["arrival"]) & (self._solver.time > 0.0)
        if new.any():
            self.bins["arrival"][new] = self._solver.time
            chosen = np.flatnonzero(new[self._weak_bin])
            work = np.bincount(self._weak_bin[chosen], self._layer.work(chosen), len(self.x)) / self._bin_area
            self.bins["fracture_energy"][new] = work[new]
            self._wait()
        return cracked | sawn | np.isfinite(self.bins["arrival"])

    def _wait(self):
        """Let the layer tell of changes where no crack has arrived yet."""
        self._layer.wait_for(np.isnan(self.bins["arrival"])[self._weak_bin])

    def _broken(self):
        """Which bins have broken, and which were sawn."""
        there = self._layer.there
        failed = self._sum(there & self._layer.broken)
        sawn = self._sum(there) < 0.5 * np.maximum(self._in_bin, 1)
        return (failed >= 0.99 * self._row) & ~sawn, sawn

    def _moved(self):
        """Displacement of the slab's middle particles (n, dim) [m]; against the rest state once there is one."""
        moved = self._probe.positions(self._slab) - self._start
        return moved - self._rest

    def _sum(self, values):
        return np.bincount(self._weak_bin, values, len(self.x))

    def _means(self, *columns):
        """Of each column its means over the slab's middle particles of each bin (bins,); NaN where there are none."""
        known, n = self._probe.there[self._slab], len(self.x)
        count = np.bincount(self._slab_bin, known, n)
        full = count > 0.0
        values = np.where(known, columns, 0.0)
        bins = self._slab_bin + n * np.arange(len(columns))[:, None]
        total = np.bincount(bins.ravel(), values.ravel(), n * len(columns)).reshape(-1, n)
        means = np.full(total.shape, np.nan)
        np.divide(total, count, out=means, where=full)
        if self._kind.finest < self._kind.dx and full.any():  # bins are narrower than particles
            return [np.interp(self.x, self.x[full], mean[full]) for mean in means]
        return means

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
                "taken": self._taken, "row_at": self._row_at, "rest": self._rest, **self._layer.state()}

    def restore(self, state):
        """Restore the result of `state()`."""
        self.rows = {name: list(rows) for name, rows in state["rows"].items()}
        self.bins = {name: np.array(values) for name, values in state["bins"].items()}
        self._taken, self._rest = state["taken"], state["rest"]
        self._row_at = state.get("row_at", state["read_at"])
        self._layer.restore(state)
        self._wait()
