"""The table of the slow tests, and the plugin of pytest that fills it: `.ci/slow_tests.py` loads it by `-p slow_table`.

A row for each test: result, figure, processor time, commit and its date. The figure is the last comparison of numbers
that the test made, with the numbers in place of the names. The table is written anew after each test, so that a run
that is cut off keeps what it has shown.
"""

import csv
import datetime
import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / os.environ.get("TABLE_OF_TESTS", "tests/slow_tests.csv")
COLUMNS = ("test", "result", "figure", "processor seconds", "commit", "date")
SHOWN = ("passed", "expected failure", "skipped")
"""Results that need no second run on the same commit."""
OLDEST = 30
"""Days that a row may be older than the commit that is checked out."""
LONGEST = 100
"""Characters of a figure that are kept."""
FOLDERS = re.compile(r"(?<![\w./)])/(?:[\w.+-]+/)+")
"""Folders of an absolute path: they differ from machine to machine."""
COMPARISON = re.compile(r"\d.* (<|<=|==|>|>=) .*\d|\d (<|<=|==|>|>=) .*\d")


def commit():
    """The commit that is checked out, with a + where files that it holds have changed, and its date."""
    def git(*words):
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", f":!{TABLE.relative_to(ROOT)}")
    return git("rev-parse", "--short=10", "HEAD") + ("+" if changed else ""), git("log", "-1", "--format=%cs")


def read(table=TABLE):
    """Rows of the table by test."""
    if not table.exists():
        return {}
    with table.open(newline="", encoding="utf-8") as stream:
        return {row["test"]: row for row in csv.DictReader(stream)}


def write(rows, table=TABLE):
    """The table, sorted by test; the old one stays until the new one is whole."""
    part = table.with_suffix(".part")
    with part.open("w", newline="", encoding="utf-8") as stream:
        sheet = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        sheet.writeheader()
        sheet.writerows(rows[test] for test in sorted(rows))
    os.replace(part, table)


def shown(row, label):
    """Whether a row says that its test needs no further run on this commit; never for a tree with changes."""
    return bool(row) and row["commit"] == label and not label.endswith("+") and row["result"] in SHOWN


def days(row, date):
    """Days from the commit of a row to a date."""
    return (datetime.date.fromisoformat(date) - datetime.date.fromisoformat(row["date"])).days


def recent(row, date):
    """Whether a row has shown its test, on a commit at most OLDEST days before a date."""
    return bool(row) and shown(row, row["commit"]) and days(row, date) <= OLDEST


def done(row, label, date, which):
    """Whether a test need not be run: "commit": shown on this commit; "missing": shown lately; "again": never."""
    return {"commit": shown(row, label), "missing": recent(row, date), "again": False}[which]


def seconds(row):
    """Processor time of a row [s], 0 where there is none."""
    return float(row["processor seconds"]) if row else 0.0


def figure(text):
    """The first line of an explained comparison, short: 'assert np.float64(0.5) < 1' -> '0.5 < 1'; of an absolute path
    only the name of the file."""
    line = FOLDERS.sub("", text.strip().splitlines()[0] if text.strip() else "")
    line = re.sub(r"np\.\w+\(([^()]*)\)", r"\1", line.removeprefix("AssertionError: ").removeprefix("assert "))
    line = re.sub(r"\d+\.\d{5,}(e[-+]?\d+)?", lambda found: f"{float(found[0]):.5g}", line)
    return line if len(line) <= LONGEST else line[:LONGEST - 1] + "…"


def processor_time():
    """Processor time of this process and of its children that ended [s]."""
    return sum(os.times()[:4])


class Teller:
    """Where tests run, in each worker or in the only process: leaves out what the table has shown (`done`), and adds to
    the reports what was compared and what it took."""

    def __init__(self, which):
        self.which, self.compared, self.before = which, "", 0.0

    def pytest_collection_modifyitems(self, config, items):
        rows, (label, date) = read(), commit()
        left = [done(rows.get(item.nodeid), label, date, self.which) for item in items]
        config.hook.pytest_deselected(items=[item for item, out in zip(items, left, strict=True) if out])
        items[:] = [item for item, out in zip(items, left, strict=True) if not out]

    def pytest_runtest_logstart(self):
        self.compared, self.before = "", processor_time()

    def pytest_assertion_pass(self, expl):
        if COMPARISON.search(expl.splitlines()[0] if expl else ""):
            self.compared = expl

    def pytest_runtest_teardown(self, item):
        item.user_properties.append(("compared", figure(self.compared)))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        report = yield
        report.user_properties = [*report.user_properties, ("took", processor_time() - self.before)]
        return report


class Filler:
    """Fills the table from the reports, where they arrive."""

    def __init__(self):
        self.label, self.date = commit()
        self.rows = read()
        self.reports = {}

    def pytest_runtest_logreport(self, report):
        self.reports.setdefault(report.nodeid, []).append(report)
        if report.when == "teardown":
            self.rows[report.nodeid] = self.row(report.nodeid, self.reports.pop(report.nodeid))
            write(self.rows)

    def row(self, test, reports):
        """A row of the table from the reports of set-up, call and teardown."""
        properties = dict(reports[-1].user_properties)
        result, compared = "passed", properties.get("compared", "")
        for report in reports:
            if report.outcome != "passed":
                crash = getattr(report.longrepr, "reprcrash", None)
                compared = crash.message if crash else str((report.longrepr or ("",))[-1])
            if report.failed:
                result = "failed"
            elif report.skipped and result == "passed":
                result = "expected failure" if hasattr(report, "wasxfail") else "skipped"
        return {"test": test, "result": result, "figure": figure(compared), "commit": self.label, "date": self.date,
                "processor seconds": f"{properties.get('took', 0.0):.1f}"}


def pytest_configure(config):
    config.pluginmanager.register(Teller(os.environ.get("SLOW_TESTS", "commit")))
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Filler())
