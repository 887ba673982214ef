"""The tests marked slow, in groups of at most an hour, one after the other, with a table that is kept.

    python .ci/slow_tests.py                     all that has not been shown on this commit
    python .ci/slow_tests.py --groups            what the groups are, and how long they took
    python .ci/slow_tests.py tests/verification  of these files and folders only
    python .ci/slow_tests.py --again             also what has been shown on this commit
    python .ci/slow_tests.py --missing           what --age names: never run, failed, or too old
    python .ci/slow_tests.py --age               how old the table is; code 1 where a test is missing, failed or too old

A group is the slow tests of some files, put together by the time that they took before; a file that nobody timed counts
ten minutes. Two workers run a group, which is ended after twice an hour.

tests/slow_tests.csv is written anew after each test: result, figure, processor time and commit. So the tests can run in
several sittings, and one that is cut off goes on where it was. A row of a tree with changes that are not committed says
so by a + after the commit.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections import Counter

from slow_table import OLDEST, ROOT, SHOWN, TABLE, commit, days, done, read, recent, seconds, shown, write

GROUP = 3600.0
"""Longest processor time of a group [s]."""
UNKNOWN = 600.0
"""Processor time that is taken for a file without one [s]."""
MARK = ["-m", "slow"]


def collect(places):
    """Slow tests, in the order in which pytest finds them. Raises SystemExit where collecting fails."""
    found = subprocess.run([sys.executable, "-m", "pytest", "-q", "--collect-only", *MARK, *places],
                           cwd=ROOT, capture_output=True, text=True)
    if found.returncode not in (0, 5):
        raise SystemExit(found.stdout[-4000:] + found.stderr[-4000:])
    return [line for line in found.stdout.splitlines() if "::" in line]


def file_of(test):
    return test.split("::")[0]


def grouped(times):
    """Lists of files, each of at most an hour, from the time of each file [s]."""
    groups, filled = [], []
    for file in sorted(times, key=lambda file: -times[file]):
        took = times[file] or UNKNOWN
        place = next((i for i, sum_ in enumerate(filled) if sum_ + took <= GROUP), None)
        if place is None:
            groups.append([file])
            filled.append(took)
        else:
            groups[place].append(file)
            filled[place] += took
    return groups


def run(group, which):
    """Run the slow tests of some files; the plugin fills the table. -> why not all were run, None where they were."""
    with tempfile.TemporaryDirectory() as cache:
        # Explained comparisons take assertions compiled in another way, which must not lie in the usual place.
        surroundings = {**os.environ, "PYTHONPYCACHEPREFIX": cache, "SLOW_TESTS": which,
                        "PYTHONPATH": os.pathsep.join([str(ROOT / ".ci"), os.environ.get("PYTHONPATH", "")])}
        try:
            code = subprocess.run([sys.executable, "-m", "pytest", "-q", "-n", "2", *MARK, "-p", "slow_table",
                                   "-o", "enable_assertion_pass_hook=true", *group],
                                  cwd=ROOT, timeout=2 * GROUP, env=surroundings).returncode
        except subprocess.TimeoutExpired:
            return "ended after two hours"
    return None if code in (0, 1, 5) else f"pytest ended with {code}"


def verdict(tests, rows, date):
    """What is wrong with the table: lines for tests that are missing, failed or have a row that is too old."""
    wrong = []
    for test in tests:
        row = rows.get(test)
        if row is None:
            wrong.append(f"{test}: never run")
        elif row["result"] not in SHOWN:
            wrong.append(f"{test}: {row['result']} on {row['commit']}")
        elif not recent(row, date):
            wrong.append(f"{test}: shown {days(row, date)} days before, at most {OLDEST}")
    return wrong


def age():
    """Print how old the table is; -> exit code."""
    rows, (label, date) = read(), commit()
    tests = collect([])
    counts = Counter(row["result"] for test, row in rows.items() if test in set(tests))
    wrong = verdict(tests, rows, date)
    print(f"slow tests: {len(tests)};", ", ".join(f"{count} {result}" for result, count in counts.most_common()),
          f"; {sum(shown(rows.get(test), label) for test in tests)} on {label}")
    print(*wrong[:40], *([f"and {len(wrong) - 40} more"] if len(wrong) > 40 else []), sep="\n")
    return 1 if wrong else 0


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("places", nargs="*", help="files and folders; all of tests/ by default")
    words.add_argument("--groups", action="store_true", help="print the groups and end")
    words.add_argument("--again", action="store_true", help="run also what has been shown on this commit")
    words.add_argument("--missing", action="store_true", help="run what was never run, failed, or was shown long ago")
    words.add_argument("--age", action="store_true", help="print how old the table is and end")
    asked = words.parse_args()
    if asked.age:
        return age()
    rows, (label, date) = read(), commit()
    tests = collect(asked.places)
    if not asked.places and not asked.groups:
        there = set(tests)
        write({test: row for test, row in rows.items() if test in there})  # without tests that are gone
    which = "again" if asked.again else "missing" if asked.missing else "commit"
    todo = [test for test in tests if not done(rows.get(test), label, date, which)]
    times = Counter()
    for test in todo:
        times[file_of(test)] += seconds(rows.get(test))
    groups = grouped(times)
    if asked.groups:
        for i, group in enumerate(groups, 1):
            print(f"group {i}: {sum(times[file] for file in group) / 60:.0f} min so far known")
            print(*(f"  {file}" for file in group), sep="\n")
        return 0
    print(f"{len(tests)} slow tests, {len(todo)} to run on {label}, in {len(groups)} groups")
    for i, group in enumerate(groups, 1):
        print(f"== group {i} of {len(groups)}: {' '.join(group)}", flush=True)
        if why := run(group, which):
            rows = read()
            for test in todo:
                if file_of(test) in group and (rows.get(test) or {}).get("commit") != label:
                    rows[test] = {"test": test, "result": f"not finished: {why}", "figure": "",
                                  "processor seconds": "0", "commit": label, "date": date}
            write(rows)
    rows = read()
    missed = [test for test in todo if not shown(rows.get(test), label)]
    print("== slow tests", f"NOT shown on {label}:" if missed else f"shown on {label}", *missed, sep="\n")
    print(TABLE.relative_to(ROOT))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
