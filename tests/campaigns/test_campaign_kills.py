"""C3: workers die by kill -9, a disk is full, runs fail: every run is done once, and the answer is the same."""

import contextlib
import os
import random
import resource
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from snowmpm.campaigns import answers, cluster
from snowmpm.campaigns.conduct import Conductor
from snowmpm.campaigns.launch import conduct_runs, forget_failed, prepare, run_campaign
from snowmpm.campaigns.members import make_plan
from snowmpm.campaigns.spec import Cluster
from snowmpm.campaigns.table import records_of
from snowmpm.campaigns.work import UNWRITTEN, job_of, work
from snowmpm.errors import WriteError
from tests.support.small_campaign import small_file

distributed = pytest.importorskip("distributed")


def answer(folder, plan):
    """Table and stack of a campaign, as arrays and text."""
    answers.write_answers(plan, records_of(plan))
    from snowmpm.campaigns.stack import open_stack

    stack, maps = (open_stack(folder, "base", what).load() for what in ("runs", "maps"))
    return (folder / "table.csv").read_text(), stack, maps


def same(one, other):
    assert one[0] == other[0]
    assert one[1].identical(other[1]) and one[2].identical(other[2])


class Killer:
    """Context: whenever some more runs are done, a worker of a `Site` is killed by SIGKILL a moment later, in the
    middle of what it does. By runs and not by time, since on a busy machine a worker may take long to begin."""

    def __init__(self, site, plan, every, seed):
        self._site, self._plan, self._every, self._random = site, plan, every, random.Random(seed)
        self.killed, self._ended = [], threading.Event()
        self._thread = threading.Thread(target=self._kill)

    def _done(self):
        return len(list(self._plan.folder.glob("results/*/record.json")))

    def _kill(self):
        due = 0
        while not self._ended.wait(0.05):
            if self._done() < due:
                continue
            with contextlib.suppress(Exception):  # while workers come and go
                processes = sorted(self._site.client.run(os.getpid).values())
                self._ended.wait(self._random.uniform(0.0, 0.8))
                os.kill(self._random.choice(processes), signal.SIGKILL)
                self.killed.append(due)
                due = self._done() + self._random.randint(1, 2 * self._every - 1)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._ended.set()
        self._thread.join()


def with_kills(runs, folder, every, seed):
    """(answer, kills, records) of a campaign of which a worker is killed after about `every` further runs."""
    plan, _ = prepare(small_file(runs=runs), folder, 2)
    with cluster.site(Cluster(workers=2)) as site, Killer(site, plan, every, seed) as killer:
        conduct_runs(plan, site)
    return answer(plan.folder, plan), killer.killed, records_of(plan)


def one_after_the_other(runs, folder):
    """The answer of the same runs in this process, without a cluster."""
    plan, _ = prepare(small_file(runs=runs), folder, 2)
    for member in plan.members:
        assert work(job_of(plan, member))["status"] == "done"
    return answer(plan.folder, plan)


@pytest.mark.slow
def test_killed_workers_change_nothing(tmp_path):
    found, killed, records = with_kills(8, tmp_path / "killed", 3, 1)
    assert len(killed) >= 2
    assert len(records) == 8 and {record["status"] for record in records.values()} == {"done"}
    same(found, one_after_the_other(8, tmp_path / "alone"))


@pytest.mark.slow
def test_200_runs_with_kills(tmp_path):
    found, killed, records = with_kills(200, tmp_path / "killed", 10, 2)
    print(f"{len(killed)} kills in 200 runs")
    assert len(killed) > 10
    assert len(records) == 200 and {record["status"] for record in records.values()} == {"done"}
    same(found, one_after_the_other(200, tmp_path / "alone"))


def test_a_killed_run_goes_on_from_its_checkpoint(tmp_path):
    """A worker process, killed in the middle of a run: the next one takes the run up."""
    plan = make_plan(small_file(runs=1), tmp_path / "campaign", 20.0)
    job = job_of(plan, plan.members[0])
    whole = work(job_of(make_plan(small_file(runs=1), tmp_path / "whole", 20.0), plan.members[0]))
    begun = _half(job)
    assert begun
    again = work(job)
    assert again["work"]["resumed"] and again["numbers"] == whole["numbers"]


