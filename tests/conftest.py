"""One Taichi for the whole test session; kernels are compiled once and shared."""

import pytest

from snowmpm import runtime


@pytest.fixture(scope="session", autouse=True)
def taichi():
    """Start Taichi on the CPU once; every test shares its compiled kernels."""
    runtime.start("cpu")
