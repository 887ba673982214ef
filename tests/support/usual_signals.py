"""Signals as a program in the foreground meets them: one that a shell starts in the background ignores Ctrl-C."""

import contextlib
import signal

HANDLERS = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL, signal.SIGHUP: signal.SIG_DFL}


@contextlib.contextmanager
def usual_signals():
    """While it is entered, no signal is ignored, here and in programs that are started."""
    before = {number: signal.signal(number, handler) for number, handler in HANDLERS.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
