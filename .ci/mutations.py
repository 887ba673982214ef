"""Change one constant by one or two per cent in each of many places, and see that a test that belongs notices it.

    python .ci/mutations.py                  all of tests/mutations.toml, one after the other; about ten minutes
    python .ci/mutations.py voellmy_drag     these only; the others keep their rows
    python .ci/mutations.py --area depth     those of an area

Each change is made in a copy of the files that git tracks, and the tests that are named for it run there; before that
all of them run in the unchanged copy. A row for each change goes to tests/mutations.csv. Exit code 1 where a test does
not notice a change, or a line to be changed is not there exactly once.
"""

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
CHANGES, TABLE = ROOT / "tests" / "mutations.toml", ROOT / "tests" / "mutations.csv"
COLUMNS = ("name", "area", "file", "change", "result", "test", "seconds", "commit")
LIMIT = 900.0
"""Seconds after which the tests of a change are ended."""


def git(*words):
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def copied(folder):
    """Copy of the tracked files in which the packages lie where Python looks for them, whatever is installed."""
    for name in git("ls-files", "-z").split("\0"):
        if name and (ROOT / name).is_file():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, place)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    for package, place in project["tool"]["setuptools"]["package-dir"].items():
        if "." in package:
            (folder / package.replace(".", "/")).symlink_to(folder / place, target_is_directory=True)
    return folder


def run(folder, tests, *options):
    """(exit code of pytest, first failed test or "", its seconds) of tests in a copy."""
    begun = time.monotonic()
    try:
        done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "", *options,
                               *tests], cwd=folder, capture_output=True, text=True, timeout=LIMIT,
                              env={**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"})
    except subprocess.TimeoutExpired:
        return None, "", time.monotonic() - begun
    failed = next((line.split(" ")[1] for line in done.stdout.splitlines() if line.startswith("FAILED ")), "")
    return done.returncode, failed, time.monotonic() - begun


def verdict(change, code, failed):
    """Result of a change from what pytest said; slow: only a test marked so notices it."""
    if code == 1 and failed:
        return "noticed by a slow test" if change.get("slow") else "noticed"
    return "NOT noticed" if code == 0 else f"pytest ended with {code}"


def changed(folder, change):
    """The text of the changed file, put in place; -> what was there. Raises ValueError where the line is not there
    exactly once."""
    path = folder / change["file"]
    text = path.read_text(encoding="utf-8")
    if text.count(change["old"]) != 1:
        raise ValueError(f"{change['file']} holds the line {text.count(change['old'])} times")
    path.write_text(text.replace(change["old"], change["new"]), encoding="utf-8")
    return text


def read():
    """Rows of the table by name."""
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="", encoding="utf-8") as stream:
        return {row["name"]: row for row in csv.DictReader(stream)}


def write(rows, names):
    """The table, in the order of the changes."""
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        sheet = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        sheet.writeheader()
        sheet.writerows(rows[name] for name in names if name in rows)


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("names", nargs="*")
    words.add_argument("--area")
    asked = words.parse_args()
    changes = tomllib.loads(CHANGES.read_text(encoding="utf-8"))["change"]
    names = [change["name"] for change in changes]
    if unknown := sorted(set(asked.names) - set(names)):
        raise SystemExit(f"no change {unknown[0]} in {CHANGES.name}: {', '.join(names)}")
    chosen = [change for change in changes
              if (not asked.names or change["name"] in asked.names) and asked.area in (None, change["area"])]
    rows, bad, commit = read(), [], git("rev-parse", "--short=10", "HEAD")
    with tempfile.TemporaryDirectory() as scratch:
        folder = copied(Path(scratch) / "copy")
        tests = sorted({test for change in chosen for test in change["tests"]})
        print(f"{len(chosen)} changes; first {len(tests)} tests as they are", flush=True)
        code, failed, _ = run(folder, tests)
        if code:
            raise SystemExit(f"tests fail without a change: {failed or code}")
        for change in chosen:
            try:
                before = changed(folder, change)
            except ValueError as error:
                result, failed, took = f"no such line: {error}", "", 0.0
            else:
                code, failed, took = run(folder, change["tests"])
                result = verdict(change, code, failed)
                (folder / change["file"]).write_text(before, encoding="utf-8")
            rows[change["name"]] = {
                "name": change["name"], "area": change["area"], "file": change["file"],
                "change": f"{change['old'].strip()} -> {change['new'].strip()}", "result": result, "test": failed,
                "seconds": f"{took:.0f}", "commit": commit}
            bad += [] if result.startswith("noticed") else [change["name"]]
            print(f"{change['name']:32s} {result:24s} {took:5.0f} s  {failed}", flush=True)
            write(rows, names)
    print(f"{len(chosen) - len(bad)} of {len(chosen)} noticed", *bad)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
