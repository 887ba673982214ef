"""Every profile of a folder: one table, one picture, and how theories compare with the saw tests in the field.

`results.jsonl` gets a line a profile as soon as it is done: what `--resume` goes on from. A profile is known again by
its content and the settings. One that cannot be read, or lacks what is needed, has its reason in the table.
"""

import csv
import hashlib
import json
import math
import sys
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from snowmpm import overwriting
from snowmpm.draft import draft, write_text
from snowmpm.errors import InputError, shown_line
from snowmpm.pit.column import column_of
from snowmpm.pit.profile import SnowProfile
from snowmpm.pit.reader import READERS, read_profile
from snowmpm.pit.record import NAMES
from snowmpm.pit.stability import SAMPLES, stability_of
from snowmpm.pit.weak_layers import candidates
from snowmpm.reading.limited import read_limited, read_text_limited

FEW = 40
"""Profiles that this process does by itself: workers take longer to start."""
NEAR_END = 0.8
"""Cut over column beyond which the end of the column counts."""
FACTOR = 1.5
RESULTS, TABLE, PICTURE, SUMMARY = "results.jsonl", "profiles.csv", "profiles.png", "summary.json"
MOST_BYTES = 1 << 30
"""Of a profile's file, whose digest is taken."""
MOST_RESULTS = 256 << 20
TEXTS = ("file", "name", "time", "slope_from", "weak_layer_form", "test", "cannot")
COLUMNS = ("file", "name", "time", "latitude", "longitude", "slope_angle_deg", "slope_from", "weak_layer_depth_m",
           "weak_layer_form",
           "slab_m", "slab_kg_m3", "normal_Pa", "shear_Pa",
           *(f"{name}{end}_m" for name in NAMES for end in ("", "_low", "_high")), "test", "test_depth_m",
           "cut_m", "column_m", "cannot")


@dataclass
class Found:
    """written: paths; told: lines; record: numbers."""

    written: list[Path]
    told: list[str]
    record: dict = field(default_factory=dict)


def run(folder, target, slope=None, modulus="bergfeld", resume=False, workers=None, quiet=False, scheduler=None):
    """Do every profile below `folder` that READERS can read; -> `Found`.

    slope, modulus: as `column_of` takes them, for all; workers: processes. Raises InputError for a folder without
    profiles, and for results that --resume does not know.
    """
    inside, own = folder.resolve(), target.resolve()
    files = sorted(path for path in folder.rglob("*")
                   if path.suffix.lower() in READERS and inside in (real := path.resolve()).parents  # no link elsewhere
                   and (own == inside or own not in real.parents))
    if not files:
        raise InputError(f"{folder}: no profiles in it: files that end in {', '.join(READERS)}")
    for path in files:
        overwriting.reads(path)
    results = target / RESULTS
    if results.exists() and not resume:
        raise InputError(f"{results} is there already: --resume goes on with it, another -o begins anew")
    overwriting.guard_in(target, (TABLE, PICTURE, SUMMARY))
    target.mkdir(parents=True, exist_ok=True)
    jobs = [(str(path), slope, modulus, SAMPLES) for path in files]
    known = _known(results) if resume else {}
    write_text(results, "".join(map(_line, known.items())))  # without a line that a kill cut off
    overwriting.note_changing(results)
    digests, todo, unread = {}, [], {}
    for job in jobs:
        try:
            digests[job[0]] = digest(job)
        except (OSError, InputError) as error:
            unread[job[0]] = [_cannot(job[0], error)]
            continue
        if digests[job[0]] not in known:
            todo.append(job)
    with results.open("a", encoding="utf-8") as file:
        for n, (path, rows) in enumerate(_done(todo, workers, scheduler), 1):
            known[digests[path]] = rows
            file.write(_line((digests[path], rows)))
            file.flush()
            if not quiet and n % 50 == 0:
                print(f"{n} of {len(todo)} profiles", file=sys.stderr)
    return _written(folder, target, [row for path, *_ in jobs for row in unread.get(path) or known[digests[path]]])


def _line(known):
    digest, rows = known
    return json.dumps({"digest": digest, "rows": rows}, allow_nan=False) + "\n"


def digest(job):
    """Of a profile's content and what is done with it."""
    path, *settings = job
    content = hashlib.sha256(read_limited(Path(path), MOST_BYTES)).hexdigest()
    return hashlib.sha256(json.dumps([path, content, *settings]).encode()).hexdigest()


