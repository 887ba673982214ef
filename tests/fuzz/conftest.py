"""Commands on hostile files: they end in time, in little memory, with code 0 or 2 and a message of two lines."""

import contextlib
import io
import os
import signal

import pytest
import typer

from snowmpm import memory
from snowmpm.cli import check, info
from snowmpm.cli.errors import guarded

COMMANDS = {"check": guarded(check.check), "info": guarded(info.info)}

ROOM = 60 << 20  # bytes of memory that are said to be free
PATIENCE = 60  # s


@pytest.fixture(scope="module")
def ended_well(tmp_path_factory):
    """ended_well("check", path) -> exit code, after checking how the command ended and what it said."""

    def hang(*_):
        raise AssertionError(f"not done after {PATIENCE} s")

    def invoke(command, argument):
        code, out, err = 0, io.StringIO(), io.StringIO()
        signal.alarm(PATIENCE)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                COMMANDS[command](str(argument), debug=False)
            except typer.Exit as end:
                code = end.exit_code
            finally:
                signal.alarm(0)
        lines = err.getvalue().splitlines(keepends=True)
        message = "".join(line for line in lines if not line.startswith("warning: "))
        assert code in (0, 2), message
        if code == 2:
            assert message.startswith("error: ") and 1 <= message.count("\n") <= 2, message
            assert "Traceback" not in message and len(message) < 1500, message
        return code

    before, free = os.getcwd(), memory.available
    handler = signal.signal(signal.SIGALRM, hang)
    memory.available = lambda: ROOM
    os.chdir(tmp_path_factory.mktemp("fuzz"))
    yield invoke
    os.chdir(before)
    memory.available = free
    signal.signal(signal.SIGALRM, handler)
