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




def row(seconds, commit="abc", failed="0"):
    return {"processor seconds": str(seconds), "commit": commit, "failed": failed}


def test_slow_tests_are_grouped_by_the_time_they_took():
    rows = {"long": row(5000), "a": row(2000), "b": row(1500), "c": row(1400), "d": row(100)}
    groups = script("slow_tests").grouped(["a", "b", "c", "d", "long", "new"], rows)
    assert sorted(groups) == [["a", "b", "d"], ["c"], ["long"], ["new"]]


@pytest.mark.parametrize(("found", "label", "counts"), [
    (row(1), "abc", True), (row(1), "abd", False), (row(1, failed="1"), "abc", False), (None, "abc", False),
    (row(1, commit="abc+"), "abc+", False)])
def test_slow_tests_count_as_passed_on_their_commit_only(found, label, counts):
    assert script("slow_tests").passed(found, label) is counts


def test_slow_tests_are_counted_by_file(tmp_path):
    report = tmp_path / "report.xml"
    report.write_text("""<testsuites><testsuite>
        <testcase file="a.py" time="1.5"/>
        <testcase file="a.py" time="2"><failure/></testcase>
        <testcase file="b.py" time="3"><skipped type="pytest.xfail"/></testcase>
        <testcase file="b.py" time="0"><skipped type="pytest.skip"/></testcase>
        <testcase file="b.py" time="1"><error/></testcase>
        </testsuite></testsuites>""")
    counts, times = script("slow_tests").counted(report)
    assert counts == {"a.py": {"passed": 1, "failed": 1}, "b.py": {"expected failures": 1, "skipped": 1, "failed": 1}}
    assert times == {"a.py": 3.5, "b.py": 4.0}
