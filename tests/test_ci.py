"""The scripts of CI that are more than a list of commands."""

import importlib.util
import os
import subprocess
import sys

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

from tests.support.project import PROJECT, ROOT


def script(name):
    spec = importlib.util.spec_from_file_location(f"ci_{name}", ROOT / ".ci" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_oldest_versions_are_the_bounds_of_the_project():
    oldest = dict(line.split("==") for line in script("oldest").constraints(PROJECT["project"], ["gis", "dev"]))
    extras = PROJECT["project"]["optional-dependencies"]
    declared = [Requirement(line) for line in [*PROJECT["project"]["dependencies"], *extras["gis"], *extras["dev"]]]
    declared = [requirement for requirement in declared if not requirement.marker or requirement.marker.evaluate()]
    assert oldest.keys() == {requirement.name for requirement in declared}  # each has a lower bound
    for requirement in declared:
        assert requirement.specifier.contains(Version(oldest[requirement.name])), requirement


def test_oldest_versions_of_other_projects():
    project = {"dependencies": ["a>=1.2,<3", "b", "c~=2.0; python_version < '3'", "A_b[x]>=4"],
               "optional-dependencies": {"more": ["a>=1.10", "d==7"], "other": ["e>=1"]}}
    constraints = script("oldest").constraints
    assert constraints(project) == ["A_b==4", "a==1.2"]
    assert constraints(project, ["more"]) == ["A_b==4", "a==1.10", "d==7"]
    with pytest.raises(KeyError):
        constraints(project, ["none"])


CLEAN, BAD = {"name": "a", "version": "1", "vulns": []}, {"name": "b", "version": "2", "vulns": [
    {"id": "PYSEC-1", "fix_versions": ["2.1"]}, {"id": "PYSEC-2", "fix_versions": []}]}
OWN, NOT_FOUND = {"name": "snowmpm", "skip_reason": "not on PyPI"}, {"name": "c", "skip_reason": "not found"}


@pytest.mark.parametrize(("packages", "code", "words"), [
    ([CLEAN, OWN], 0, "no known vulnerability in 1 packages"),
    ([CLEAN, BAD, NOT_FOUND], 1, "b 2: PYSEC-1, mended in 2.1\nb 2: PYSEC-2, not mended yet"),
    ([CLEAN, NOT_FOUND], 3, "skipped: vulnerability data could be had for 1 of 2 packages"),
    (None, 3, "skipped: vulnerability data could be had for 0 of 0 packages")])
def test_verdict_of_an_audit(packages, code, words):
    """What could not be looked up is never called clean."""
    report = None if packages is None else {"dependencies": packages}
    found, lines = script("audit").verdict(report)
    assert (found, "\n".join(lines)) == (code, words)


@pytest.mark.skipif(sys.platform == "win32", reason="needs bash")
def test_the_slow_part_says_what_it_skips():
    run = [str(ROOT / ".ci" / "slow"), "oldest", "pythons", "audit", "slow"]
    done = subprocess.run(run, capture_output=True, text=True, timeout=60,
                          env={**os.environ, "PYTHONPATH": "", "PYTHONS": "python-that-is-not-there"})
    assert done.returncode == 0, done.stderr
    assert "skipped python-that-is-not-there: not installed" in done.stdout
    assert done.stdout.count("no Python") == 3
    done = subprocess.run([run[0], "fast"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (2, "no part fast: oldest, pythons, audit, slow\n")


@pytest.fixture
def slow(monkeypatch):
    """The modules of the slow tests: the runner and its table."""
    monkeypatch.syspath_prepend(ROOT / ".ci")
    return importlib.import_module("slow_tests"), importlib.import_module("slow_table")


def row(commit="abc", result="passed", date="2026-01-31"):
    return {"processor seconds": "1", "commit": commit, "result": result, "date": date}


def test_slow_tests_are_grouped_by_the_time_they_took(slow):
    groups = slow[0].grouped({"long": 5000, "a": 2000, "b": 1500, "c": 1400, "d": 100, "new": 0})
    assert sorted(groups) == [["a", "b", "d"], ["c", "new"], ["long"]]


@pytest.mark.parametrize(("found", "label", "counts"), [
    (row(), "abc", True), (row(result="expected failure"), "abc", True), (row(), "abd", False),
    (row(result="failed"), "abc", False), (None, "abc", False), (row(commit="abc+"), "abc+", False)])
def test_slow_tests_count_as_shown_on_their_commit_only(slow, found, label, counts):
    assert slow[1].shown(found, label) is counts


def test_what_was_shown_lately_need_not_run_again(slow):
    for found, left in ((row(), True), (row(date="2026-01-01"), False), (row(result="failed"), False), (None, False),
                        (row(commit="abc+"), False)):
        assert slow[1].done(found, "abd", "2026-02-05", "missing") is left
        assert not slow[1].done(found, "abd", "2026-02-05", "again")


def test_old_rows_and_failures_and_gaps_of_the_table_are_told(slow):
    rows = {"a": row(), "b": row(date="2026-01-29"), "c": row(result="failed")}
    assert slow[0].verdict(["a", "b", "c", "d"], rows, "2026-03-01") == [
        "b: shown 31 days before, at most 30", "c: failed on abc", "d: never run"]


@pytest.mark.parametrize(("text", "short"), [
    ("AssertionError: assert np.float64(0.0123456789) < 0.02\n  where", "0.012346 < 0.02"), ("", ""),
    ("assert 1.5 == 1.0 ± 2.0e-02", "1.5 == 1.0 ± 2.0e-02"),
    ("assert 2 in 'block (/srv/a-1/block.toml)'", "2 in 'block (block.toml)'"),
    ("assert 3 / 4 < 1.5 kg/m3 of m/s/m", "3 / 4 < 1.5 kg/m3 of m/s/m")])
def test_figures_of_slow_tests_are_short(slow, text, short):
    assert slow[1].figure(text) == short


@pytest.mark.parametrize("workers", [0, 2])
def test_the_table_of_slow_tests_is_filled_as_they_run(slow, tmp_path, workers):
    """A passing, a failing, a skipped test and an expected failure: results, figures, and each row at once."""
    (tmp_path / "test_it.py").write_text("""
import pytest
def test_good():
    error = 0.25
    assert error < 0.5
    assert "words"
def test_bad(): assert 0.75 < 0.5
@pytest.mark.xfail(strict=True)
def test_expected(): assert 2 == 1
@pytest.mark.skipif(True, reason="no data")
def test_left_out(): pass
""")
    plugin = tmp_path / "filler.py"
    plugin.write_text(f"""
import sys
sys.path.insert(0, {str(ROOT / '.ci')!r})
import slow_table
from pathlib import Path
slow_table.commit = lambda: ("abc", "2026-01-31")
slow_table.read.__defaults__ = slow_table.write.__defaults__ = (Path("table.csv"),)
from slow_table import *
""")
    words = [sys.executable, "-m", "pytest", "-q", "-p", "filler", "-o", "enable_assertion_pass_hook=true",
             "-p", "no:cacheprovider", "-n", str(workers), "test_it.py"]
    subprocess.run(words, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)}, timeout=120)
    rows = slow[1].read(tmp_path / "table.csv")
    assert {test.split("::")[1]: (found["result"], found["figure"]) for test, found in rows.items()} == {
        "test_good": ("passed", "0.25 < 0.5"), "test_bad": ("failed", "0.75 < 0.5"),
        "test_expected": ("expected failure", "2 == 1"), "test_left_out": ("skipped", "Skipped: no data")}
    assert rows["test_it.py::test_good"]["commit"] == "abc"
    again = subprocess.run(words, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)}, timeout=120,
                           capture_output=True, text=True)
    assert "1 failed" in again.stdout and "passed" not in again.stdout
