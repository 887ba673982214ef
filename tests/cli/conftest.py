"""A scene for tests of the command line."""

import shutil
from pathlib import Path

import pytest


@pytest.fixture
def block(tmp_path):
    """A scene of a few particles and steps."""
    return Path(shutil.copy(Path(__file__).with_name("block.toml"), tmp_path / "block.toml"))
