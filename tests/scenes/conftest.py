"""The scene of the contract, as text and as a file."""

from pathlib import Path

import pytest

TEXT = Path(__file__).with_name("contract.toml").read_text()


@pytest.fixture
def scene_file(tmp_path):
    """A copy of the contract's example scene, in a folder of its own."""
    path = tmp_path / "scene.toml"
    path.write_text(TEXT)
    return path
