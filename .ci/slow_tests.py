"""The tests marked slow, in groups of at most an hour, one after the other, with a summary that is kept.

    python .ci/slow_tests.py                     all groups that have not passed on this commit
    python .ci/slow_tests.py --groups            what they are, and how long they took
    python .ci/slow_tests.py tests/verification  of these files and folders only
    python .ci/slow_tests.py --again             also what has passed on this commit

A group is the slow tests of some files. Files are put together by the time that they took before; one that nobody timed
is a group of its own. Each group runs in a process of its own and is ended after twice an hour.

tests/slow_tests.csv is written anew after each group: a row for each file with its counts, its processor time and the
commit. So the groups can run in several sittings. Rows with one commit show what that commit passes. A row of a tree
with changes that are not committed says so by a + after the commit.
"""

import argparse
import csv
import os
import platform
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SUMMARY = ROOT / "tests" / "slow_tests.csv"
COLUMNS = ("file", "passed", "failed", "expected failures", "skipped", "processor seconds", "commit", "python")
GROUP = 3600.0
"""Longest processor time of a group [s]."""
MARK = ["-m", "slow"]


def commit():
    """The commit that is checked out, with a + where files that it holds have changed."""
    def git(*words):
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", f":!{SUMMARY.relative_to(ROOT)}")
    return git("rev-parse", "--short=10", "HEAD") + ("+" if changed else "")


def collect(places):
    """Files with slow tests, in the order of their names. Raises SystemExit where collecting fails."""
    found = subprocess.run([sys.executable, "-m", "pytest", "-q", "--collect-only", *MARK, *places],
                           cwd=ROOT, capture_output=True, text=True)
    if found.returncode not in (0, 5):
        raise SystemExit(found.stdout[-4000:] + found.stderr[-4000:])
    return sorted({line.split("::")[0] for line in found.stdout.splitlines() if "::" in line})


def read():
    """Rows of the summary by file."""
    if not SUMMARY.exists():
        return {}
    with SUMMARY.open(newline="", encoding="utf-8") as stream:
        return {row["file"]: row for row in csv.DictReader(stream)}


def write(rows):
    """The summary, sorted by file; the old one stays until the new one is whole."""
    part = SUMMARY.with_suffix(".part")
    with part.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows[file] for file in sorted(rows))
    os.replace(part, SUMMARY)


def grouped(files, rows):
    """Lists of files, each of at most an hour by the times of the summary; files without a time stand alone."""
    groups, filled = [], []
    for file in sorted(files, key=lambda file: -seconds(rows.get(file))):
        took = seconds(rows.get(file))
        place = next((i for i, sum_ in enumerate(filled) if took and sum_ + took <= GROUP), None)
        if place is None:
            groups.append([file])
            filled.append(took or GROUP)
        else:
            groups[place].append(file)
            filled[place] += took
    return groups


def seconds(row):
    """Processor time of a row of the summary [s], 0 where there is none."""
    return float(row["processor seconds"]) if row else 0.0


def run(group, rows, label):
    """Run the slow tests of files and put their rows into the summary; -> whether all passed."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        before = processor_time()
        try:
            code = subprocess.run([sys.executable, "-m", "pytest", "-q", *MARK, "-o", "junit_family=xunit1",
                                   f"--junitxml={report}", *group], cwd=ROOT, timeout=2 * GROUP).returncode
        except subprocess.TimeoutExpired:
            code = "ended after two hours"
        took = processor_time() - before
        counts, times = counted(report) if report.exists() else ({}, {})
    for file in group:
        count = counts.get(file, Counter())
        share = times.get(file, 0.0) / total if (total := sum(times.values())) else 1 / len(group)
        rows[file] = {"file": file, **{column: count[column] for column in COLUMNS[1:5]},
                      "processor seconds": round(took * share), "commit": label, "python": platform.python_version()}
        if code not in (0, 1) or not count:
            rows[file]["failed"] = f"not finished: {code}"
    write(rows)
    return code == 0


def processor_time():
    """Processor time of all processes that this one started and that ended [s]."""
    spent = os.times()
    return spent.children_user + spent.children_system


def counted(report):
    """Counts and wall times by file from a report of pytest."""
    counts, times = {}, {}
    for case in ElementTree.parse(report).iter("testcase"):
        file = case.get("file")
        kinds = {child.tag: child.get("type", "") for child in case}
        kind = "passed"
        if kinds.keys() & {"failure", "error"}:
            kind = "failed"
        elif "skipped" in kinds:
            kind = "expected failures" if kinds["skipped"] == "pytest.xfail" else "skipped"
        counts.setdefault(file, Counter())[kind] += 1
        times[file] = times.get(file, 0.0) + float(case.get("time", 0.0))
    return counts, times


def passed(row, label):
    """Whether a row says that its file passed on this commit; never for a tree with changes."""
    return bool(row) and row["commit"] == label and not label.endswith("+") and row["failed"] == "0"


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("places", nargs="*", help="files and folders; all of tests/ by default")
    words.add_argument("--groups", action="store_true", help="print the groups and end")
    words.add_argument("--again", action="store_true", help="run also what has passed on this commit")
    asked = words.parse_args()
    rows, label = read(), commit()
    files = collect(asked.places)
    todo = [file for file in files if asked.again or not passed(rows.get(file), label)]
    groups = grouped(todo, rows)
    if asked.groups:
        for i, group in enumerate(groups, 1):
            print(f"group {i}: {sum(seconds(rows.get(file)) for file in group) / 60:.0f} min so far known")
            print(*(f"  {file}" for file in group), sep="\n")
        return 0
    print(f"{len(files)} files with slow tests, {len(todo)} to run on {label}, in {len(groups)} groups")
    failed = []
    for i, group in enumerate(groups, 1):
        print(f"== group {i} of {len(groups)}: {' '.join(group)}", flush=True)
        if not run(group, rows, label):
            failed += group
    print("== slow tests", "FAILED in a group of:" if failed else f"passed on {label}", *failed)
    print(SUMMARY.relative_to(ROOT))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
