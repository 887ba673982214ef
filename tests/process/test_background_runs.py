"""Started in the background of a shell, which lets its jobs ignore Ctrl-C, or by nohup, which ignores a hang-up."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import snowmpm
from snowmpm.errors import InputError
from tests.support.usual_signals import usual_signals

TESTS = Path(__file__).parents[1]
SCENE = TESTS / "resume" / "killed.toml"
LIMIT = 600
"""[s] within which a run writes its next frame, or ends, on any machine."""

pytestmark = pytest.mark.skipif(shutil.which("sh") is None, reason="needs a shell")


def in_background(*arguments, **options):
    """Process of Python that was told to ignore Ctrl-C and hang-ups before it began."""
    with usual_signals():
        return subprocess.Popen(["sh", "-c", 'trap "" INT HUP; exec "$@"', "sh", sys.executable, *map(str, arguments)],
                                text=True, start_new_session=True, **options)


def wait_until(condition, process):
    end = time.monotonic() + LIMIT
    while not condition():
        assert process.poll() is None and time.monotonic() < end, process.poll()
        time.sleep(0.05)


def frames(folder):
    with contextlib.suppress(InputError):  # it has hardly begun
        return len(snowmpm.Run(folder))
    return 0


@pytest.mark.slow
def test_what_is_ignored_stays_ignored_and_sigterm_writes_a_checkpoint(tmp_path):
    process = in_background("-m", "snowmpm", "run", SCENE, "-o", tmp_path, "--backend", "cpu", "--threads", "1",
                            "--set", "end_time=1000", stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    try:
        wait_until(lambda: frames(tmp_path) > 1, process)
        for number in (signal.SIGINT, signal.SIGHUP):
            before = frames(tmp_path)
            os.kill(process.pid, number)
            wait_until(lambda known=before: frames(tmp_path) > known + 1, process)
        process.terminate()
        message = process.communicate(timeout=LIMIT)[1]
    finally:
        process.kill()
    assert process.returncode == 130
    last, command = message.splitlines()[-2:]  # after the lines of its progress
    assert last.startswith("interrupted at t = ") and "checkpoint.npz" in last and "Traceback" not in message
    assert command == f"snowmpm run {SCENE} -o {tmp_path} --resume --backend cpu --threads 1"
    assert (tmp_path / "checkpoint.npz").exists() and not snowmpm.Run(tmp_path).complete


ONE = ["cli/test_signals.py::test_ctrl_c_while_a_text_is_executed"]
MORE = ["resume/test_resumed_runs.py::test_resumed_in_the_middle_of_events",
        "resume/test_resumed_runs.py::test_second_signal_gets_through",
        "cli/test_signals.py::test_a_command_takes_back_what_it_began"]


@pytest.mark.slow
@pytest.mark.parametrize(("chosen", "count"), [
    pytest.param(ONE, 1, id="one"), pytest.param(MORE, 5, id="more")])
def test_the_tests_of_signals_themselves(chosen, count):
    """They bring the handlers of a program in the foreground."""
    process = in_background("-m", "pytest", "-q", "-p", "no:cacheprovider", *(TESTS / name for name in chosen),
                            cwd=TESTS.parent, stdout=subprocess.PIPE)
    said = process.communicate(timeout=2 * LIMIT)[0]
    assert process.returncode == 0 and f"{count} passed" in said, said
