"""kill -9 at any moment of a run with output, again and again: nothing is lost, and the end is the same to the bit."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from same_runs import assert_same, assert_same_runs

import snowmpm

HERE = Path(__file__).parent


class Nursery:
    """Processes that run the scene of this test, one at a time (`nursery.py`)."""

    def __init__(self):
        self._process = subprocess.Popen([sys.executable, "nursery.py", "killed.toml"], cwd=HERE,
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run(self, folder, *options, kill_after=None):
        """Exit code of `snowmpm run ... -o FOLDER`, -9 when it was killed after so many seconds."""
        self._process.stdin.write(" ".join([str(folder), *options]) + "\n")
        self._process.stdin.flush()
        child = int(self._process.stdout.readline())
        if kill_after is not None:
            timer = threading.Timer(kill_after, self._kill, [child])
            timer.start()
        code = int(self._process.stdout.readline())
        if kill_after is not None:
            timer.cancel()
            timer.join()
        return code

    @staticmethod
    def _kill(child):
        os.kill(child, signal.SIGKILL)

    def close(self):
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


@pytest.fixture(scope="module")
def nursery():
    one = Nursery()
    yield one
    one.close()


@pytest.fixture(scope="module")
def uninterrupted(nursery, tmp_path_factory):
    """(folder of a run that was never killed, seconds that such a run takes)."""
    folder = tmp_path_factory.mktemp("whole")
    began = time.monotonic()
    assert nursery.run(folder / "run") == 0
    return folder / "run", time.monotonic() - began


def finished_frames(folder, whole):
    """Number of frames that a run shows, after checking that they are those of the whole run."""
    if not (folder / "run.vtkhdf").exists():
        return 0
    run = snowmpm.Run(folder)
    assert_same(run.times, whole.times[: len(run)])
    for i in range(max(0, len(run) - 3), len(run)):
        one, other = run.frame(i), whole.frame(i)
        assert_same(one.points, other.points)
        assert_same(one.fields, other.fields)
    return len(run)


@pytest.mark.parametrize("kills", [3, pytest.param(100, marks=pytest.mark.slow)])
def test_killed_and_resumed(nursery, uninterrupted, tmp_path, kills):
    """Each life of a run ends at a random moment; it is resumed until it comes to its end, then another run begins."""
    (folder, life), moments = uninterrupted, random.Random(kills)
    whole, died, resumed, runs = snowmpm.Run(folder), 0, 0, 0
    while died < kills:
        here, options = tmp_path / f"run{runs}", []
        while True:
            delay = moments.uniform(0.0, life) if died < kills else None
            code = nursery.run(here, *options, kill_after=delay)
            resumed += options == ["--resume"] and (here / "run.vtkhdf").exists()
            if code == 0:
                break
            log = Path(f"{here}.log").read_text()
            assert code == -9 and "Traceback" not in log, log
            died += 1
            finished_frames(here, whole)
            # Killed before the first file is there, it has not begun
            options = ["--resume"] if here.is_dir() and any(here.iterdir()) else []
        assert_same_runs(folder, here)
        assert finished_frames(here, whole) == len(whole)
        assert {path.name for path in here.iterdir()} == {"checkpoint.npz", "run.vtkhdf", "scene.toml", "summary.json"}
        runs += 1
    print(f"{died} kills, {resumed} resumed starts, {runs} runs that came to their end")
    assert died == kills