def rows_of(job):
    """(path, rows of the table): one a saw test that has a cut length, else one of the likeliest weak layer."""
    path, *settings = job
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            profile = read_profile(path)
            return path, list(_rows(profile, *settings))
    except Exception as error:  # whatever one file does, the others go on
        return path, [_cannot(path, error)]


def _cannot(path, error):
    if isinstance(error, InputError):
        said = str(error).removeprefix(f"{path}: ")
    else:
        reason = error.strerror if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        said = f"cannot be read: {reason}"
    return {"file": path, "cannot": shown_line(said, 300)}


def _rows(profile: SnowProfile, slope, modulus, samples):
    about = {"file": profile.source, "name": profile.name, "time": profile.time,
             "latitude": profile.place and profile.place[0], "longitude": profile.place and profile.place[1]}
    tests = [test for test in profile.tests if test.kind == "PST" and test.cut and test.depth is not None]
    found = candidates(profile)
    if not tests and not found:
        yield {**about, "cannot": "no candidate for the weak layer: no test, no mark, no persistent grains"}
        return
    done = {}
    for test in tests or [None]:
        said = {} if test is None else {"test": f"{test.kind} {test.result}", "test_depth_m": test.depth,
                                        "cut_m": test.cut, "column_m": test.column}
        index = found[0].index if test is None else profile.index_at(test.depth)
        depth = found[0].depth if test is None else test.depth
        try:
            if (index, depth) not in done:
                done[index, depth] = _of_layer(profile, index, depth, slope, modulus, samples)
            yield {**about, **done[index, depth], **said}
        except InputError as error:
            yield {**about, **said, "cannot": shown_line(str(error).removeprefix(f"{profile.source}: "), 300)}


def _of_layer(profile, index, depth, slope, modulus, samples):
    column = column_of(profile, index, slope, modulus, depth)
    found = stability_of(column, samples)
    lengths = {f"{one.theory}{end}_m": value for one in found.lengths
               for end, value in (("", one.value), ("_low", one.low), ("_high", one.high))}
    known = "--slope" if slope is not None else "file" if profile.slope_angle is not None else "assumed"
    return {"slope_angle_deg": column.angle, "slope_from": known, "weak_layer_depth_m": depth,
            "weak_layer_form": profile.layers[index].form, "slab_m": column.thickness, "slab_kg_m3": column.density,
            "normal_Pa": found.normal, "shear_Pa": found.shear, **lengths}


def _done(jobs, workers, scheduler):
    """(path, rows) of each job as it is done."""
    if scheduler is None and (workers == 1 or (workers is None and len(jobs) <= FEW)):
        yield from map(rows_of, jobs)
        return
    from snowmpm.campaigns.cluster import require_cluster, site
    from snowmpm.campaigns.spec import Cluster

    _, distributed = require_cluster()
    with site(Cluster(), scheduler, workers) as place:
        for _, result in distributed.as_completed(place.client.map(rows_of, jobs, pure=False), with_results=True):
            yield result


def _known(results):
    """Rows by digest, of the lines that are whole."""
    known = {}
    lines = read_text_limited(results, MOST_RESULTS).splitlines() if results.exists() else []
    for n, line in enumerate(lines, 1):
        try:
            entry = json.loads(line)
            known[str(entry["digest"])] = [_row(row) for row in entry["rows"]]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            if n == len(lines):  # it was being written when the program was killed
                continue
            raise InputError(f"{results}: line {n}: not written by this program") from None
    return known


def _row(row):
    """A row as this program writes it. Raises ValueError for any other."""
    sound = "file" in row and all(
        name in COLUMNS and (value is None or (isinstance(value, str) if name in TEXTS else
                                               isinstance(value, int | float) and math.isfinite(value)))
        for name, value in row.items())
    if not sound or any((row.get(name) or 0.0) < 0.0 for name in ("cut_m", "column_m")):
        raise ValueError(row)
    return row


