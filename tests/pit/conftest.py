"""The command line, in this process."""

import pytest
from typer.testing import CliRunner

from snowmpm.cli.app import app


@pytest.fixture
def cli():
    """Call with the words of a command; -> `exit_code`, `output` (stdout and stderr), `stdout`."""
    return lambda *words: CliRunner().invoke(app, list(words))
