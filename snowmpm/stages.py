"""What long work is at. Code that takes its time says so here; whoever shows progress looks here.

    with stage("drawing", len(pictures), "pictures") as now:
        for picture in pictures:
            draw(picture)
            now.done += 1

Stages nest. Saying what one is at costs nothing, prints nothing and needs nobody who listens
(`snowmpm.cli.watch` does).
"""

import time
from contextlib import contextmanager

_stages, _listeners = [], []


class Stage:
    """what is done; done of total (None: not known) things named unit; detail: what else is known of it, in words;
    started: time.perf_counter()."""

    def __init__(self, what, total=None, unit=""):
        self.what, self.total, self.unit = what, total, unit
        self.done, self.detail, self.started = 0, "", time.perf_counter()

    @property
    def seconds(self):
        """Wall time since it began [s]."""
        return time.perf_counter() - self.started

    @property
    def share(self):
        """Of the whole, 0 to 1; None while nothing is known."""
        return min(self.done / self.total, 1.0) if self.total and self.done else None

    @property
    def time_left(self):
        """Wall time to the end [s], as if it went on as it has; None while nothing is known."""
        return self.seconds * (1.0 / self.share - 1.0) if self.share else None


@contextmanager
def stage(what, total=None, unit=""):
    """Say that this is being done while it is entered; -> `Stage`, whose `done`, `total` and `detail` may be set."""
    now = Stage(what, total, unit)
    _stages.append(now)
    try:
        yield now
    finally:
        _stages.remove(now)
        _tell()


def counted(items, what, unit=""):
    """The items one after the other, counted as they are done."""
    items = list(items)
    with stage(what, len(items), unit) as now:
        for item in items:
            yield item
            now.done += 1


def stages():
    """What is being done now, the whole before its parts."""
    return tuple(_stages)


@contextmanager
def told(listener):
    """While it is entered, `listener()` is called when a stage has ended."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def _tell():
    for listener in tuple(_listeners):
        listener()
