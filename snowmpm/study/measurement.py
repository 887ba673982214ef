"""One problem solved once: its error and what it cost."""

from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from snowmpm.draft import write_table
from snowmpm.keys import Keyed
from snowmpm.measured import costs
from snowmpm.reading.table_file import read_table
from snowmpm.study.problems.schemes import Scheme
from snowmpm.study.stopwatch import Stopwatch
from snowmpm.study.variation import BY_NAME


@dataclass(frozen=True)
class TimedScheme(Scheme):
    """A scheme whose solvers are timed."""

    watch: Stopwatch = field(default_factory=Stopwatch, compare=False, repr=False)

    def solver(self, population, laws, **options):
        return self.watch.time_steps_of(super().solver(population, laws, **options))

    def simulation(self, scene, dx, per_axis=2, overrides=None):
        simulation = super().simulation(scene, dx, per_axis, overrides)
        self.watch.time_steps_of(simulation.solver)
        return simulation


@dataclass(frozen=True)
class Measurement(Keyed):
    """Row of a table. cells: along the length that the problem names; error: relative, as the problem defines it;
    seconds: processor time of the steps; cfl: C of the elastic limit, of the longest steps."""

    problem: str
    variation: str
    dimension: int
    kernel: str
    gradient: str
    transfer: str
    flip_ratio: float
    precision: str
    cfl: float
    per_axis: int
    cells: int
    particles: int
    steps: int
    particle_steps: int
    seconds: float
    error: float

    @property
    def key(self):
        """What tells this measurement from others."""
        return self.problem, self.variation, self.cells

    @property
    def work(self):
        """Its particle-steps at the measured cost of each with its scheme and the usual law (`measured/costs.csv`) [s].
        Other programs on the machine change it no more than `particle_steps`, which count a cubic spline like a
        quadratic one."""
        method = "sph" if self.variation == "SPH" else "mpm"
        scheme = costs.Scheme(self.dimension, self.precision, self.kernel, self.gradient, self.transfer, method)
        ns, return_map = costs.transfers(scheme), BY_NAME[self.variation].options.get("return_map")
        if return_map:
            ns += costs.law(scheme, f"{costs.USUAL_LAW}, {return_map}")
        return 1e-9 * ns * self.particle_steps


def measure(problem, variation, cells):
    """`Measurement` of `problem` in this variation with `cells`."""
    dim = variation.options.get("dim", 2)
    scheme = variation.solved(problem.law, dim)
    timed = TimedScheme(**{f.name: vars(scheme)[f.name] for f in fields(scheme)})
    error = problem.error(timed, cells, per_axis=variation.per_axis, **variation.options)
    watch = timed.watch
    return Measurement(problem.name, variation.name, dim, scheme.kernel, scheme.gradient, scheme.transfer,
                       scheme.flip_ratio if "flip" in scheme.transfer else 0.0, scheme.precision,
                       round(scheme.courant(problem.law, dim), 4),
                       variation.per_axis, cells, watch.particles, watch.steps, watch.particle_steps,
                       float(f"{watch.seconds:.4g}"), float(f"{abs(error):.4g}"))


def write(rows, path):
    """Table of `Measurement`s as CSV; -> its path."""
    names = [f.name for f in fields(Measurement)]
    return write_table(path, names, [[vars(row)[name] for name in names] for row in rows])


def read(path):
    """`Measurement`s of a CSV file."""
    return read_table(Path(path), lambda row: Measurement(**{f.name: f.type(row[f.name]) for f in fields(Measurement)}))


def least_of(repeats):
    """One row of several measurements of the same: the least time, which the machine disturbed least."""
    return replace(repeats[0], seconds=min(row.seconds for row in repeats))
