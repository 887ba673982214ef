"""Ctrl-C, SIGTERM and the end of a terminal, in the middle of any command: exit code 130, one line, no half file."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import imageio_ffmpeg
import pytest
import typer

import snowmpm
from snowmpm.cli.errors import guarded
from snowmpm.draft import draft
from snowmpm.running.interruption import Interruption
from tests.support.usual_signals import HANDLERS, usual_signals

HERE = Path(__file__).parent
RUN = ["run", str(HERE.parent / "resume" / "killed.toml"), "--backend", "cpu", "--threads", "1", "--set", "end_time=9"]
KILLED = {"mpm": RUN, "sph": [*RUN, "--set", "solver.method=sph"],
          "settling": [*RUN, "--set", "bodies.0.velocity=[0.0,0.0]", "--set", "initial.stress=settle", "--set",
                       "initial.tolerance=1e-9", "--set", "solver.dx=0.04"]}  # so fine that it settles for a minute


@pytest.fixture(autouse=True)
def foreground():
    with usual_signals():
        yield


@pytest.mark.parametrize("number", HANDLERS)
def test_a_command_takes_back_what_it_began(tmp_path, capsys, number):
    def command():
        with draft(tmp_path / "film.mp4") as part:
            part.touch()
            signal.raise_signal(number)

    before = signal.getsignal(number)
    with pytest.raises(typer.Exit) as end:
        guarded(command)(debug=False)
    assert end.value.exit_code == 130 and capsys.readouterr().err == "interrupted\n"
    assert not list(tmp_path.iterdir()) and signal.getsignal(number) is before


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_one_that_python_forgets_ends_a_run_where_it_begins():
    class Finalised:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    def command():
        Finalised()
        with Interruption() as interruption:
            assert interruption.asked

    guarded(command)(debug=False)
    with Interruption() as interruption:
        assert not interruption.asked


PROGRAM = """
import signal, sys, typer
from snowmpm.cli.errors import guarded
try:
    guarded(lambda: exec("signal.raise_signal(signal.SIGINT)"))(debug=False)
except typer.Exit as end:
    sys.exit(end.exit_code)
"""


def test_ctrl_c_while_a_text_is_executed(tmp_path):
    """A module that Python was told to run ends by SIGINT then, whatever code it ends with."""
    (tmp_path / "program.py").write_text(PROGRAM)
    path = os.pathsep.join([str(tmp_path), str(HERE.parents[1])])
    done = subprocess.run([sys.executable, "-m", "program"], capture_output=True, check=False,
                          env={**os.environ, "PYTHONPATH": path})
    assert (done.returncode, done.stderr) == (130, b"interrupted\n")


@pytest.fixture(scope="module")
def commands(tmp_path_factory):
    """Command lines by name, without their -o, and how the output is called."""
    folder = tmp_path_factory.mktemp("runs")
    for name in ("killed", "ball"):
        snowmpm.run(snowmpm.load_scene(HERE.parent / "resume" / f"{name}.toml"), folder / name)
    draws = {"film": ["render", str(folder / "killed")], "page": ["report", str(folder / "killed")],
             "maps": ["maps", str(folder / "ball")]}
    return {name: (line, {"film": "f.mp4", "page": "p.html"}.get(name, "")) for name, line in (KILLED | draws).items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", [*KILLED, "film", "page", "maps"])
def test_at_any_moment(commands, tmp_path, name):
    line, file = commands[name]
    dice = random.Random(name)
    for i in range(6):
        out, number = tmp_path / str(i), dice.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
        process = subprocess.Popen([sys.executable, "-m", "snowmpm", *line, "-o", str(out / file)], text=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)
        time.sleep(dice.uniform(2.0, 14.0))
        os.kill(process.pid, number)
        message = process.communicate(timeout=300)[1]
        told = (" so far", " left", " of what is allowed")  # every ten seconds
        lines = [text for text in message.splitlines() if not text.startswith("warning: ") and not text.endswith(told)]
        if process.returncode == 0:  # it was done
            continue
        assert process.returncode == 130, message
        assert lines and lines[0].startswith("interrupted"), message
        assert len(lines) <= 1 + (line[0] == "run"), message
        assert all(text.startswith(f"snowmpm run {line[1]} -o {out} --resume") for text in lines[1:]), message
        files = [path for path in out.rglob("*") if path.is_file()] if out.exists() else []
        kept = out / "f.unfinished.mp4"
        if kept in files:  # of a film, what can be played
            files.remove(kept)
            assert name == "film" and str(kept) in message and imageio_ffmpeg.count_frames_and_secs(str(kept))[0]
        assert not any("unfinished" in path.name or path.name.endswith((".part", ".journal")) for path in files)
        if out / "run.vtkhdf" in files:
            assert "checkpoint.npz" in message and len(snowmpm.Run(out)) >= 1
