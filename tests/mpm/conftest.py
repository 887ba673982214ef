"""The block of `tests.support.mpm_block`, as a fixture."""

import pytest

from tests.support.mpm_block import mpm_block


@pytest.fixture(scope="session")
def make_solver():
    return mpm_block
