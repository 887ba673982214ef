"""Pages of claims and of expected failures: made from their tables, which name tests that there are."""

import ast
import csv
import re
import runpy
import subprocess
import sys
from functools import cache

import pytest

from tests.support.project import ROOT

PROGRAM = ROOT / ".ci" / "claims.py"
MARKS = re.compile(r"mark\.xfail|pytest\.xfail")
NO_TESTS = {"tests/test_claims.py", "tests/test_ci.py", "tests/resume/test_soak.py",
            "tests/support/expected_failures.py", "tests/test_expected_failures.py"}
"""Files that speak of marks, or set one where a patch of the compiler is off."""


@pytest.fixture(scope="module")
def program():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PROGRAM.parent))
        return runpy.run_path(str(PROGRAM))


@cache
def functions(file):
    """Names of the tests of a file, those of classes with their class."""
    found = set()
    for node in ast.parse((ROOT / file).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.ClassDef):
            found |= {f"{node.name}::{one.name}" for one in node.body if isinstance(one, ast.FunctionDef)}
    return found


def missing(tests):
    return [test for test in tests if test.partition("::")[2] not in functions(test.partition("::")[0])]


def missed():
    with (ROOT / "tests" / "expected_failures.csv").open(newline="", encoding="utf-8") as stream:
        return [{**row, "tests": [test.strip() for test in row["tests"].split(";")]} for row in csv.DictReader(stream)]


def test_the_pages_are_what_the_tables_say():
    assert subprocess.run([sys.executable, PROGRAM, "--check"], cwd=ROOT, check=False).returncode == 0, \
        "python .ci/claims.py"


def test_claims_name_tests_that_there_are(program):
    assert missing(program["functions"](program["claims"]())) == []


def test_no_claim_rests_on_tests_that_fail_or_were_never_run(program):
    known = program["results"]()
    for section in program["claims"]():
        for claim in section["claim"]:
            results = [row["result"] for test in claim["tests"] for row in known.get(test, [])]
            assert "passed" in results and "failed" not in results, claim["says"]


def test_every_expected_failure_has_a_line():
    """By files with marks, and by the results of slow tests."""
    named = [test for row in missed() for test in row["tests"]]
    assert missing(named) == []
    files = {path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").rglob("*.py")
             if MARKS.search(path.read_text(encoding="utf-8"))} - NO_TESTS
    assert files - {test.partition("::")[0] for test in named} == set()
    with (ROOT / "tests" / "slow_tests.csv").open(newline="", encoding="utf-8") as stream:
        slow = {row["test"].partition("[")[0] for row in csv.DictReader(stream) if row["result"] == "expected failure"}
    there = {test for test in slow if not missing([test])}
    assert there - set(named) == set()


def test_lines_are_whole():
    for row in missed():
        assert row["gate"] and row["reached"] and row["cause"] and row["cure"], row["tests"]
        assert row["met by"] in ("users", "nobody", "control")
