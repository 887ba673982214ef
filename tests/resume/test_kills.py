"""kill -9 at any moment of a run with output, again and again: nothing is lost, and the end is the same to the bit."""

import collections
import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import snowmpm
from snowmpm.overwriting import LIST
from tests.support.same_runs import assert_same, assert_same_runs

HERE = Path(__file__).parent
METHODS = {"mpm": [], "sph": ["--set", "solver.method=sph"]}

# Share of the deaths: at any moment, or inside a write, where a moment would seldom hit. A resumed life first writes
# where the run file is cut back to the checkpoint.
DEATHS = {"moment": 0.5, "frame": 0.2, "first frame": 0.08, "checkpoint": 0.1, "before": 0.04, "after": 0.04,
          "resume": 0.04}


class Nursery:
    """Processes that run the scene of this test, one at a time (`nursery.py`)."""

    def __init__(self):
        self._process = subprocess.Popen([sys.executable, "nursery.py", "killed.toml"], cwd=HERE,
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run(self, folder, *options, death="none", kill_after=None):
        """Exit code of `snowmpm run ... -o FOLDER`, -9 when it died there or was killed after so many seconds."""
        self._process.stdin.write(" ".join([death, str(folder), *options]) + "\n")
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
    """uninterrupted(method) -> (folder of a run that was never killed, seconds that such a run takes)."""
    runs = {}

    def of(method):
        if method not in runs:
            folder, began = tmp_path_factory.mktemp(method), time.monotonic()
            assert nursery.run(folder / "run", *METHODS[method]) == 0
            runs[method] = folder / "run", time.monotonic() - began
        return runs[method]

    return of


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


def end_of_life(dice, life, begun):
    """(name of the death, arguments of `Nursery.run`) for one life; the first writes nothing for a while."""
    kind = dice.choices(list(DEATHS), DEATHS.values())[0]
    if kind == "moment":
        return kind, {"kill_after": dice.uniform(0.0 if begun else 0.25, 1.0) * life}
    where, most = {"frame": ("frame", 800), "first frame": ("frame", 12), "resume": ("resume", 1)}.get(kind, (kind, 6))
    return kind, {"death": f"{where}:{dice.randint(1, most)}"}


@pytest.mark.parametrize(("method", "resumes"), [
    ("mpm", 3), pytest.param("mpm", 100, marks=pytest.mark.slow), pytest.param("sph", 30, marks=pytest.mark.slow)])
def test_killed_and_resumed(nursery, uninterrupted, tmp_path, method, resumes):
    """Each life of a run ends somewhere; it is resumed until it comes to its end, then another run begins.

    Only deaths that leave something behind, and are thus resumed from, count.
    """
    (folder, life), dice = uninterrupted(method), random.Random(f"{method} {resumes}")
    whole, died, resumed, runs = snowmpm.Run(folder), collections.Counter(), 0, 0
    while resumed < resumes:
        here, options = tmp_path / f"run{runs}", []
        while True:
            kind, end = end_of_life(dice, life, bool(options)) if resumed < resumes else (None, {})
            code = nursery.run(here, *METHODS[method], *options, **end)
            if code == 0:
                break
            log = Path(f"{here}.log").read_text()
            assert code == -9 and "Traceback" not in log, log
            finished_frames(here, whole)
            # Killed before the first file is there, it has not begun
            begun = here.is_dir() and any(here.iterdir())
            died[kind if begun else "before the first file"] += 1
            resumed += begun
            options = ["--resume"] if begun else []
        assert_same_runs(folder, here)
        assert finished_frames(here, whole) == len(whole)
        assert {path.name for path in here.iterdir()} == {
            LIST, "checkpoint.npz", "run.vtkhdf", "paraview.vtkhdf", "scene.toml", "summary.json"}
        runs += 1
    print(f"{method}: {died.total()} kills, {resumed} resumed, {runs} runs that came to their end, all bitwise equal;"
          f" killed: {dict(died)}")
