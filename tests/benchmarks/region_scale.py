"""How a region scales: simulated with measured times, from 1 to 10 000 workers.

    python tests/benchmarks/region_scale.py measure              # seconds a job that the scheduler and the master take
    python tests/benchmarks/region_scale.py simulate DIR [--overhead S] [--runs N] [-o FILE.csv]

measure sends jobs that do nothing to two workers, as `snowmpm region` sends releases. simulate plays N runs (40 000 by
default) whose times are drawn from those of the region in DIR, on W workers: the scheduler gives out one job after the
other, each for `overhead` seconds; a worker has the next one when the scheduler comes to it. A job holds as many runs
as `snowmpm region` puts into it for so many workers.

Columns of the table of simulate: workers; batch: runs of a job; hours by the clock; efficiency: of what so many workers
could do; busy: share of the time that the scheduler works.
"""

import argparse
import csv
import heapq
import sys
import time
from pathlib import Path

import numpy as np

WORKERS = 1, 2, 10, 50, 100, 200, 500, 1000, 2000, 5000, 10_000


def nothing(job):
    """A job that does nothing."""
    return [{"status": "done", "reason": "", "numbers": {}, "work": {}, "hash": f"{job:016x}", "scenario": "rare",
             "area": job, "sample": 0, "bounds": None}]


def measure(jobs=4000):
    """Seconds a job of the scheduler and the master together."""
    from snowmpm.campaigns.cluster import site
    from snowmpm.campaigns.conduct import Conductor
    from snowmpm.campaigns.spec import Cluster
    from snowmpm.region import journal

    with site(Cluster(), workers=2) as place:
        conductor = Conductor(place)
        list(conductor.results(nothing, range(1, 200)))
        begun, spent = time.perf_counter(), time.process_time()
        for _, records in conductor.results(nothing, range(1, jobs + 1)):
            journal.line_of(records[0])
        return (time.perf_counter() - begun) / jobs, (time.process_time() - spent) / jobs


def simulate(times, workers, overhead):
    """(hours, share of the time that the scheduler works) of jobs of these times [s]."""
    free = [0.0] * workers
    scheduler = end = 0.0
    for seconds in times:
        ready = heapq.heappop(free)
        scheduler = max(scheduler, ready) + overhead
        done = scheduler + seconds
        heapq.heappush(free, done)
        end = max(end, done)
    return end / 3600.0, len(times) * overhead / end


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("measure", "simulate"))
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--overhead", type=float, default=0.004)
    parser.add_argument("--runs", type=int, default=40_000)
    parser.add_argument("-o", "--output", type=Path)
    choice = parser.parse_args()
    if choice.what == "measure":
        wall, own = measure()
        print(f"{1e3 * wall:.2f} ms a job by the clock, {1e3 * own:.2f} ms of this process")
        return
    from snowmpm.region import journal, launch, plan

    setting = plan.read_setting(choice.folder)
    index = journal.index_of(setting.folder, list(setting.areas))
    known = index.seconds[index.status == 0].astype(float)
    times = np.random.default_rng(1).choice(known, choice.runs)
    with (choice.output.open("w", newline="", encoding="utf-8") if choice.output else sys.stdout) as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["workers", "batch", "hours", "efficiency", "busy"])
        for workers in WORKERS:
            batch = launch.batch_of(workers, float(known.mean()))
            jobs = [times[k : k + batch].sum() for k in range(0, len(times), batch)]
            hours, busy = simulate(jobs, workers, choice.overhead)
            table.writerow([workers, batch, f"{hours:.3g}", f"{times.sum() / 3600.0 / workers / hours:.3f}",
                            f"{busy:.3f}"])


if __name__ == "__main__":
    main()