def statistics(rows, near_end=False):
    """{theory: numbers} of saw tests that ran to the end, without those near the end of their column unless near_end.

    n; fails_by_itself: how many have no length, since the layer would not bear its slab; of the others median_ratio,
    rank_correlation (Spearman), within_factor: share within FACTOR; within_interval: share of all whose cut lies in the
    interval.
    """
    found = {}
    for theory in NAMES:
        pairs = [(row["cut_m"], row[f"{theory}_m"], row.get(f"{theory}_low_m"), row.get(f"{theory}_high_m"))
                 for row in rows if "End" in str(row.get("test")) and row.get(f"{theory}_m") is not None
                 and (near_end or not row.get("column_m") or row["cut_m"] < NEAR_END * row["column_m"])]
        measured, predicted, low, high = np.array(pairs, float).reshape(-1, 4).T
        stands = predicted > 0.0
        ratio = predicted[stands] / measured[stands]
        within = np.abs(np.log(ratio)) <= math.log(FACTOR)
        found[theory] = {
            "n": len(measured), "fails_by_itself": int(np.sum(~stands)),
            "median_ratio": float(np.median(ratio)) if len(ratio) else None,
            "rank_correlation": _rank_correlation(measured[stands], predicted[stands]),
            "within_factor": float(within.mean()) if len(ratio) else None,
            "within_interval": float(np.mean((measured >= low) & (measured <= high))) if len(measured) else None}
    return found


def _rank_correlation(first, second):
    """Spearman's; None for less than five pairs or where all are equal."""
    if len(first) < 5 or np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return None
    from scipy.stats import spearmanr

    return float(spearmanr(first, second)[0])


def _written(folder, target, rows):
    from snowmpm.render.pit_plot import render_scatter

    with draft(target / TABLE) as part, part.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows({name: cell_text(row.get(name)) for name in COLUMNS} for row in rows)
    cannot = [row for row in rows if row.get("cannot")]
    profiles = len({row["file"] for row in rows})
    found = {"folder": str(folder), "profiles": profiles, "rows": len(rows), "cannot": len(cannot),
             "ran_to_the_end": statistics(rows, True), "away_from_the_end": statistics(rows)}
    with draft(target / SUMMARY) as part:
        part.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    written = [target / TABLE, target / SUMMARY]
    ended = [row for row in rows if "End" in str(row.get("test"))]
    pairs = {NAMES[name]: tuple(np.array([(row["cut_m"], row[f"{name}_m"]) for row in ended
                                          if row.get(f"{name}_m") is not None], float).reshape(-1, 2).T)
             for name in NAMES if any(row.get(f"{name}_m") is not None for row in ended)}
    if pairs:
        written.append(render_scatter(pairs, target / PICTURE, f"{folder.name}: saw tests that ran to the end"))
    return Found(written, list(_told(found, cannot)), found)


def _told(found, cannot):
    yield f"{found['profiles']} profiles, {found['rows']} rows, of which {found['cannot']} are not evaluated:"
    reasons: dict[str, int] = {}
    for row in cannot:
        reason = _kind_of(row["cannot"])
        reasons[reason] = reasons.get(reason, 0) + 1
    for reason, count in sorted(reasons.items(), key=lambda one: -one[1])[:8]:
        yield f"  {count}: {reason}"
    for key, words in (("ran_to_the_end", "saw tests that ran to the end"),
                       ("away_from_the_end", f"of them cut for less than {NEAR_END:g} of the column")):
        yield f"{words}: computed over measured"
        yield (f"  {'':22} {'n':>5} {'median':>7} {'rank':>6} {f'within {FACTOR:g}':>10} {'in interval':>12}"
               f" {'unstable':>9}")
        for theory, values in found[key].items():
            if values["n"]:
                yield (f"  {NAMES[theory]:22} {values['n']:5} {_two(values['median_ratio']):>7}"
                       f" {_two(values['rank_correlation']):>6} {_percent(values['within_factor']):>10}"
                       f" {_percent(values['within_interval']):>12} {values['fails_by_itself']:9}")


def _kind_of(reason):
    """A reason without what is particular to one file."""
    parts = [part for part in reason.split(": ") if not part.startswith("layer ")]
    return shown_line((parts or [reason])[0], 100)


def cell_text(value):
    """A value as it stands in the table."""
    if isinstance(value, str) and value and value[0] in "=+-@\t\r":  # a spreadsheet would compute it
        return f"'{value}"
    return f"{value:.5g}" if isinstance(value, float) else "" if value is None else value


def _two(value):
    return "-" if value is None else f"{value:.2f}"


def _percent(value):
    return "-" if value is None else f"{100 * value:.0f} %"
