"""What tells a run apart from others of its scene: the name of its folder, or what varies in its campaign."""

import json
import re
from pathlib import Path

from snowmpm.errors import shown_line

HASH = re.compile("[0-9a-f]{16}")
"""Name of the folder of a run of a campaign."""

LARGEST = 1 << 26
"""Bytes of a campaign's plan that is read for it."""


def scenario_of(folder, scene_name=None):
    """Words for the run in a folder: "mu 0.25, top 1" in a campaign, else the name of the folder; "" where that is the
    name of the scene."""
    folder = Path(folder).resolve()
    if HASH.fullmatch(folder.name) and (varied := _varied(folder)):
        return varied
    return "" if folder.name == scene_name else shown_line(folder.name, 60)


def _varied(folder):
    """Values of a run by its campaign's plan, which anybody may have written; "" where there is none."""
    plan = folder.parents[1] / "plan.json"
    try:
        if plan.stat().st_size > LARGEST:
            return ""
        rows = json.loads(plan.read_text(encoding="utf-8"))
        values = next(row["values"] for row in rows if row["hash"] == folder.name)
        return shown_line(", ".join(f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
                                    for name, value in values.items()), 120)
    except (OSError, ValueError, LookupError, TypeError, StopIteration, AttributeError, RecursionError):
        return ""
