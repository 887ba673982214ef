"""A rehearsal of two machines: scheduler and workers are programs of their own, each in its own folder, who share the
campaign's folder alone. The scheduler is killed and started again, and so is a worker."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

from snowmpm.campaigns.cluster import connect
from snowmpm.campaigns.launch import prepare, run_campaign
from snowmpm.campaigns.table import records_of
from snowmpm.campaigns.work import RECORD, job_of, work
from snowmpm.errors import InputError, SimulationError
from tests.support.small_campaign import small_file

distributed = pytest.importorskip("distributed")


class Machine:
    """Programs in folders of their own, which are killed at the end."""

    def __init__(self, folder):
        self._folder, self._programs = folder, []
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"

    def start(self, name, *arguments):
        own = self._folder / name
        own.mkdir(exist_ok=True)
        with (own / "log").open("a") as log:
            program = subprocess.Popen([sys.executable, "-m", f"distributed.cli.{arguments[0]}", *arguments[1:]],
                                       cwd=own, stdout=log, stderr=log, start_new_session=True)
        self._programs.append(program)
        return program

    def scheduler(self):
        return self.start("scheduler", "dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port),
                          "--no-dashboard")

    def worker(self, name):
        return self.start(name, "dask_worker", self.address, "--nthreads", "1", "--local-directory", "scratch",
                          "--host", "127.0.0.1", "--no-dashboard", "--death-timeout", "120")

    def kill(self, program):
        os.killpg(program.pid, signal.SIGKILL)
        program.wait()

    def end(self):
        for program in self._programs:
            if program.poll() is None:
                self.kill(program)


@pytest.fixture
def machine(tmp_path):
    found = Machine(tmp_path)
    yield found
    found.end()


def until(holds, seconds=60.0):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.2)


def done(folder):
    return len(list(folder.glob(f"results/*/{RECORD}")))


@contextlib.contextmanager
def in_the_meantime(action):
    """Context: the action is done by another thread; the campaign stays in this one, where Taichi was started."""
    failures = []

    def act():
        try:
            action()
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=act)
    thread.start()
    try:
        yield
    finally:
        thread.join()
        assert not failures, failures


@pytest.mark.slow
def test_scheduler_and_worker_are_killed_and_come_back(machine, tmp_path):
    folder = tmp_path / "shared" / "campaign"
    scheduler, one = machine.scheduler(), machine.worker("one")
    machine.worker("two")
    said, runs = [], 12

    def happen():
        until(lambda: done(folder) >= 2)
        machine.kill(one)
        machine.kill(scheduler)
        until(lambda: any("is gone" in text for text in said))
        machine.scheduler()
        machine.worker("one again")
        machine.worker("two again")

    with in_the_meantime(happen):
        found = run_campaign(small_file(runs=runs), folder, scheduler=machine.address, say=said.append, patience=120.0)
    assert found.done == runs
    assert any("is back" in text for text in said)
    records = found.records
    assert len(records) == runs and len({record["work"]["process"] for record in records.values()}) >= 2
    plan, _ = prepare(small_file(runs=runs), tmp_path / "alone", 1)
    for member in plan.members[:3]:
        assert work(job_of(plan, member))["numbers"] == records[member.hash]["numbers"]


@pytest.mark.slow
def test_a_scheduler_that_stays_away_leaves_a_campaign_to_resume(machine, tmp_path):
    folder = tmp_path / "campaign"
    scheduler = machine.scheduler()
    machine.worker("one")

    def happen():
        until(lambda: done(folder) >= 1)
        machine.kill(scheduler)

    with in_the_meantime(happen), pytest.raises(SimulationError, match="--resume completes the campaign"):
        run_campaign(small_file(runs=4), folder, scheduler=machine.address, patience=1.0)
    plan, expected = prepare(small_file(runs=4), folder, 1, resume=True)
    assert expected.runs == 4 - len(records_of(plan)) < 4


def test_no_scheduler_there():
    with pytest.raises(InputError, match=r"--scheduler tcp://127.0.0.1:1: no Dask scheduler answers"):
        connect(distributed, "tcp://127.0.0.1:1", patience=1.0)
