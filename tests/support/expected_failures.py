"""Expected failures are missed gates: a crash, or a fixture that fails, is none of them."""

import pytest


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(item, call):
    """Of pytest: fail a test that is expected to fail where something other than an assertion did."""
    report = yield
    missed = call.excinfo is None or call.excinfo.errisinstance((AssertionError, pytest.xfail.Exception))
    if report.skipped and "wasxfail" in vars(report) and not missed:
        report.outcome = "failed"
        del report.wasxfail
    return report
