"""A thread that writes files, so that the solver does not wait for compression and disk."""

import queue
import threading
import time as clock

ROOM = 1
"""Largest number of waiting jobs, besides the current one: each holds a copy of the particles."""

PATIENCE = 1.0
"""Seconds without a job after which what earlier ones left is finished."""


class Background:
    """Runs jobs (functions without arguments) one after another in a thread of its own, in order of arrival.

    After a failed job no other is run, because later jobs rely on it. The next `do`, `wait` or `close` raises its
    error. finish: a job that completes what earlier ones left for later; it runs when no job has come for `PATIENCE`
    seconds, before `wait` and `close` return, and before jobs that ask for it. work: seconds that the thread has
    worked.
    """

    def __init__(self, finish=lambda: None):
        self.work, self._finish = 0.0, finish
        self._jobs = queue.Queue(ROOM)
        self._error = None
        # Every job leaves whole files, or none: the program may end in the middle of one
        self._thread = threading.Thread(target=self._do_jobs, name="snowmpm writer", daemon=True)
        self._thread.start()

    def do(self, job, finished=False):
        """Hand over a job; waits while the queue is full. finished: what earlier ones left for later comes first."""
        self._raise()
        self._jobs.put(_in_turn(self._finish, job) if finished else job)

    def wait(self):
        """Wait until every job is done and nothing is left for later."""
        self._jobs.put(self._finish)
        self._jobs.join()
        self._raise()

    def close(self):
        """Wait for the jobs and end the thread; jobs handed over later never run."""
        if self._thread.is_alive():
            self._jobs.put(self._finish)
            self._jobs.put(None)
            self._thread.join()
        self._raise()

    def _do_jobs(self):
        idle = True
        while True:
            try:
                job = self._jobs.get(timeout=None if idle else PATIENCE)
            except queue.Empty:
                self._do(self._finish)
                idle = True
                continue
            if job is None:
                break
            idle = False
            self._do(job)
            del job  # its copy of the particles, before the next one is waited for
            self._jobs.task_done()
        self._jobs.task_done()

    def _do(self, job):
        began = clock.perf_counter()
        try:
            if self._error is None:
                job()
        except BaseException as error:
            self._error = error
        finally:
            self.work += clock.perf_counter() - began

    def _raise(self):
        if self._error is not None:
            raise self._error


def _in_turn(first, then):
    def both():
        first()
        then()

    return both
