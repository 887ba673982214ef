"""One scene, run to its end and stopped in the middle; each once, for all tests."""

import signal
from pathlib import Path

import pytest

import snowmpm
from snowmpm.scenes import load_scene
from tests.support.same_runs import run_with_signal

IN_MIDDLE = 0.13
"""[s]: cut and load under way, the prop removed, between two frames."""


@pytest.fixture(scope="session")
def scene():
    return load_scene(Path(__file__).with_name("resumed.toml"))


@pytest.fixture(scope="session")
def changed(scene):
    """changed({"solver.dx": 0.05}) -> the scene with other values."""
    return lambda overrides: load_scene(scene.source, overrides)


@pytest.fixture(scope="session")
def whole(scene, tmp_path_factory):
    """Folder of a run that never stopped."""
    folder = tmp_path_factory.mktemp("whole")
    snowmpm.run(scene, folder)
    return folder


@pytest.fixture(scope="session")
def stopped(scene, tmp_path_factory):
    """Folder of a run that Ctrl-C stopped in the middle."""
    folder = tmp_path_factory.mktemp("stopped")
    with pytest.raises(KeyboardInterrupt, match=r"t = 0\.1.*checkpoint\.npz.*--resume"):
        run_with_signal(scene, folder, signal.SIGINT, IN_MIDDLE)
    return folder
