"""Running a region: release areas, runs on Dask, maps."""

import contextlib
import itertools
import json
import math
from collections import deque
from pathlib import Path

from snowmpm import overwriting
from snowmpm.amounts import long_time
from snowmpm.campaigns import cluster
from snowmpm.campaigns.conduct import PATIENCE, Conductor
from snowmpm.campaigns.work import RECORD
from snowmpm.draft import write_text
from snowmpm.errors import InputError, shown_line
from snowmpm.io import FolderLock
from snowmpm.region import journal, plan, preparing
from snowmpm.region.forecast import forecast
from snowmpm.region.jobs import work_on_all
from snowmpm.stages import stage

EVERY = 50
"""Runs between two lines that say how far it is."""
LOST = 0.01
"""Share of its snow that a run may lose without a word."""
USUAL = 2.5
"""Seconds of a run where nobody measured them."""
OVERHEAD, BUSY, MOST_BATCH = 0.005, 0.5, 64
"""Seconds that the scheduler and this process take for a job (`tests/benchmarks/region_scale.py measure`); the share of
their time for which they may be busy; runs of a job at most."""


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
        plan.require_no_links(folder)
        own = Path(file.source).resolve() == folder / plan.FILE  # a folder goes on by its own file
        names = [plan.SETTING, plan.TERRAIN, plan.BASE, plan.RESULTS, plan.MAPS, *([] if own else [plan.FILE]),
                 *(plan.areas_file("", name).name for name in file.scenarios)]
        overwriting.guard_in(folder, names)
        if begun:
            if not own:
                preparing.require_same(file, folder)
                preparing.rewrite(file, folder)
            setting = plan.read_setting(folder)
            preparing.write_base(setting)  # whatever lies there: the folder may come from anybody
        else:
            lock.make()
            setting = preparing.make(file, folder)
        for name, count in setting.areas.items():
            say(f"{name}: {count} release areas")
        journal.repair(folder)
        conduct(setting, scheduler, workers, retry, say, patience)
        write_all(setting)
    return setting


def conduct(setting, scheduler=None, workers=None, retry=False, say=lambda text: None, patience=PATIENCE):
    """Do the runs that are missing."""
    folder, options, known = setting.folder, setting.file.cluster, journal.done(setting.folder, retry)
    if retry:
        _forget_failed(folder)
    results = folder / plan.RESULTS
    overwriting.note_changing(results)
    count = dict.fromkeys(journal.STATUS, 0)
    left = sum(int(job.hash, 16) not in known for job in plan.jobs(setting))
    if left:
        before = index(setting)
        expected = forecast(setting, cluster.worker_count(options, workers), left, before.seconds[before.status == 0])
        say(expected.words)
        expected.check(setting.file.source)
        with (cluster.site(options, scheduler, workers, expected.memory) as site, stage("running", left, "runs") as now,
              results.open("a", encoding="utf-8") as file):
            say(f"dashboard: {site.dashboard}")
            conductor = Conductor(site, say, patience, options.backend == "cuda")
            todo = Batches((job for job in plan.jobs(setting) if int(job.hash, 16) not in known),
                           batch_of(len(site.workers()), expected.each or USUAL))
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
    for empty in (*(folder / "runs").glob("*"), folder / "runs"):  # a run removes its own folder
        with contextlib.suppress(OSError):
            empty.rmdir()


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
    newest = {entry["hash"]: entry["status"] for entry in journal.lines(folder)}
    for name, status in newest.items():
        if status == "failed":
            (plan.results_of(folder, name) / RECORD).unlink(missing_ok=True)


def index(setting):
    """`journal.Index` of the runs that the file of a region asks for."""
    return journal.index_of(setting.folder, list(setting.areas), plan.wanted(setting))


def counts(setting, found=None):
    """{scenario: {"areas" (found), "releases" (that were to be run), "done", "failed", "out_of_reach" (runs),
    "left_terrain", "moving", "below_reach" (runs that are done)}}. found: `journal.Index`."""
    found, rows = found or index(setting), {}
    for k, name in enumerate(found.names):
        own = found.scenario == k
        done = own & (found.status == 0)
        left = done & (found.left_share > LOST)
        rows[name] = {
            "areas": setting.areas[name],
            "releases": len(plan.chosen(setting.areas[name], setting.file.most_releases)),
            **{status: int((own & (found.status == s)).sum()) for s, status in enumerate(journal.STATUS)},
            "left_terrain": int(left.sum()), "moving": int((done & ~left & ~found.final).sum()),
            "below_reach": int((done & (found.travel_angle < setting.file.flow.reach)).sum())}
    return rows


def told(setting, found=None):
    """Lines that say what was done, and lines of what a reader of the maps must know, as (line, whether it warns)."""
    runs = setting.file.samples.runs
    for name, own in counts(setting, found).items():
        part = "" if own["releases"] == own["areas"] else f", {own['releases']} of them chosen by most_releases"
        each = f", each {runs} times" if runs > 1 else ""
        missing = own["releases"] * runs - own["done"] - own["failed"] - own["out_of_reach"]
        yield (f"{name}: {own['areas']} release areas{part}{each}: {own['done']} runs done"
               + (f", {own['out_of_reach']} not run, as routing at {setting.file.flow.reach:g} degrees does not reach"
                  " the area of interest" if own["out_of_reach"] else "")
               + (f", {own['failed']} failed" if own["failed"] else "")
               + (f", {missing} missing" if missing else "")), False
        if part:
            yield f"{name}: a trial: only {own['releases']} of {own['areas']} release areas were to be run", True
        if own["left_terrain"]:
            yield (f"{name}: {own['left_terrain']} runs lost more than {100 * LOST:g} % of their snow over the border"
                   " of the terrain or into cells without heights: the map ends there, the avalanches do not"), True
        if own["moving"]:
            yield (f"{name}: {own['moving']} runs still moved at flow.end_time = {setting.file.flow.end_time:g} s:"
                   " their run-out is not final"), True
        if own["failed"]:
            yield f"{name}: {own['failed']} runs failed and are missing in the maps; {plan.RESULTS} says why", True
        if own["below_reach"] and setting.file.area_of_interest:
            yield (f"{name}: {own['below_reach']} runs went further than flow.reach = {setting.file.flow.reach:g}"
                   " degrees: releases that were not run may reach the area of interest too; take a smaller one"), True


def costs(setting, found):
    """A line that says what a run took; "" without runs. found: `journal.Index`."""
    worked = found.seconds[found.status == 0]
    if not len(worked):
        return ""
    return f"{float(worked.mean()):.1f} s of processor time and {_bytes(setting, found) / 1e3:.0f} kB a run"


def _bytes(setting, index):
    """Mean bytes of the results of a few runs."""
    some = [k for k in range(0, len(index.hash), max(1, len(index.hash) // 20)) if index.status[k] == 0]
    sizes = [sum(one.stat().st_size for one in plan.results_of(setting.folder, index.name_of(k)).glob("*"))
             for k in some]
    return float(sum(sizes)) / max(len(sizes), 1)
