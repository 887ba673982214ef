"""results.jsonl: a line a run as soon as it is done, from which everything else is made, in any order of lines."""

import json
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.region.plan import RESULTS

NUMBERS = ("release_volume", "affected_area", "runout", "runout_x", "runout_y", "travel_angle",
           "largest_flow_depth", "largest_flow_speed",
           "largest_flow_pressure", "flow_depth", "left_share", "windows", "window_at_border", "end", "final")
"""Numbers of a run that its line holds."""
STATUS = "done", "failed", "out_of_reach"
FAILED = 1
"""Number of it."""
KINDS = [("hash", "u8"), ("scenario", "i2"), ("area", "i4"), ("sample", "i4"), ("status", "i1"), ("w", "f8"),
         ("s", "f8"), ("e", "f8"), ("n", "f8"), ("depth", "f4"), ("seconds", "f4"), ("left", "f4"), ("angle", "f4"),
         ("final", "?"), ("pressure", "f4")]
"""Of the table of all runs."""
HASH = re.compile("[0-9a-f]{16}")
LONGEST = 1 << 14
"""Characters of a line."""


@dataclass
class Index:
    """What is known of all runs, as arrays (n,): hash (16 hex digits as a whole number), scenario (number of it in
    names), area, sample, status (number of STATUS), bounds (n, 4) [m], NaN without maps, flow_depth [m], seconds (of
    processor time), samples (of its release that did not fail), left_share (of the snow, over the border of the terrain
    or into cells without heights), travel_angle [degrees], NaN where it is not known, final (whether the snow had come
    to rest), pressure (largest) [Pa]."""

    names: list
    hash: np.ndarray
    scenario: np.ndarray
    area: np.ndarray
    sample: np.ndarray
    status: np.ndarray
    bounds: np.ndarray
    flow_depth: np.ndarray
    seconds: np.ndarray
    samples: np.ndarray
    left_share: np.ndarray
    travel_angle: np.ndarray
    final: np.ndarray
    pressure: np.ndarray

    def name_of(self, k):
        """Hash of run k."""
        return f"{int(self.hash[k]):016x}"


def line_of(record):
    """The line of a record of `jobs.work_on`."""
    numbers = {name: record["numbers"][name] for name in NUMBERS if name in record["numbers"]}
    clean = {name: value for name, value in numbers.items() if isinstance(value, bool) or math.isfinite(value)}
    kept = {name: record[name] for name in ("hash", "scenario", "area", "sample", "status")}
    seconds = float((record.get("work") or {}).get("processor") or 0.0)
    return json.dumps({**kept, "reason": record.get("reason", ""), "bounds": record.get("bounds"),
                       "seconds": round(seconds, 3), "numbers": clean}, allow_nan=False) + "\n"


def lines(folder):
    """Entries of results.jsonl, one after the other, the newest of a run last; a line that a kill cut off at the end is
    left out. Raises InputError for another line that this program did not write."""
    path = Path(folder) / RESULTS
    if not path.is_file():
        return
    broken = 0
    with path.open(encoding="utf-8", errors="replace") as file:
        for n, line in enumerate(iter(lambda: file.readline(LONGEST), ""), 1):
            if broken:
                raise InputError(f"{path}: line {broken}: not written by this program")
            entry = _entry(line)
            if entry is None:
                broken = n
                continue
            yield entry


def _entry(line):
    try:
        entry = json.loads(line)
        sound = (line.endswith("\n") and HASH.fullmatch(entry["hash"]) and entry["status"] in STATUS
                 and isinstance(entry["scenario"], str) and isinstance(entry["area"], int)
                 and isinstance(entry["sample"], int) and isinstance(entry["numbers"], dict)
                 and 0 < entry["area"] < 2**31 and 0 <= entry["sample"] < 2**31
                 and all(isinstance(value, int | float) and abs(value) < 1e30 for value in (
                     entry.get("seconds") or 0.0, *entry["numbers"].values()))
                 and (entry["status"] == "done" or entry["bounds"] is None)
                 and (entry["bounds"] is None or (len(entry["bounds"]) == 4 and all(
                     isinstance(side, int | float) and abs(side) < 1e12 for side in entry["bounds"]))))
        return entry if sound else None
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def repair(folder):
    """Cut off a line at the end that a kill left unfinished."""
    path = Path(folder) / RESULTS
    if not path.is_file():
        return
    with path.open("rb+") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - LONGEST))
        tail = file.read()
        if tail and not tail.endswith(b"\n"):
            file.truncate(size - len(tail) + tail.rfind(b"\n") + 1)


def done(folder, retry=False):
    """Hashes, as whole numbers, of the runs that need not be done. retry: those that failed are to be done again."""
    found = set()
    for entry in lines(folder):
        own = int(entry["hash"], 16)
        if entry["status"] == "failed" and retry:
            found.discard(own)
        else:
            found.add(own)
    return found


def index_of(folder, names, wanted=None):
    """`Index` of a folder, sorted by scenario, area and sample. names: of its scenarios; wanted: hashes, as whole
    numbers, of the runs that count, all when missing."""
    table = np.fromiter(_rows(folder, list(names)), dtype=KINDS)
    if wanted is not None:
        table = table[np.isin(table["hash"], wanted)]
    newest = len(table) - 1 - np.unique(table["hash"][::-1], return_index=True)[1]
    table = table[newest]
    table = table[np.lexsort((table["sample"], table["area"], table["scenario"]))]
    bounds = np.stack([table[side] for side in "wsen"], axis=1)
    _, which, counts = np.unique(table[["scenario", "area"]][table["status"] != FAILED], return_inverse=True,
                                 return_counts=True)
    samples = np.zeros(len(table), np.int32)
    samples[table["status"] != FAILED] = counts[which]
    return Index(list(names), *(table[name] for name in ("hash", "scenario", "area", "sample", "status")), bounds,
                 table["depth"], table["seconds"], samples, table["left"], table["angle"], table["final"],
                 table["pressure"])


def _rows(folder, names):
    """Rows of KINDS of the entries."""
    for entry in lines(folder):
        if entry["scenario"] not in names:
            raise InputError(f"{Path(folder) / RESULTS}: scenario {entry['scenario'][:60]!r}: not one of"
                             f" {', '.join(names)}")
        yield (int(entry["hash"], 16), names.index(entry["scenario"]), entry["area"], entry["sample"],
               STATUS.index(entry["status"]), *(entry["bounds"] or (math.nan,) * 4),
               float(entry["numbers"].get("flow_depth", 0.0)), float(entry.get("seconds") or 0.0),
               float(entry["numbers"].get("left_share", 0.0)),
               float(entry["numbers"].get("travel_angle", math.nan)), bool(entry["numbers"].get("final", False)),
               float(entry["numbers"].get("largest_flow_pressure", 0.0)))
