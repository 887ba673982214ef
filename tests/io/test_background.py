"""The thread that writes: the solver goes on meanwhile, waits where the disk is slower, and learns what failed."""

import gc
import threading
import weakref
from pathlib import Path
from time import sleep

import pytest

import snowmpm
from snowmpm.io import Background, RunWriter
from snowmpm.io.background import ROOM
from snowmpm.running.recorder import Recorder
from snowmpm.scenes import load_scene

FRAMES = 8
BLOCK = Path(__file__).parents[1] / "cli" / "block.toml"


@pytest.fixture
def block():
    return load_scene(BLOCK, {"output.interval": 0.02 / FRAMES})


def test_a_solver_goes_on_while_a_frame_is_written(block, tmp_path, monkeypatch):
    """Each frame but the last reaches the disk only after the solver has made a step beyond it."""
    write, step, now = RunWriter.frame, snowmpm.Simulation.step, threading.Condition()
    state = {"time": 0.0}

    def stepping(self, until=None):
        step(self, until)
        with now:
            state["time"] = self.time
            now.notify()

    def patient_write(self, time, *frame):
        with now:
            assert time == 0.02 or now.wait_for(lambda: state["time"] > time, timeout=60.0), "the solver waits"
        write(self, time, *frame)

    monkeypatch.setattr(RunWriter, "frame", patient_write)
    monkeypatch.setattr(snowmpm.Simulation, "step", stepping)
    assert len(snowmpm.run(block, tmp_path)) == FRAMES + 1


def test_a_disk_slower_than_the_solver_holds_it_back(block, tmp_path, monkeypatch):
    """It is at most as many frames ahead as there is room for."""
    write, take, taken, written, ahead = RunWriter.frame, Recorder.frame, [], [], []

    def taking(self):
        taken.append(1)
        take(self)

    def slow_write(self, time, *frame):
        sleep(0.03)
        write(self, time, *frame)
        written.append(time)
        ahead.append(len(taken) - len(written))

    monkeypatch.setattr(RunWriter, "frame", slow_write)
    monkeypatch.setattr(Recorder, "frame", taking)
    assert len(snowmpm.run(block, tmp_path)) == FRAMES + 1
    assert max(ahead) <= ROOM + 1


class Copy:
    """Of the particles."""


def test_no_more_copies_than_there_is_room_for():
    gate, alive, most = threading.Event(), weakref.WeakSet(), 0
    background = Background()

    def hand_over():
        nonlocal most
        for _ in range(8):
            copy = Copy()
            alive.add(copy)
            most = max(most, len(alive))
            background.do(lambda copy=copy: gate.wait())
            del copy

    solver = threading.Thread(target=hand_over)
    solver.start()
    sleep(0.3)
    assert solver.is_alive()  # it waits
    gc.collect()
    assert len(alive) == ROOM + 2  # in work, waiting, and about to be handed over
    gate.set()
    solver.join(timeout=5.0)
    background.close()
    assert most <= ROOM + 3 and not alive


def test_after_a_failure_nothing_more_is_written():
    done, background = [], Background()

    def full():
        raise OSError(28, "No space left on device")

    background.do(lambda: done.append(1))
    background.do(full)
    with pytest.raises(OSError, match="No space left"):
        for i in range(100):
            background.do(lambda i=i: done.append(i))
            sleep(0.01)
    with pytest.raises(OSError, match="No space left"):
        background.close()
    assert done == [1]


def test_what_is_left_for_later_is_finished():
    """Before a job that asks for it, before `wait` returns, and when no job comes any more."""
    done = []
    background = Background(lambda: done.append("rest"))
    background.do(lambda: done.append(1))
    background.do(lambda: done.append(2), finished=True)
    background.wait()
    assert done == [1, "rest", 2, "rest"]
    background.do(lambda: done.append(3))
    for _ in range(100):
        sleep(0.1)
        if done[-1] == "rest":
            break
    assert done[4:] == [3, "rest"]
    background.close()
    assert done[6:] == ["rest"]
