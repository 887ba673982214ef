"""What a worker does: one run, from its scene to its numbers and maps. A killed run goes on from its checkpoint.

results/HASH/record.json appears when a run is done, whole or not at all; it says "done" or "failed", and why.
results/HASH/maps.npz is there before. A lock on that folder keeps a second worker away, which a scheduler may send when
it has lost the first from sight.
"""

import contextlib
import errno
import io
import json
import os
import socket
import time as clock
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from snowmpm import overwriting, plugins
from snowmpm.campaigns import untrusted
from snowmpm.draft import FULL, draft, write_text
from snowmpm.errors import InputError, SimulationError, WriteError, shown_line

RECORD, MAPS = "record.json", "maps.npz"
MAPPED = ("peak_depth", "peak_speed", "peak_pressure", "deposit_depth", "arrival_time")
UNWRITTEN = "unwritten"
"""Status of a run whose worker could not write: not the run's fault, and no record of it is kept."""
REFERENCE = "reference_"
"""Begin of the names of numbers that the reference of a scene knows; beside each its relative `_error`."""
TURN = 0.5
"""Seconds between two looks whether another worker has left a run."""


@dataclass(frozen=True)
class Job:
    """hash; base: file of the base scene; changes: of it, by key; results, run: folders; keep: "runs" or "results";
    plugins: (source, SHA-256) of those that the worker loads; mapped: names of the maps that are kept."""

    hash: str
    base: str
    changes: dict = field(repr=False)
    results: str = ""
    run: str = ""
    keep: str = "runs"
    threads: int = 1
    backend: str = "cpu"
    plugins: tuple = ()
    mapped: tuple = MAPPED


def job_of(plan, member, example=False):
    """`Job` of a member of a plan; example: its run folder is kept in any case."""
    options = plan.file.cluster
    return Job(member.hash, str(plan.base(member.variant)), member.changes, str(plan.results(member)),
               str(plan.run(member)), "runs" if example else plan.file.keep, options.threads, options.backend,
               tuple((one.source, one.sha256) for one in plugins.loaded() if one.source))


def read_record(results):
    """What record.json in a folder says, None where there is none."""
    return untrusted.record(Path(results) / RECORD)


def stop_sampling():
    """Stop Dask's profiler of the worker that this runs in, wherever it was started.

    It calls `sys._current_frames` a hundred times a second. Before Python 3.12 that waits for itself without end when
    the garbage collector runs within it (CPython issue 106883): a worker of a calibration hung so.
    """
    from distributed import get_worker

    with contextlib.suppress(ValueError):  # not in a worker
        worker = get_worker()
        sampler = worker.periodic_callbacks.get("profile")
        if sampler is not None:
            worker.loop.add_callback(sampler.stop)


def work(job):
    """Do a job, unless it is done; -> its record: {"status", "reason", "numbers", "work"}."""
    return work_with(job, run_job)


def work_with(job, run_of):
    """Do a job by a function of it -> (`Run`, whether it went on from a checkpoint), unless it is done; -> its record.

    job: as `Job`, at least its hash, results, run, keep and mapped.
    """
    stop_sampling()
    started, results = clock.time(), Path(job.results)
    try:
        while (lock := _locked(results)) is None:  # another worker is at it
            clock.sleep(TURN)
        with lock:
            return read_record(results) or _done(job, run_of, results, started)
    except OSError as error:
        return _unwritten(error, started)


def _locked(folder):
    """Context that locks a folder against other workers; None if one has locked it."""
    from snowmpm.io import FolderLock

    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(FolderLock(folder)).make()
        except InputError:
            return None
        return stack.pop_all()


