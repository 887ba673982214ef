"""Progress in a notebook: a bar under the cell that the notebook draws by itself, and keeps when it is saved.

It needs no widget: an element of HTML that is written anew under the same cell.
"""

import contextlib
import html
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from snowmpm.stages import stages

INTERVAL = 0.3
"""Seconds between two looks of the bar."""


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook; IPython is not imported for it."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and "kernel" in shell.trait_names()


class _Bar:
    def __init__(self, name: str) -> None:
        from IPython.display import HTML, display

        self._html, self._name, self._said = HTML, name, ""
        self._begun, self._due = time.perf_counter(), 0.0
        self._handle = display(HTML(self._element(0.0, "preparing")), display_id=True)

    def say(self, share: float | None, words: str, at_once: bool = False) -> None:
        """Show a share, 0 to 1, and words."""
        now = time.perf_counter()
        if now < self._due and not at_once:
            return
        self._due = now + INTERVAL
        element = self._element(share, words)
        if element != self._said:
            self._said = element
            self._handle.update(self._html(element))

    def _element(self, share: float | None, words: str) -> str:
        bar = "" if share is None else f'<progress max="1" value="{share:.4f}" style="width:16em"></progress> '
        number = "" if share is None else f"{share:.0%} "
        return (f'<div style="font-family:sans-serif;font-size:13px"><b>{html.escape(self._name)}</b> {bar}{number}'
                f"{html.escape(words)}</div>")


@contextlib.contextmanager
def bar(name: str, words: Callable[[Any], tuple[float, str]] | None = None) -> Iterator[Callable[[Any], None]]:
    """Context: a callback for progress reports that draws them; words: share and words of a report. Before the first
    report, the bar says what the work is at (`snowmpm.stages`); so it does for work without reports."""
    shown, ended, reported = _Bar(name), threading.Event(), threading.Event()

    def watch() -> None:
        while not ended.wait(INTERVAL):
            found = stages()
            if found and not reported.is_set():
                whole = next((one for one in found if one.total), found[0])
                count = f" {whole.done} of {whole.total} {whole.unit}" if whole.total else ""
                shown.say(whole.share if whole.total else None, f"{whole.what}{count}, {whole.seconds:.0f} s")

    def report(progress: Any) -> None:
        if words is not None:
            reported.set()
            shown.say(*words(progress))

    thread = threading.Thread(target=watch, name="progress", daemon=True)
    thread.start()
    begun, state = time.perf_counter(), "failed after"
    try:
        yield report
        state = "done in"
    except KeyboardInterrupt:
        state = "interrupted after"
        raise
    finally:
        ended.set()
        thread.join()
        shown.say(1.0 if state == "done in" else None, f"{state} {time.perf_counter() - begun:.1f} s", at_once=True)


@contextlib.contextmanager
def run_bar(name: str) -> Iterator[Callable[[Any], None]]:
    """`bar` of a run, whose reports are `snowmpm.running.loop.Progress`."""
    with bar(name, lambda report: (min(report.time / report.end_time, 1.0), (
            f"{report.time:.3g} of {report.end_time:g} s, {report.n_particles} particles, at most"
            f" {report.max_speed:.3g} m/s, {_left(report)}"))) as show:
        yield show


def _left(report: Any) -> str:
    """Time left, as if it went on as it has."""
    share = report.time / report.end_time
    return f"{report.wall * (1.0 / share - 1.0):.0f} s left" if share > 0.02 else f"{report.wall:.0f} s so far"
