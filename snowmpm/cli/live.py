"""`snowmpm run --live FILE.html`: the process that draws the page, as the run sees it (`snowmpm.render.live`)."""

import contextlib
import json
import os
import subprocess
import sys

from snowmpm import overwriting
from snowmpm.cli.progress import CAUSES, Pace
from snowmpm.cli.wording import count, duration, short, step
from snowmpm.errors import InputError

INTERVAL = 1.0
"""Seconds of wall time between two messages to the page."""

PATIENCE = 120.0
"""Seconds that the last picture may take before the run no longer waits for it."""

START = """import sys
sys.path[:] = {path!r}
import signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
from snowmpm.render.live import main
main()
"""
"""The program of the other process: its modules are ours; Ctrl-C is for the run, whose end it then draws."""


def check_page(page):
    """Raise InputError for a file that cannot become the page."""
    if page.suffix.lower() != ".html":
        raise InputError(f"--live {page}: must end in .html")
    there = next(parent for parent in page.resolve().parents if parent.exists())
    if page.is_dir() or not there.is_dir() or not os.access(there, os.W_OK):
        raise InputError(f"--live {page}: {there} must be a folder that can be written to")
    overwriting.guard(page)


class Live:
    """The page of a run in `folder`, drawn by another process from `begin` to `end`; a callback for its progress."""

    def __init__(self, page, folder, title):
        self._words = [str(folder), str(page), title]
        self._process, self._pace, self._due = None, Pace(), 0.0

    def begin(self):
        """Start the process."""
        code = START.format(path=sys.path)
        self._process = subprocess.Popen([sys.executable, "-c", code, *self._words], stdin=subprocess.PIPE,
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True)

    def __call__(self, progress):
        self._pace.add(progress)
        ended = progress.time >= progress.end_time
        if self._process is None or (progress.wall < self._due and not ended):
            return
        self._due = progress.wall + INTERVAL
        with contextlib.suppress(OSError):  # a process that was killed must not stop the run
            self._process.stdin.write(json.dumps(facts(progress, self._pace)) + "\n")
            self._process.stdin.flush()

    def end(self):
        """Let the process draw the last picture, and wait for it; -> whether it did."""
        if self._process is None:
            return True
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        try:
            return self._process.wait(PATIENCE) == 0
        except subprocess.TimeoutExpired:
            return False


def facts(progress, pace):
    """{name: text} of a `Progress`, for the page."""
    share = progress.time / progress.end_time
    front = progress.front
    rows = {"time": f"{progress.time:.3f} of {progress.end_time:g} s ({share:.0%})",
            "left": duration(pace.time_left(progress)), "running": duration(progress.wall),
            "step": step(progress.dt), "limited by": CAUSES.get(progress.dt_cause, progress.dt_cause),
            "particles": count(progress.n_particles), "largest speed": f"{progress.max_speed:.3g} m/s"}
    if front is not None and front == front:
        rows["front"] = f"{front:.1f} m"
    return rows | {"particle-steps a second": short(pace.speed)}


@contextlib.contextmanager
def following(live, show):
    """Context: a callback that tells the progress of a run to both `live` (`Live` or None) and `show` (a callback or
    None); at its end the last picture is drawn."""
    if live is None:
        yield show
        return

    def tell(progress):
        live(progress)
        if show:
            show(progress)

    try:
        yield tell
    finally:
        if not live.end():
            print("warning: --live: the process that draws the page failed", file=sys.stderr)