def _done(job, run_of, results, started):
    """Run, and keep the record; "unwritten" is not kept."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of scenes, once for each of them
            run, resumed = run_of(job)
        record = {"status": "done", "reason": "", "numbers": numbers_of(run), "reasons": reasons_of(run)}
        _write_maps(results / MAPS, run, job.mapped)
        timing = {name: run.summary.get(name) for name in ("wall_time", "processor_time", "particle_steps")}
    except (WriteError, OSError) as error:
        return _unwritten(error, started)
    except MemoryError:
        record, resumed, timing = _failed("out of memory"), False, {}
    except (InputError, SimulationError) as error:
        record, resumed, timing = _failed(str(error)), False, {}
    except Exception as error:  # a fault of the program in one run must not stop the others
        record, resumed, timing = _failed(f"{type(error).__name__}: {error}"), False, {}
    if record["status"] == "done" and job.keep != "runs":
        overwriting.remove_own(job.run)
    record["work"] = {**timing, **_where(started), "resumed": resumed}
    write_text(results / RECORD, json.dumps(record, indent=1))
    return record


def run_job(job):
    """(`Run`, whether it went on from a checkpoint) of a `Job`."""
    start_quietly(job.backend, job.threads)
    from snowmpm.io import checkpoint
    from snowmpm.io.writer import run_file
    from snowmpm.running.loop import run
    from snowmpm.scenes import load_scene

    for source, sha256 in job.plugins:
        plugins.load(source, sha256)
    folder = Path(job.run)
    scene = load_scene(job.base, job.changes)
    if (folder / checkpoint.FILE).exists() or run_file(folder).exists():
        with contextlib.suppress(InputError):  # not to be continued: torn, or of another version
            return run(scene, folder, resume=True), True
    return run(scene, folder), False


def start_quietly(backend, threads):
    """Start Taichi without its message; one that runs is used as it is."""
    from snowmpm.compiler import runtime

    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of other threads than asked for
        runtime.start(backend, threads)


def numbers_of(run):
    """Numbers of a `Run` by name: of hazard mapping, else the last row of its history; also those of a saw test, its
    theories and truth values among them."""
    from snowmpm.io.status import cautions, status_of
    from snowmpm.quantities.saw import BEFORE, THEORY

    found = dict(run.hazard.get("numbers") or run.summary.get("last") or {})
    saw = run.summary.get("saw_test") or {}
    found |= {f"{BEFORE}{name}": value for name, value in saw.items()}
    found |= {f"{BEFORE}{THEORY}{name}": value for name, value in (saw.get("theory") or {}).items()}
    numbers = {name: value if isinstance(value, bool) else float(value) for name, value in found.items()
               if isinstance(value, int | float)}
    numbers |= references_of(run)
    final = not cautions(run) if saw else status_of(run).final  # a saw test ends in motion
    return {"final": bool(final), "end": float(run.summary.get("time", run.times[-1])), **numbers}


def references_of(run):
    """{reference_NAME, its error} of the quantities that the reference of a scene knows; {} of one without."""
    from snowmpm.comparison import open_cases
    from snowmpm.comparison.answers import answer_of

    if not run.complete or not run.scene.get("reference"):
        return {}
    answer = answer_of(open_cases([run.path])[0])
    found = {}
    for one in answer.quantities() if answer else ():
        name = REFERENCE + "_".join("".join(c if c.isalnum() else " " for c in one.name).split())
        found |= {name: float(one.measured), f"{name}_error": float(one.error)}
    return found


def reasons_of(run):
    """{number of a saw test: why it has no value} of a `Run`."""
    from snowmpm.quantities.saw import BEFORE

    reasons = (run.summary.get("saw_test") or {}).get("reasons", {})
    return {f"{BEFORE}{name}": text for name, text in reasons.items()}


def _write_maps(path, run, mapped=MAPPED):
    """Keep the maps of a run, cut to where snow was; none of a run without."""
    found = {name: run.maps[name] for name in mapped if name in run.maps}
    if not found:
        return
    raster = found["peak_depth"]
    rows, columns = np.nonzero(np.nan_to_num(raster.values) > 0.0)
    if not len(rows):
        rows = columns = np.zeros(1, int)
    window = np.s_[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    corner = [run.origin[0] + raster.x0 + raster.cell * (window[1].start - 0.5),
              run.origin[1] + raster.y0 + raster.cell * (window[0].start - 0.5)]
    with draft(path) as part:
        np.savez_compressed(part, corner=np.round(corner, 6), cell=raster.cell,
                            **{name: one.values[window].astype(np.float32) for name, one in found.items()})


def _failed(reason):
    return {"status": "failed", "reason": shown_line(reason.replace("\n", " "), 500), "numbers": {}}


def _unwritten(error, started):
    number = next((one.errno for one in (error, error.__cause__) if isinstance(one, OSError)), None)
    full = number in FULL or number == errno.ENOSPC
    text = "disk full" if full else "cannot write"
    reason = f"{text}: {shown_line(str(error).replace(chr(10), ' '), 300)}"
    return {"status": UNWRITTEN, "reason": reason, "numbers": {}, "work": _where(started)}


def _where(started):
    from distributed.worker import get_worker

    try:
        worker = get_worker().address
    except (ValueError, RuntimeError):  # not on a cluster
        worker = ""
    return {"worker": worker, "host": socket.gethostname(), "process": os.getpid(), "started": started,
            "seconds": clock.time() - started}