def _half(job):
    """Begin a run and leave it after some steps, as a killed worker does; whether it has a checkpoint."""
    from snowmpm.io import checkpoint
    from snowmpm.running.loop import run
    from snowmpm.scenes import load_scene

    def stop(progress):
        if progress.time > 0.3 * progress.end_time:
            raise RuntimeError("killed")

    with pytest.raises(RuntimeError):
        run(load_scene(job.base, job.changes), job.run, progress=stop)
    return (Path(job.run) / checkpoint.FILE).exists()


def test_a_failing_run_stops_no_other(site, tmp_path):
    """A fixed step that is too long is refused when the run begins: recorded, and done again only when asked."""
    file = small_file(runs=None, design="grid", parameters={
        "step": {"key": "solver.dt", "distribution": "choices", "values": [0.05, 39.0]}})
    said = []
    found = run_campaign(file, tmp_path / "one", scheduler=site.client.scheduler.address, say=said.append)
    assert list(found.table.status) == ["done", "failed"]
    assert len(found.failures) == 1 and all(found.failures.values())
    assert any("failed:" in text for text in said) and found.done == 1
    assert np.isnan(found.stack.peak_depth.values[1]).all() and found.maps.attrs["runs"] == 1
    again = run_campaign(file, tmp_path / "one", resume=True, say=said.append)
    assert again.table.equals(found.table)
    assert forget_failed(found.plan) == 1 and len(records_of(found.plan)) == 1


def test_resume_does_what_is_missing(site, tmp_path):
    address = site.client.scheduler.address
    first = run_campaign(small_file(runs=4, design="random"), tmp_path / "one", scheduler=address)
    kept = {path: path.stat().st_mtime_ns for path in first.folder.glob("results/*/record.json")}
    lost = sorted(kept)[0]
    lost.unlink()
    said = []
    again = run_campaign(small_file(runs=6, design="random"), tmp_path / "one", scheduler=address, resume=True,
                         say=said.append)
    assert said[0].startswith("3 runs")
    assert again.done == 6
    for path, time_of in kept.items():
        assert (path.stat().st_mtime_ns == time_of) == (path != lost)
    assert np.array_equal(again.table.runout[:4], first.table.runout)


def test_no_other_campaign_in_a_folder(site, tmp_path):
    from snowmpm.errors import InputError

    plan, _ = prepare(small_file(runs=2), tmp_path / "one", 2)
    plan.write()
    with pytest.raises(InputError, match="already holds a campaign: --resume"):
        prepare(small_file(runs=2), tmp_path / "one", 2)


def _small_disk():
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY))


@pytest.mark.slow
def test_a_worker_with_a_full_disk_is_sent_away(tmp_path):
    plan, _ = prepare(small_file(runs=4), tmp_path / "campaign", 2)
    said = []
    with cluster.site(Cluster(workers=2)) as site:
        full = site.workers()[0]
        site.client.run(_small_disk, workers=[full])
        conduct_runs(plan, site, said.append)
        left = site.workers()
    records = records_of(plan)
    assert len(records) == 4 and {record["status"] for record in records.values()} == {"done"}
    assert {record["work"]["worker"] for record in records.values()} == set(left) and full not in left
    assert any("sent away: disk full" in text for text in said)


def test_no_worker_can_write():
    with cluster.site(Cluster(workers=1)) as site, pytest.raises(WriteError, match="no worker is left that can write"):
        list(Conductor(site).results(cannot_write, ["a"]))


def cannot_write(job):
    from distributed.worker import get_worker

    return {"status": UNWRITTEN, "reason": "disk full: /x", "work": {"worker": get_worker().address}}


def test_time_is_not_measured_in_the_table(tmp_path):
    """What differs from run to run, such as wall time, is in work.csv and not in the table."""
    names = {"wall_time", "seconds", "worker", "process", "started"}
    plan = make_plan(small_file(runs=1), tmp_path, 20.0)
    record = work(job_of(plan, plan.members[0]))
    assert not names & set(record["numbers"]) and names - {"wall_time"} <= set(record["work"])
    assert record["work"]["started"] <= time.time()
