"""Ctrl-C, SIGTERM and the end of a terminal, held back until a step is whole."""

import contextlib
import signal
import threading

ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


PATIENCE = 2
"""Requests after which the next one ends the process at once."""

_requests = []


@contextlib.contextmanager
def requests_to_end():
    """While it is entered, each of these signals raises KeyboardInterrupt, unless the caller handles or ignores it.

    Each is remembered as well: Python forgets one that comes in a finaliser or a callback, of which compiling a kernel
    has many, and a run then ends where it would begin (`Interruption`).
    """
    before = {}
    _requests.clear()
    if threading.current_thread() is threading.main_thread():
        for number in ENDING:
            if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                before[number] = signal.signal(number, _raise)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _requests.clear()


def _raise(number, frame):
    _requests.append(number)
    if len(_requests) > PATIENCE:
        # Whatever goes on forgets what is raised, as a library does that calls back: the system ends it
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    raise KeyboardInterrupt


class Interruption:
    """While it is entered, the first signal to end only sets `asked`; a second one raises KeyboardInterrupt at once.

    Signals that the caller ignores stay ignored. Outside the main thread nothing is held back.
    """

    def __init__(self):
        self.asked = bool(_requests)
        self._before = {}

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                before = signal.getsignal(number)
                if before not in (signal.SIG_IGN, None):
                    self._before[number] = signal.signal(number, self._ask)
        return self

    def _ask(self, number, frame):
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True

    def __exit__(self, *error):
        for number, handler in self._before.items():
            signal.signal(number, handler)
