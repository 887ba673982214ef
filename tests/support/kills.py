"""Commands that go on after any of their processes was killed: a way to kill them."""

import os
import random
import signal
import socket
import subprocess
import sys
import time

import psutil
import pytest

PATIENCE = 600.0
"""Seconds after which a campaign that does not end has failed."""


def start(*words, log):
    return subprocess.Popen([sys.executable, "-m", *words], stdout=log, stderr=log, stdin=subprocess.DEVNULL)


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def kill(process):
    try:
        os.kill(process.pid, signal.SIGKILL)
        return True
    except (ProcessLookupError, psutil.NoSuchProcess):
        return False


class Cluster:
    """A scheduler and two workers in processes of their own, started again when they are gone."""

    def __init__(self, log):
        self.address, self._log, self._running = f"tcp://127.0.0.1:{free_port()}", log, {}
        self.keep()

    def keep(self):
        port = self.address.rpartition(":")[2]
        here = ("--no-dashboard", "--host", "127.0.0.1")
        words = {"scheduler": ("distributed.cli.dask_scheduler", "--port", port, *here),
                 **{name: ("distributed.cli.dask_worker", self.address, "--nthreads", "1", "--no-nanny", "--name",
                           f"{name}-{random.random()}", *here) for name in ("one", "two")}}
        for name, command in words.items():
            if name not in self._running or self._running[name].poll() is not None:
                self._running[name] = start(*command, log=self._log)

    @property
    def processes(self):
        return list(self._running.values())


def killed(folder, words, again, kills, seed, scheduler=False):
    """Do a command while it is killed; -> (kills by what was hit, exit code of the last command).

    words: of the command, which resumes; again: called with nothing where it ends before all kills, so that there is
    more to do; scheduler: whether its workers are those of a scheduler of its own.
    """
    chance, hit = random.Random(seed), {"master": 0, "other": 0}
    with open(folder / "log.txt", "w") as log:
        cluster = Cluster(log) if scheduler else None
        where = ("--scheduler", cluster.address, "--patience", "60") if cluster else ("--workers", "2")
        command = ("snowmpm", *words, "--resume", *where)
        master, until = start(*command, log=log), time.monotonic() + PATIENCE + 15.0 * kills
        try:
            while time.monotonic() < until:
                try:
                    master.wait(chance.uniform(0.0, 3.0) if sum(hit.values()) < kills else 1.0)
                except subprocess.TimeoutExpired:
                    if cluster:
                        cluster.keep()
                    if sum(hit.values()) < kills:
                        own = psutil.Process(master.pid).children(recursive=True) if master.poll() is None else []
                        others = [*own, *(cluster.processes if cluster else ())]
                        # Seldom the master: it takes seconds until it has workers that can be killed
                        victim = master if chance.random() < 0.15 else chance.choice(others) if others else None
                        if victim is not None:
                            hit["master" if victim is master else "other"] += kill(victim)
                    continue
                if master.returncode == 0 and sum(hit.values()) >= kills:
                    break
                if master.returncode not in (0, -signal.SIGKILL):
                    pytest.fail(f"{hit}: exit code {master.returncode}: " + (folder / "log.txt").read_text()[-1500:])
                if master.returncode == 0:  # done before all kills: once more from its beginning, for the rest
                    again()
                master = start(*command, log=log)
            return hit, master.poll()
        finally:
            for process in [master, *(cluster.processes if cluster else ())]:
                kill(process)
                process.wait()
