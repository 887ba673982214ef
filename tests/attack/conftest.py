"""Commands on hostile input: each in a process of its own with limits, forked from one that has all modules loaded."""

import json
import os
import re
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import pytest

PROCESSOR = 20  # s that a command may take on any of these inputs, most of it to start Taichi
WALL = 240  # s: of a machine that has other things to do
ADDRESSES = 6 << 30  # bytes of address space; Taichi alone reserves two GiB
RESIDENT = 500 << 20  # bytes that a command may take beside the program itself
READ_GIB = "0.25"  # what reading a file may take
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


@dataclass
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str
    processor: float
    memory: int

    @property
    def message(self):
        """What it said on stderr, but for warnings and how far it is."""
        return "".join(line for line in self.err.splitlines(keepends=True)
                       if not line.startswith("warning: ") and not line.endswith((" so far\n", " left\n")))


class WarmProgram:
    """The process that commands are forked from."""

    def __init__(self, output):
        self.output = output
        environment = {**os.environ, "SNOWMPM_READ_GIB": READ_GIB, "MPLBACKEND": "agg", "OMP_NUM_THREADS": "1"}
        self._process = subprocess.Popen([sys.executable, str(Path(__file__).with_name("warm_program.py"))],
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        self.memory = json.loads(self._process.stdout.readline())["memory"]

    def run(self, folder, *arguments, processor=PROCESSOR, environment=None):
        """A command line as it ended, whatever that was."""
        request = {"arguments": [str(a) for a in arguments], "folder": str(folder), "output": str(self.output),
                   "processor": processor, "wall": WALL, "memory": ADDRESSES, "environment": environment or {}}
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        answer = json.loads(self._process.stdout.readline())
        out, err = ((self.output / name).read_text(encoding="utf-8", errors="replace") for name in ("out", "err"))
        assert answer["in_time"], f"not done after {WALL} s: {arguments}\n{err[-2000:]}"
        return Ended(answer["code"], out, err, answer["processor"], answer["memory"])

    def close(self):
        self._process.stdin.close()
        self._process.wait(60)


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    warm = WarmProgram(tmp_path_factory.mktemp("said"))
    yield warm
    warm.close()


@pytest.fixture
def withstood(program, tmp_path):
    """withstood("check", "scene.toml") -> `Ended`, after checking that the command ended as it must on any input.

    Exit code 0 or 2, or the one asked for; a message of one to three lines that can be shown; bounded time and memory.
    """

    def invoke(*arguments, code=(0, 2), folder=tmp_path, **options):
        ended = program.run(folder, *arguments, **options)
        assert ended.code in (code if isinstance(code, tuple) else (code,)), (ended.code, ended.out[-500:],
                                                                              ended.err[-3000:])
        assert "Traceback" not in ended.err and "a fault of the program" not in ended.err, ended.err[-3000:]
        if ended.code == 2:
            assert ended.message.startswith("error: "), ended.err[-3000:]
            assert 1 <= ended.message.count("\n") <= 3, ended.err[-3000:]
            assert len(ended.message) < 3200, ended.err[:4000]
        assert len(ended.err) < 200_000
        assert not CONTROL.search(ended.out + ended.err), repr(CONTROL.search(ended.out + ended.err))
        assert ended.memory < program.memory + RESIDENT, f"{ended.memory >> 20} MiB"
        return ended

    return invoke


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Every third case of a file in the quick part of the tests, all of them in the slow one.

    Counted in each file, so that a run of some files has the same slow tests as a run of all.
    """
    seen = Counter()
    for item in items:
        if Path(__file__).parent in item.path.parents:
            if seen[item.path] % 3:
                item.add_marker(pytest.mark.slow)
            seen[item.path] += 1
