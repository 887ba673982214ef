"""A crash is no missed gate (`tests/support/expected_failures.py`)."""

import subprocess
import sys

from tests.support.project import ROOT

TESTS = """
import pytest
missed = pytest.mark.xfail(strict=True, reason="a gate")

@pytest.fixture
def broken():
    raise OSError

@missed
def test_gate():
    assert False

@missed
def test_crash():
    1 / 0

@missed
def test_fixture(broken):
    pass

@missed
def test_met():
    pass
"""


def test_only_assertions_are_expected_to_fail(tmp_path):
    (tmp_path / "conftest.py").write_text(f"import sys\nsys.path.insert(0, {str(ROOT)!r})\n"
                                          "from tests.support.expected_failures import pytest_runtest_makereport\n")
    (tmp_path / "test_some.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rfEx", "-c", "/dev/null", "."]
    told = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path).stdout
    found = {line.split("::")[1].split()[0]: line.split()[0] for line in told.splitlines()
             if line.startswith(("FAILED", "ERROR", "XFAIL"))}
    assert found == {"test_gate": "XFAIL", "test_crash": "FAILED", "test_fixture": "ERROR", "test_met": "FAILED"}
