"""A thread that writes files, so that the solver does not wait for compression and disk."""

import queue
import threading
import time as clock

ROOM = 1
"""Largest number of waiting jobs, besides the current one: each holds a copy of the particles."""


class Background:
    """Runs jobs (functions without arguments) one after another in a thread of its own, in order of arrival.

    After a failed job no other is run, because later jobs rely on it. The next `do`, `wait` or `close` raises its
    error. work: seconds that the thread has worked.
    """

    def __init__(self):
        self.work = 0.0
        self._jobs = queue.Queue(ROOM)
        self._error = None
        # Every job leaves whole files, or none: the program may end in the middle of one
        self._thread = threading.Thread(target=self._do_jobs, name="snowmpm writer", daemon=True)
        self._thread.start()

    def do(self, job):
        """Hand over a job; waits while the queue is full."""
        self._raise()
        self._jobs.put(job)

    def wait(self):
        """Wait until every job is done."""
        self._jobs.join()
        self._raise()

    def close(self):
        """Wait for the jobs and end the thread; jobs handed over later never run."""
        if self._thread.is_alive():
            self._jobs.put(None)
            self._thread.join()
        self._raise()

    def _do_jobs(self):
        while (job := self._jobs.get()) is not None:
            began = clock.perf_counter()
            try:
                if self._error is None:
                    job()
            except BaseException as error:
                self._error = error
            finally:
                del job  # its copy of the particles, before the next one is waited for
                self.work += clock.perf_counter() - began
                self._jobs.task_done()
        self._jobs.task_done()

    def _raise(self):
        if self._error is not None:
            raise self._error
