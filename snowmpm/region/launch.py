"""Running a region: release areas, runs on Dask, maps."""

import itertools
import json
import math
import shutil
from collections import deque
from dataclasses import dataclass
from pathlib import Path

from snowmpm import overwriting
from snowmpm.amounts import large, long_time
from snowmpm.campaigns import cluster
from snowmpm.campaigns.conduct import PATIENCE, Conductor
from snowmpm.campaigns.work import RECORD
from snowmpm.draft import write_text
from snowmpm.errors import InputError, shown_line
from snowmpm.io import FolderLock
from snowmpm.region import journal, plan
from snowmpm.region.forecast import forecast
from snowmpm.region.jobs import work_on_all
from snowmpm.stages import stage

EVERY = 50
"""Runs between two lines that say how far it is."""
OVERHEAD, BUSY, MOST_BATCH = 0.005, 0.5, 64
"""Seconds that the scheduler and this process take for a job (`tests/benchmarks/region_scale.py measure`); the share of
their time for which they may be busy; runs of a job at most."""


@dataclass(frozen=True)
class Done:
    """runs: of all; done, failed, out_of_reach: how many of them."""

    runs: int
    done: int
    failed: int
    out_of_reach: int


def run_region(file, folder, scheduler=None, workers=None, resume=False, retry=False, say=lambda text: None,
               patience=PATIENCE):
    """Run a `RegionFile` in its folder, and map it; -> `plan.Setting`.

    scheduler: address of a Dask scheduler, "slurm", or None for processes of this machine; resume: do what is missing;
    retry: failed runs too; say: called with lines of text. Raises InputError before anything is written for bad input,
    a folder that holds something else, and more than the disk holds.
    """
    from snowmpm.region.maps import write_all

    folder = Path(folder).resolve()
    cluster.require_cluster()
    with FolderLock(folder) as lock, overwriting.keeping():
        begun = (folder / plan.SETTING).is_file()
        if begun and not resume:
            raise InputError(f"{folder} already holds a region: --resume completes it; or choose another folder with"
                             " -o")
        overwriting.guard_in(folder, (plan.FILE, plan.SETTING, plan.TERRAIN, plan.BASE, plan.RESULTS, plan.MAPS,
                                      *(plan.areas_file("", name).name for name in file.scenarios)))
        if begun:
            plan.require_same(file, folder)
            plan.rewrite(file, folder)
            setting = plan.read_setting(folder)
        else:
            lock.make()
            setting = plan.make(file, folder)
        for name, count in setting.areas.items():
            say(f"{name}: {count} release areas")
        journal.repair(folder)
        conduct(setting, scheduler, workers, retry, say, patience)
        write_all(setting)
    return setting


def conduct(setting, scheduler=None, workers=None, retry=False, say=lambda text: None, patience=PATIENCE):
    """Do the runs that are missing; -> `Done`."""
    folder, options = setting.folder, setting.file.cluster
    total, known = plan.count_of(setting), journal.done(setting.folder, retry)
    if retry:
        _forget_failed(folder)
    results = folder / plan.RESULTS
    overwriting.note_changing(results)
    count = dict.fromkeys(journal.STATUS, 0)
    left = sum(int(job.hash, 16) not in known for job in plan.jobs(setting))
    if left:
        expected = forecast(setting, workers=cluster.worker_count(options, workers), left=left)
        say(expected.words)
        expected.check(setting.file.source)
        with (cluster.site(options, scheduler, workers, expected.memory) as site, stage("running", left, "runs") as now,
              results.open("a", encoding="utf-8") as file):
            say(f"dashboard: {site.dashboard}")
            conductor = Conductor(site, say, patience, options.backend == "cuda")
            todo = Batches((job for job in plan.jobs(setting) if int(job.hash, 16) not in known),
                           batch_of(len(site.workers()), expected.each))
            for jobs, outcome in conductor.results(work_on_all, todo):
                if not isinstance(outcome, list) and len(jobs) > 1:  # a worker died: which of them did it?
                    todo.again(jobs)
                    continue
                for record in outcome if isinstance(outcome, list) else [_given_up(jobs[0], outcome)]:
                    file.write(journal.line_of(record))
                    count[record["status"]] += 1
                    if record["status"] == "failed":
                        say(f"{record['scenario']}, release {record['area']}, sample {record['sample']} failed:"
                            f" {record['reason']}")
                    now.done += 1
                    now.detail = f"{count['failed']} failed" if count["failed"] else ""
                    if now.done % EVERY == 0 and now.time_left is not None:
                        say(f"{now.done} of {left} runs, {3600.0 * now.done / now.seconds:.0f} an hour,"
                            f" {long_time(now.time_left)} left")
                file.flush()
    shutil.rmtree(folder / "runs", ignore_errors=True) if setting.file.keep != "runs" else None
    return Done(total, *(count[name] for name in journal.STATUS))


