"""What a region will cost: of a few of its releases, spread over their volumes, the cost that `check` foretells."""

import shutil
import tempfile
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from snowmpm.amounts import large, long_time
from snowmpm.campaigns.forecast import START, survey
from snowmpm.campaigns.work import start_quietly
from snowmpm.errors import InputError, SimulationError
from snowmpm.region import plan

LOOKED_AT = 8
"""Releases of a scenario that are looked at."""
RESULT = 60_000.0
"""Bytes of the results of a run, about."""
EUROS = 0.04
"""Price of a core hour in a cloud [euros], about, in 2025."""


@dataclass(frozen=True)
class Forecast:
    """runs; seconds of processor time a run; memory of a worker, disk and free [bytes]; workers."""

    runs: int
    each: float
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
        return (f"{self.runs} runs of about {self.each:.1f} s: {long_time(self.seconds)} with {self.workers} workers"
                f" ({self.core_hours:.2g} core hours, about {max(EUROS * self.core_hours, 0.01):.2f} euros of cloud),"
                f" {large(self.disk)} of disk, {large(self.memory)} a worker")

    def check(self, source):
        """Raise InputError if the disk is too small."""
        if self.disk > self.free:
            raise InputError(f"{source}: {self.runs} runs would take {large(self.disk)} of disk, of which"
                             f" {large(self.free)} are free:\nkeep = \"results\", a larger flow.cell, most_releases, or"
                             " another disk with -o")


def forecast(setting, workers=1, left=None):
    """`Forecast` of the runs of a `plan.Setting`. left: how many of them are to be done."""
    from snowmpm.region.elevations import open_elevations
    from snowmpm.region.jobs import RegionJob, changes_of, first_window
    from snowmpm.scenes import load_scene

    start_quietly("cpu", setting.file.cluster.threads)
    seconds, memory, folders = [], 0.0, 0.0
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
                seconds.append(found.seconds)
                memory, folders = max(memory, found.memory), max(folders, found.run)
    runs = plan.count_of(setting) if left is None else left
    each = RESULT + (folders if setting.file.keep == "runs" else 0.0)
    free = shutil.disk_usage(setting.folder).free
    return Forecast(runs, float(np.mean(seconds or [1.0])), memory, runs * each + workers * folders, free, workers)
