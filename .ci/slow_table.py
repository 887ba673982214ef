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

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "tests" / "slow_tests.csv"
COLUMNS = ("test", "result", "figure", "processor seconds", "commit", "date")
SHOWN = ("passed", "expected failure", "skipped")
"""Results that need no second run on the same commit."""
OLDEST = 30
"""Days that a row may be older than the commit that is checked out."""
LONGEST = 100
"""Characters of a figure that are kept."""
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
    """The first line of an explained comparison, short: 'assert np.float64(0.5) < 1' -> '0.5 < 1'."""
    line = text.strip().splitlines()[0] if text.strip() else ""
    line = re.sub(r"np\.\w+\(([^()]*)\)", r"\1", line.removeprefix("AssertionError: ").removeprefix("assert "))
    line = re.sub(r"\d+\.\d{5,}(e[-+]?\d+)?", lambda found: f"{float(found[0]):.5g}", line)
    return line if len(line) <= LONGEST else line[:LONGEST - 1] + "…"


def processor_time():
    """Processor time of this process and of its children that ended [s]."""
    return sum(os.times()[:4])


class Filler:
    """Fills the table while pytest runs; leaves out what the table has shown (`done`)."""

    def __init__(self, which):
        self.which = which
        self.label, self.date = commit()
        self.rows = read()
        self.compared, self.result, self.before = "", None, 0.0

    def pytest_collection_modifyitems(self, config, items):
        left = [done(self.rows.get(item.nodeid), self.label, self.date, self.which) for item in items]
        config.hook.pytest_deselected(items=[item for item, out in zip(items, left, strict=True) if out])
        items[:] = [item for item, out in zip(items, left, strict=True) if not out]

    def pytest_runtest_logstart(self):
        self.compared, self.result, self.before = "", None, processor_time()

    def pytest_assertion_pass(self, expl):
        if COMPARISON.search(expl.splitlines()[0] if expl else ""):
            self.compared = expl

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.result = "failed"
        elif report.skipped:
            self.result = "expected failure" if hasattr(report, "wasxfail") else "skipped"
        elif report.when == "call":
            self.result = self.result or "passed"
        if report.outcome != "passed":
            crash = getattr(report.longrepr, "reprcrash", None)
            self.compared = crash.message if crash else str((report.longrepr or ("",))[-1])

    def pytest_runtest_logfinish(self, nodeid):
        self.rows[nodeid] = {"test": nodeid, "result": self.result, "figure": figure(self.compared),
                             "processor seconds": f"{processor_time() - self.before:.1f}", "commit": self.label,
                             "date": self.date}
        write(self.rows)


def pytest_configure(config):
    config.pluginmanager.register(Filler(os.environ.get("SLOW_TESTS", "commit")))
