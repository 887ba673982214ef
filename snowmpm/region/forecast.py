"""What a region will cost, from what was measured: of its runs that are done, else of a few that are run for it.

The forecast of single scenes does not serve: it counts the start of the program, which a worker makes once.
"""

import shutil
import tempfile
import time as clock
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from snowmpm.amounts import large, long_time
from snowmpm.campaigns.forecast import START, survey
from snowmpm.campaigns.work import start_quietly
from snowmpm.errors import InputError, SimulationError
from snowmpm.region import plan
from snowmpm.stages import counted

LOOKED_AT = 8
"""Releases of a scenario whose memory and disk are looked at."""
TIMED = 5
"""Releases that are run to measure their time, the first of them only to load kernels."""
ENOUGH = 8
"""Runs that are done, from which on nothing else is measured."""
FEW = 40
"""Runs that are not worth a measurement before they begin."""
RESULT = 60_000.0
"""Bytes of the results of a run, about."""
EUROS = 0.04
"""Price of a core hour in a cloud [euros], about, in 2025."""


@dataclass(frozen=True)
class Forecast:
    """runs; each: seconds of processor time a run, None where nobody measured them; memory of a worker, disk and free
    [bytes]; workers."""

    runs: int
    each: float | None
    memory: float
    disk: float
    free: float
    workers: int

    @property
    def seconds(self):
        """By the clock."""
        return START + self.runs * self.each / self.workers

    @property
    def core_hours(self):
        return self.runs * self.each / 3600.0

    @property
    def words(self):
        """One line."""
        time = "" if self.each is None else (
            f" of about {self.each:.1f} s: {long_time(self.seconds)} with {self.workers} workers"
            f" ({self.core_hours:.2g} core hours, about {max(EUROS * self.core_hours, 0.01):.2f} euros of cloud)")
        return f"{self.runs} runs{time}, {large(self.disk)} of disk, {large(self.memory)} a worker"

    def check(self, source):
        """Raise InputError if the disk is too small."""
        if self.disk > self.free:
            raise InputError(f"{source}: {self.runs} runs would take {large(self.disk)} of disk, of which"
                             f" {large(self.free)} are free:\nkeep = \"results\", a larger flow.cell, most_releases, or"
                             " another disk with -o")


def forecast(setting, workers=1, left=None, known=None):
    """`Forecast` of the runs of a `plan.Setting`. left: how many of them are to be done; known: seconds of those that
    are done."""
    from snowmpm.region.elevations import open_elevations
    from snowmpm.region.jobs import RegionJob, changes_of, first_window
    from snowmpm.scenes import load_scene

    start_quietly("cpu", setting.file.cluster.threads)
    memory, folders, samples = 0.0, 0.0, []
    with (tempfile.TemporaryDirectory() as scratch, open_elevations(setting.terrain) as elevations,
          warnings.catch_warnings()):
        warnings.simplefilter("ignore")  # of scenes, once for each of them
        whole = replace(setting, interest=None)
        for name, count in setting.areas.items():
            numbers = list(plan.chosen(count, setting.file.most_releases))
            for number in numbers[:: max(1, len(numbers) // LOOKED_AT)][:LOOKED_AT]:
                area = plan.read_area(setting.folder, name, number)
                job = RegionJob("0" * 16, str(setting.folder), name, number, 0, 1.0, 1.0)
                window = first_window(elevations, area, whole)
                inputs = Path(scratch) / f"{name}_{number}"
                try:
                    changes = changes_of(job, setting, area, elevations, window, inputs)
                    found = survey(load_scene(setting.folder / plan.BASE, changes), setting.file.cluster.threads)
                except (InputError, SimulationError):  # its run will say so
                    continue
                samples.append(changes)
                memory, folders = max(memory, found.memory), max(folders, found.run)
        each = None
        if known is not None and len(known) >= ENOUGH:
            each = float(np.mean(known))
        elif left is None or left > FEW:
            each = measured(setting, samples[:: max(1, len(samples) // TIMED)][:TIMED], Path(scratch))
    runs = plan.count_of(setting) if left is None else left
    size = RESULT + (folders if setting.file.keep == "runs" else 0.0)
    free = shutil.disk_usage(setting.folder).free
    return Forecast(runs, each, memory, runs * size + workers * folders, free, workers)


def measured(setting, samples, scratch):
    """Mean processor time [s] of runs of the base scene with changes. Those that fail are left out."""
    import snowmpm
    from snowmpm.scenes import load_scene

    seconds = []
    for k, changes in enumerate(counted(samples, "timing a few releases", "releases")):
        begun = clock.process_time()
        try:
            snowmpm.run(load_scene(setting.folder / plan.BASE, changes), scratch / f"timed_{k}")
        except (InputError, SimulationError):
            continue
        seconds.append(clock.process_time() - begun)
    return float(np.mean(seconds[1:] or seconds or [1.0]))
