"""One Taichi for the whole test session; kernels are compiled once and shared."""

import pytest

from snowmpm.cli import watch
from snowmpm.compiler import runtime


@pytest.fixture(scope="session", autouse=True)
def taichi():
    """Start Taichi on the CPU once; every test shares its compiled kernels."""
    runtime.start("cpu")


@pytest.fixture(scope="session", autouse=True)
def no_lines_of_progress():
    """A busy machine takes its time: what stderr must say would stand between lines of progress."""
    usual, watch.LINE_INTERVAL = watch.LINE_INTERVAL, 1e9
    yield
    watch.LINE_INTERVAL = usual
