"""Progress of every command: stages of the work, a bar on a terminal, lines elsewhere, nothing for what is short."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import snowmpm
from snowmpm.cli.watch import sentence, sentences, watched
from snowmpm.errors import SimulationError
from snowmpm.io import RunWriter
from snowmpm.stages import Stage, counted, stage, stages
from snowmpm.stepping import settling


class At(Stage):
    """A stage that has taken so many seconds."""

    seconds = 0.0


def at(what, done, total, seconds, unit="pictures", detail=""):
    now = At(what, total, unit)
    now.done, now.detail, now.seconds = done, detail, seconds
    return now


def test_stages_nest_and_end_also_by_an_error():
    with stage("whole"):
        with contextlib.suppress(ValueError), stage("part", 3):
            assert [now.what for now in stages()] == ["whole", "part"]
            raise ValueError
        assert [now.what for now in stages()] == ["whole"]
        seen = []
        for letter in counted("abc", "letters", "letters"):
            seen.append((letter, stages()[-1].done, stages()[-1].total))
        assert seen == [("a", 0, 3), ("b", 1, 3), ("c", 2, 3)]
    assert stages() == ()


def test_a_loop_that_is_left_ends_its_stage():
    def first():
        for letter in counted("abc", "letters"):
            return letter

    assert first() == "a" and stages() == ()


@pytest.mark.parametrize("now, words", [
    (at("drawing", 30, 120, 40.0), "drawing: 30 of 120 pictures (25 %), 2 min 00 s left"),
    (at("drawing", 0, 120, 40.0), "drawing: 0 of 120 pictures (0 %), 40 s so far"),
    (at("settling", 3000, None, 75.0, "steps", "speed 2 of what is allowed"),
     "settling: 3 000 steps, 1 min 15 s so far, speed 2 of what is allowed"),
    (at("reading the terrain", 0, None, 12.0, ""), "reading the terrain: 12 s so far"),
])
def test_a_stage_in_words(now, words):
    assert sentence(now) == words


def test_whole_and_part_in_one_line():
    line = sentences([at("gallery", 1, 4, 60.0, "scenes"), at("drawing", 0, 3, 12.0)])
    assert line == "gallery: 1 of 4 scenes (25 %), 3 min 00 s left; drawing: 0 of 3 pictures (0 %), 12 s so far"


def test_lines_off_a_terminal(capsys):
    with watched(interval=0.2):
        for _ in counted(range(6), "drawing", "pictures"):
            time.sleep(0.15)
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) <= 6 and all(line.startswith("drawing: ") and "of 6 pictures" in line for line in lines)
    assert "left" in lines[-1]


@pytest.mark.parametrize("choice", [{"quiet": True, "interval": 0.05}, {}])
def test_nothing_when_quiet_and_nothing_of_what_is_short(capsys, choice):
    with watched(**choice), stage("work"):
        time.sleep(0.3)
    assert capsys.readouterr().err == ""


def test_work_that_never_reports_is_seen_too(capsys):
    """A kernel that compiles, a library that reads."""
    with watched(interval=0.2), stage("distances to the terrain"):
        time.sleep(0.7)
    assert "distances to the terrain: 0." in capsys.readouterr().err


SCRIPT = """
import sys, time
from snowmpm.cli import watch
from snowmpm.stages import counted
watch.PATIENCE = 0.1
with watch.watched():
    for i in counted(range(8), "drawing", "pictures"):
        time.sleep(0.4)
        if i == 4:
            print("runs/one.tif")
print("runs/film.mp4")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_bar_on_a_terminal_that_is_gone_at_the_end():
    import pty

    master, slave = pty.openpty()
    process = subprocess.Popen([sys.executable, "-c", SCRIPT], stdout=slave, stderr=slave, stdin=slave,
                               env={**os.environ, "TERM": "xterm", "COLUMNS": "120"})
    os.close(slave)
    shown = b""
    with contextlib.suppress(OSError):  # the other end is closed
        while more := os.read(master, 65536):
            shown += more
    os.close(master)
    assert process.wait(timeout=60) == 0
    text = shown.decode()
    assert "drawing" in text and "of 8 pictures" in text and "left" in text
    left = [line.rsplit("\x1b[2K", 1)[-1].strip() for line in text.split("\n")]  # of each line, after the bar was wiped
    assert "runs/one.tif" in left and left[-2:] == ["runs/film.mp4", ""]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folders of a run, and of one with a map."""
    folder = tmp_path_factory.mktemp("made")
    snowmpm.run(snowmpm.load_scene(Path(__file__).with_name("block.toml")), folder / "block")
    with RunWriter(folder / "mapped", provenance={}) as writer:
        writer.map("peak_depth", np.ones((4, 5)), 0.0, 0.0, 1.0, "m")
    return folder


COMMANDS = {"render": "drawing", "check": "filling bodies with particles", "maps": "drawing maps",
            "report": "writing the report", "plot": "drawing", "compare": "measuring", "element": "measuring oedometer",
            "run": "the first step"}


@pytest.mark.parametrize("command", COMMANDS)
def test_long_commands_say_what_they_are_at(call, command, block, made, monkeypatch):
    arguments = {"render": [made / "block", "-o", "f.mp4", "--size", "320x180"], "check": [block], "run": [block],
                 "maps": [made / "mapped", "--files", "pictures"],
                 "report": [made / "block", "-o", "r.html", "--still"],
                 "plot": [made / "block", "-o", "p.png"], "compare": [made / "block", made / "block"],
                 "element": ["oedometer", "--material", "li_cold_dense", "--steps", "20"]}[command]
    begun, begin = [], Stage.__init__

    def noted(self, what, *others):
        begun.append(what)
        begin(self, what, *others)

    monkeypatch.setattr(Stage, "__init__", noted)
    result = call(command, *arguments)
    assert result.code == 0, result.err
    assert any(what.startswith(COMMANDS[command]) for what in begun), begun
    assert stages() == ()


def test_settling_tells_how_far_it_is(block, monkeypatch):
    shown, window = [], settling._window

    def watched_window(solver):
        shown.append(sentences(stages()))
        return window(solver)

    monkeypatch.setattr(settling, "_window", watched_window)
    scene = snowmpm.load_scene(block, {"initial.stress": "settle", "initial.tolerance": 0.05,
                                       "bodies.0.velocity": [0.0, 0.0]})
    with contextlib.suppress(SimulationError):  # of a body in the air
        snowmpm.Simulation(scene)
    assert shown[0].startswith("settling to rest: ") and "100 steps" in shown[2] and "of what is allowed" in shown[2]