def batch_of(workers, each):
    """How many runs of so many seconds a job holds, so that the scheduler can feed all workers: at most MOST_BATCH."""
    return int(min(MOST_BATCH, max(1, math.ceil(OVERHEAD * workers / (BUSY * each)))))


class Batches:
    """Tuples of jobs, made as they are taken; those of a batch that came to nothing come again one by one."""

    def __init__(self, jobs, size):
        self._jobs, self._size, self._again = iter(jobs), size, deque()

    def __iter__(self):
        return self

    def __next__(self):
        if self._again:
            return (self._again.popleft(),)
        found = tuple(itertools.islice(self._jobs, self._size))
        if not found:
            raise StopIteration
        return found

    def again(self, jobs):
        """Take jobs back."""
        self._again.extend(jobs)


def _given_up(job, error):
    """Record of a run whose workers died, or could not begin it."""
    died = type(error).__name__ == "KilledWorker"
    reason = (f"its worker died {cluster.DEATHS + 1} times" if died
              else f"{type(error).__name__}: {shown_line(str(error), 300)}")
    record = {"status": "failed", "reason": reason, "numbers": {}, "work": {}}
    write_text(Path(job.results) / RECORD, json.dumps(record, indent=1))
    return {**record, "hash": job.hash, "scenario": job.scenario, "area": job.area, "sample": job.sample,
            "bounds": None}


def _forget_failed(folder):
    """Remove the records of runs that failed, so that they are done once more."""
    for entry in journal.lines(folder):
        if entry["status"] == "failed":
            (plan.results_of(folder, entry["hash"]) / RECORD).unlink(missing_ok=True)


def counts(setting):
    """{scenario: {"areas", "done", "failed", "out_of_reach"}}."""
    index = journal.index_of(setting.folder, list(setting.areas))
    return {name: {"areas": setting.areas[name], **{
        status: int(((index.scenario == k) & (index.status == s)).sum()) for s, status in enumerate(journal.STATUS)}}
        for k, name in enumerate(index.names)}


def told(setting):
    """Lines that say what was done."""
    for name, own in counts(setting).items():
        yield (f"{name}: {own['areas']} release areas; runs: {own['done']} done"
               + (f", {own['out_of_reach']} out of reach" if own["out_of_reach"] else "")
               + (f", {own['failed']} failed" if own["failed"] else ""))
    index = journal.index_of(setting.folder, list(setting.areas))
    worked = index.seconds[index.status == 0]
    if len(worked):
        yield f"{float(worked.mean()):.1f} s of processor time and {large(_bytes(setting, index))} a run"


def _bytes(setting, index):
    """Mean bytes of the results of a few runs."""
    some = [k for k in range(0, len(index.hash), max(1, len(index.hash) // 20)) if index.status[k] == 0]
    sizes = [sum(one.stat().st_size for one in plan.results_of(setting.folder, index.name_of(k)).glob("*"))
             for k in some]
    return float(sum(sizes)) / max(len(sizes), 1)
