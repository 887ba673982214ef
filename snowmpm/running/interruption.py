"""Ctrl-C, SIGTERM, SIGHUP (closed terminal) and, on Windows, Ctrl-Break, delayed until a step is complete."""

import contextlib
import signal
import threading

ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]


PATIENCE = 2
"""Number of requests after which the next one ends the process at once."""

_requests: list[float] = []


@contextlib.contextmanager
def requests_to_end():
    """Context: each of these signals raises KeyboardInterrupt, unless the caller handles or ignores it.

    Each signal is also remembered: Python drops an exception raised in a finaliser or a callback, of which compiling a
    kernel has many. A run then ends before its first step (`Interruption`).
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
        # The running code swallows the exceptions, as a library with callbacks does: let the system end the process
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    raise KeyboardInterrupt


class Interruption:
    """Context: the first signal to end only sets `asked`; a second one raises KeyboardInterrupt at once.

    Signals that the caller ignores stay ignored. Outside the main thread nothing is delayed.
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
