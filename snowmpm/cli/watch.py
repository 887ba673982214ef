"""Progress of every command, from its stages (`snowmpm.stages`).

On a terminal, a bar with the time left appears after one second. Elsewhere, a plain line is printed to stderr every
ten seconds; short work prints nothing. A run has its own display (`snowmpm.cli.progress`) and suspends this one.
`--progress json` prints a JSON object a line instead, for programs that show a bar of their own.
"""

import contextlib
import json
import sys
import threading
import time
from enum import Enum

from snowmpm.cli.wording import count, duration
from snowmpm.stages import stages, told

LINE_INTERVAL = 10.0  # s of wall time between plain lines
PATIENCE = 1.0  # s before a stage is shown
GLANCE = 0.25  # s between looks

JSON_INTERVAL = 0.5  # s between JSON objects of one stage


class Form(str, Enum):
    """How progress is shown. auto: a bar on a terminal, elsewhere plain lines, of what takes long."""

    auto = "auto"
    lines = "lines"
    json = "json"


_paused, _printing = threading.Event(), threading.Lock()
_form = Form.auto


def form():
    """The `Form` that the command was asked for."""
    return _form


def ask_for(wanted):
    """Show progress in another `Form` until the command ends."""
    global _form
    _form = wanted


def print_json(what, **facts):
    """Print progress as one line of JSON to stderr: {"progress": what, name: value}; what is not known is left out."""
    known = {name: value for name, value in facts.items() if value is not None}
    line = json.dumps({"progress": what, **known}) + "\n"
    # In one piece: two threads report. A closed pipe must not stop the run
    with _printing, contextlib.suppress(OSError, ValueError):
        if sys.stderr is not None:
            sys.stderr.write(line)
            sys.stderr.flush()


def sentence(now):
    """A stage in words: "drawing: 37 of 120 pictures (31 %), 2 min 10 s left"; without a total, the time so far.
    """
    unit, detail = f" {now.unit}" if now.unit else "", f", {now.detail}" if now.detail else ""
    if now.total:
        left = now.time_left
        share = f" ({now.done / now.total:.0%})".replace("%", " %")
        known = f", {duration(left)} left" if left is not None else f", {duration(now.seconds)} so far"
        return f"{now.what}: {count(now.done)} of {count(now.total)}{unit}{share}{known}{detail}"
    done = f"{count(now.done)}{unit}, " if now.done else ""
    return f"{now.what}: {done}{duration(now.seconds)} so far{detail}"


def sentences(found):
    """All stages in one line."""
    return "; ".join(sentence(now) for now in found)


class _Bar:
    """The bar on a terminal: shown while a stage lasts longer than `PATIENCE`."""

    def __init__(self, stream):
        self._stream, self._progress = stream, None
        self._lock = threading.RLock()

    def look(self, found):
        """Show these stages."""
        with self._lock:
            if not found or found[0].seconds < PATIENCE or _paused.is_set():
                self.end()
                return
            if self._progress is None:
                self._begin()
            whole = next((now for now in found if now.total), found[0])
            inner = "; ".join(now.what for now in found if now is not whole)
            self._progress.update(self._task, description=whole.what, total=whole.total, completed=whole.done,
                                  words=", ".join(filter(None, [sentence(whole).split(": ", 1)[1], inner])))

    def _begin(self):
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

        columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[words]}"))
        self._progress = Progress(*columns, console=Console(file=self._stream), transient=True, redirect_stdout=False,
                                  redirect_stderr=False)
        self._task = self._progress.add_task("", words="")
        self._progress.start()

    def end(self):
        """Remove the bar."""
        with self._lock:
            if self._progress is not None:
                self._progress.stop()
                self._progress = None

    @contextlib.contextmanager
    def making_way(self):
        """Context: the bar is removed before anything is printed on the same terminal, and reappears below it."""
        before = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = (_Above(self, stream) if stream.isatty() else stream for stream in before)
        try:
            yield
        finally:
            self.end()
            sys.stdout, sys.stderr = before


class _Above:
    """A stream to the bar's terminal that removes the bar before it writes."""

    def __init__(self, bar, stream):
        self._bar, self._stream = bar, stream

    def write(self, text):
        """Remove the bar, then write to the stream."""
        self._bar.end()
        return self._stream.write(text)

    def __getattr__(self, name):
        return getattr(self._stream, name)


class _Lines:
    """Plain lines, for output that is no terminal."""

    def __init__(self, interval):
        self._interval, self._due = interval, time.perf_counter() + interval

    def look(self, found):
        """Print a line if one is due."""
        now = time.perf_counter()
        if found and now >= self._due and found[0].seconds >= min(PATIENCE, self._interval):
            self._due = now + self._interval
            with contextlib.suppress(OSError, ValueError):  # a closed pipe must not stop the run
                print(sentences(found), file=sys.stderr, flush=True)

    def end(self):
        """Does nothing: there is no bar."""

    def making_way(self):
        """Does nothing: there is no bar."""
        return contextlib.nullcontext()


class _Json:
    """An object a line whenever a stage begins, and every `JSON_INTERVAL`."""

    def __init__(self):
        self._last, self._due = None, 0.0

    def look(self, found):
        """Print the stages if something new is to be said of them."""
        now = time.perf_counter()
        whole = next((one for one in found if one.total), found[0]) if found else None
        if whole is None or _paused.is_set() or (now < self._due and whole is self._last):
            return
        self._last, self._due = whole, now + JSON_INTERVAL
        detail = "; ".join(filter(None, [whole.detail, *(one.what for one in found if one is not whole)]))
        print_json(whole.what, share=_rounded(whole.share), done=whole.done if whole.total else None, total=whole.total,
                   unit=whole.unit or None, seconds=_rounded(whole.seconds), seconds_left=_rounded(whole.time_left),
                   detail=detail or None)

    def end(self):
        """Does nothing: there is no bar."""

    def making_way(self):
        """Does nothing: there is no bar."""
        return contextlib.nullcontext()


def _rounded(number):
    return None if number is None else round(number, 4)


@contextlib.contextmanager
def watched(quiet=False, interval=None, form=Form.auto):
    """Context: stages of this program are shown on stderr; interval [s]: `LINE_INTERVAL` by default; form: a `Form`."""
    global _form
    interval, before = interval or LINE_INTERVAL, _form
    if quiet or sys.stderr is None:
        yield
        return
    _form = Form(form)
    show = (_Json() if _form is Form.json else
            _Bar(sys.stderr) if sys.stderr.isatty() and _form is Form.auto else _Lines(interval))
    ended = threading.Event()

    def watch():
        while not ended.wait(min(GLANCE, interval)):
            show.look(stages())

    thread = threading.Thread(target=watch, name="progress", daemon=True)
    thread.start()
    try:
        with show.making_way(), told(lambda: stages() or show.end()):
            yield
    finally:
        _form = before
        ended.set()
        thread.join()


@contextlib.contextmanager
def unwatched():
    """Context: another display has the terminal; plain lines continue."""
    _paused.set()
    try:
        yield
    finally:
        _paused.clear()
