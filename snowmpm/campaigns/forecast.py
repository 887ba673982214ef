"""What a campaign will cost, before it starts: time, bytes on the disk, memory of a worker."""

import contextlib
import shutil
from dataclasses import dataclass
from pathlib import Path

from snowmpm.amounts import large, long_time
from snowmpm.campaigns.work import start_quietly
from snowmpm.errors import InputError

MAPS = 5
"""Rasters that are kept of each run."""

START = 10.0
"""Seconds until the first runs go: processes, imports, kernels."""


@dataclass(frozen=True)
class Survey:
    """One run of a variant: seconds on one thread of this machine; run: bytes of its folder; memory [bytes]; cell: side
    of its map cells [m], None without maps; cells: their number."""

    seconds: float
    run: float
    memory: float
    cell: float | None
    cells: int


def survey(scene, threads=1):
    """`Survey` of a scene, which is built for it. Raises InputError as `build` does."""
    from snowmpm.advice.budget import Budget
    from snowmpm.advice.calibration import measured_speed
    from snowmpm.advice.facts import SceneFacts
    from snowmpm.running.description import describe

    start_quietly("cpu", threads)
    built = _built(scene)
    model, solver = built.model, built.solver
    budget = Budget(SceneFacts(scene, model, solver), threads, measured_speed())
    facts = describe(model, solver)
    grid = model.map_grid if scene.dimension == 3 else None
    cells = int(grid.shape[0] * grid.shape[1]) if grid else 0
    return Survey(budget.total, float(budget.run_file + facts["checkpoint"]), float(facts["memory"]),
                  grid and float(grid.cell), cells)


class _Built(Exception):
    """A simulation is built: that is all that was wanted of it."""


def _built(scene):
    """A `Simulation` of a scene before its first step: all files that it names have been read."""
    from snowmpm.running.simulation import Simulation

    found = []

    def stop(simulation):
        found.append(simulation)
        raise _Built

    with contextlib.suppress(_Built):
        Simulation(scene, approve=stop)
    return found[0]


@dataclass(frozen=True)
class Forecast:
    """runs: their number; seconds: wall time with `workers`; core_hours; disk: bytes, of which `free` are; memory: of a
    worker [bytes]."""

    runs: int
    seconds: float
    core_hours: float
    disk: float
    free: float
    memory: float
    workers: int

    @property
    def words(self):
        """One line."""
        return (f"{self.runs} runs, about {long_time(self.seconds)} with {self.workers} workers"
                f" ({self.core_hours:.3g} core hours), {large(self.disk)} of disk, {large(self.memory)} a run")

    def check(self, source):
        """Raise InputError if the disk is too small."""
        if self.disk > self.free:
            raise InputError(f"{source}: {self.runs} runs would take {large(self.disk)} of disk, of which"
                             f" {large(self.free)} are free:\nfewer runs, keep = \"results\", a larger maps.cell or"
                             " output.interval, or another disk with -o")


def forecast(file, folder, surveys, runs, workers):
    """`Forecast` of a campaign. surveys: `Survey` by variant; runs: number of runs to be done, by variant."""
    seconds = disk = 0.0
    for variant, n in runs.items():
        one = surveys[variant]
        seconds += n * one.seconds
        # Once with the run's results, where cells without snow are left out, and once in the stack of all
        disk += n * (1.2 * 4.0 * MAPS * one.cells + (one.run if file.keep == "runs" else 0.0))
    if file.keep != "runs":
        disk += workers * max(one.run for one in surveys.values())
    there = next(parent for parent in (Path(folder), *Path(folder).parents) if parent.exists())
    return Forecast(sum(runs.values()), START + seconds / workers, seconds * file.cluster.threads / 3600.0, disk,
                    float(shutil.disk_usage(there).free), max(one.memory for one in surveys.values()), workers)
