"""What is promised, where it is tested, with which figure, last run at which commit: docs/claims.md. And what is
missed: docs/expected_failures.md.

    python .ci/claims.py           writes the pages from tests/claims.toml, tests/expected_failures.csv and the tables
                                   of results
    python .ci/claims.py --run     first runs the claims' tests that are not slow, and keeps their results in
                                   tests/claims.csv (minutes); slow ones are those of tests/slow_tests.csv
    python .ci/claims.py --check   code 1 where a page is not what it would write
"""

import argparse
import csv
import os
import subprocess
import sys
from pathlib import Path

from slow_table import ROOT, read

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

CLAIMS, RESULTS, SLOW, MISSED = (ROOT / "tests" / name for name in (
    "claims.toml", "claims.csv", "slow_tests.csv", "expected_failures.csv"))
PAGE, MISSES = (ROOT / "docs" / name for name in ("claims.md", "expected_failures.md"))
MET = {
    "users": ("What a user may meet", "In an ordinary scene. A caution of `snowmpm check` is named where there is."),
    "nobody": ("Gates of the program itself", "Forecasts, waiting times, structure, and settings that nobody needs."),
    "control": ("Controls", "What happens without a cure that the program takes by itself: they are meant to miss.")}
HEAD = """# What is promised, and what holds it

Made by `python .ci/claims.py` from the results of the tests: do not edit. A figure is the last comparison of numbers of
one of the tests, as it came out. Commit and date are those of the oldest result of the row. Tests that are not slow run
in every CI besides. [Expected failures](expected_failures.md) are the gates that are missed.
"""
MISSES_HEAD = """# Expected failures

Made by `python .ci/claims.py` from `tests/expected_failures.csv`: do not edit. Tests that ask for a gate that is
missed, strictly: one that passes is an error. {0} rows: {1} that a user may meet, {2} of the program itself, {3}
controls. "Not known": nobody has shown it. What is reached is of the day on which the row was written; the last results
of slow tests are in `tests/slow_tests.csv`.
"""


def claims(path=CLAIMS):
    """Sections of claims, as the file has them."""
    return tomllib.loads(path.read_text(encoding="utf-8"))["section"]


def functions(sections):
    """All tests that claims name, file::function, sorted."""
    return sorted({test for section in sections for claim in section["claim"] for test in claim["tests"]})


def results():
    """Rows of both tables by function: {file::function: [row of each case]}. Slow ones win."""
    found = {}
    for test, row in {**read(RESULTS), **read(SLOW)}.items():
        found.setdefault(test.partition("[")[0], []).append(row)
    return found


def run(sections):
    """Run what is not slow, two at a time, and keep the results."""
    surroundings = {**os.environ, "TABLE_OF_TESTS": str(RESULTS.relative_to(ROOT)), "SLOW_TESTS": "again",
                    "PYTHONPATH": os.pathsep.join([str(ROOT / ".ci"), os.environ.get("PYTHONPATH", "")])}
    RESULTS.unlink(missing_ok=True)
    subprocess.run([sys.executable, "-m", "pytest", "-q", "-n", "2", "-p", "slow_table", "-o",
                    "enable_assertion_pass_hook=true", *functions(sections)], cwd=ROOT, env=surroundings, check=False)


def page(sections):
    """Text of the page."""
    known, lines = results(), [HEAD]
    for section in sections:
        lines += [f"## {section['title']}", "", "| promised | tests | figure | oldest result |", "|---|---|---|---|"]
        lines += [_row(claim, known) for claim in section["claim"]]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _row(claim, known):
    says = claim["says"]
    if claim.get("page"):
        link = Path(os.path.relpath(ROOT / claim["page"], PAGE.parent)).as_posix()
        says += f" [{Path(claim['page']).stem.replace('_', ' ')}]({link})"
    rows = [row for test in claim["tests"] for row in known.get(test, [])]
    told = [f"`{test.removeprefix('tests/')}` {_count(known.get(test, []))}" for test in claim["tests"]]
    figures = [row["figure"] for row in rows if row["result"] == "passed" and row["figure"]]
    oldest = min(rows, key=lambda row: row["date"], default=None)
    when = f"{oldest['date']}, {oldest['commit']}" if oldest else "not run"
    figure = figures[-1].replace("|", "\\|") if figures else ""
    return f"| {says} | {'; '.join(told)} | {f'`{figure}`' if figure else ''} | {when} |"


def _count(rows):
    """(12) or (12, 1 missed, 2 skipped)"""
    counts = [sum(row["result"] == result for row in rows) for result in ("passed", "expected failure", "skipped")]
    failed = len(rows) - sum(counts)
    words = [f"{counts[0]}", *(f"{count} {word}" for count, word in zip((*counts[1:], failed), (
        "missed", "skipped", "FAILED"), strict=True) if count)]
    return f"({', '.join(words)})"


def misses():
    """Text of the page of expected failures."""
    with MISSED.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    lines = [MISSES_HEAD.format(len(rows), *(sum(row["met by"] == kind for row in rows) for kind in MET))]
    for kind, (title, about) in MET.items():
        lines += [f"## {title}", "", about, "", "| test | asked | reached | cause | cure |", "|---|---|---|---|---|"]
        lines += [_miss(row) for row in rows if row["met by"] == kind]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _miss(row):
    tests = "; ".join(f"`{test.strip().removeprefix('tests/')}`" for test in row["tests"].split(";"))
    cases = f" ({row['cases']})" if row["cases"] else ""
    cure = row["cure"] + (f" Caution: `{row['caution']}`" if row["caution"] else "")
    cells = (tests + cases, row["gate"], row["reached"], row["cause"], cure)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--run", action="store_true", help="run the tests that are not slow first")
    words.add_argument("--check", action="store_true", help="compare instead of writing")
    asked = words.parse_args()
    sections = claims()
    if asked.run:
        run(sections)
    pages = {PAGE: page(sections), MISSES: misses()}
    if asked.check:
        return int(any(not path.exists() or path.read_text(encoding="utf-8") != text for path, text in pages.items()))
    for path, text in pages.items():
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
