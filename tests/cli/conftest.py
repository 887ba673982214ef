"""The command line, called in this process: a subprocess costs a second each."""

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from snowmpm.cli.app import app


@dataclass
class Result:
    code: int
    out: str
    err: str


@pytest.fixture
def call(capsys, tmp_path, monkeypatch):
    """call("run", "scene.toml") -> Result, in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments):
        capsys.readouterr()
        try:
            app([str(argument) for argument in arguments])
            code = 0
        except SystemExit as end:
            code = end.code or 0
        output = capsys.readouterr()
        return Result(code, output.out, output.err)

    return invoke


@pytest.fixture
def block(tmp_path):
    """A scene of a few particles and steps."""
    return Path(shutil.copy(Path(__file__).with_name("block.toml"), tmp_path / "block.toml"))
