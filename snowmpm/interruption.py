"""Ctrl-C, SIGTERM and the end of a terminal, held back until a step is whole."""

import signal
import threading

ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Interruption:
    """While it is entered, the first signal to end only sets `asked`; a second one raises KeyboardInterrupt at once.

    Signals that the caller ignores stay ignored. Outside the main thread nothing is held back.
    """

    def __init__(self):
        self.asked = False
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
