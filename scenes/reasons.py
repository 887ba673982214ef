"""Reasons for numbers in a scene file: comments on the lines of their keys."""

import re
from pathlib import Path

LINE = re.compile(r"""^\s*([\w.]+)\s*=\s*((?:"[^"]*"|'[^']*'|[^"'#])*)\#\s*(.+?)\s*$""")
TABLE = re.compile(r"^\s*(\[\[?)\s*([\w.]+)\s*\]\]?")
LEAST_WORDS = 4
"""Least length of a comment that is a reason and not just a unit."""


def reasons(path):
    """{dotted key: comment} of a TOML file, such as {"solver.cfl": "of a largest stable 0.836"}; {} without one."""
    path, table, seen, found = Path(path), "", {}, {}
    if path.suffix != ".toml" or not path.is_file():
        return found
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if head := TABLE.match(line):
            table = head[2]
            if head[1] == "[[":
                seen[table] = seen.get(table, -1) + 1
                table = f"{table}.{seen[table]}"
        elif (row := LINE.match(line)) and len(row[3].split()) >= LEAST_WORDS:
            found[f"{table}.{row[1]}".lstrip(".")] = row[3]
    return found
