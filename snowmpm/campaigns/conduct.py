"""Doing jobs on a cluster: each once, whatever dies.

A worker that dies loses its run's time since the last checkpoint: the scheduler gives the run to another. A worker that
cannot write is sent away, its run given to another. When the scheduler is gone, a new one at the same address is waited
for, and what has no record yet is sent again.
"""

import contextlib
import itertools
import time as clock
from collections import deque

from snowmpm.campaigns.cluster import connect, require_cluster
from snowmpm.campaigns.work import UNWRITTEN
from snowmpm.errors import InputError, SimulationError, WriteError

AHEAD = 4
"""Jobs with the scheduler for each worker: the rest waits here."""

LOOK = 1.0
"""Seconds between two counts of the workers, each of which asks the scheduler."""

GLANCE = 0.005
"""Seconds between two looks at what has come back."""

PATIENCE = 300.0
"""Seconds to wait for a scheduler that is gone, or for a worker where there is none."""


class Lost(Exception):
    """The scheduler is gone."""


class _Waiting:
    """Jobs that wait: those that came back first, then the others, which are not made before they are taken."""

    def __init__(self, jobs):
        self._jobs, self._first = iter(jobs), deque()

    def __bool__(self):
        if not self._first:
            self._first.extend(itertools.islice(self._jobs, 1))
        return bool(self._first)

    def take(self):
        """The next job; there is one."""
        return self._first.popleft()

    def back(self, jobs):
        """Take jobs back, in their order."""
        self._first.extendleft(reversed(list(jobs)))


class Conductor:
    """Sends jobs to a `Site`, and takes what comes back.

    say: called with a line of text when something unusual happens; patience: seconds to wait for a lost scheduler.
    """

    def __init__(self, site, say=print, patience=PATIENCE, gpu=False):
        self._site, self._say, self._patience = site, say, patience
        self._resources = {"GPU": 1} if gpu else None
        self._sent, self._room, self._workers, self._counted = 0, 0, 0, -LOOK

    def results(self, function, jobs):
        """Yield (job, function(job)) as they come, in any order. jobs: iterable, which is not gone through faster than
        they are sent. An exception of `function`, or the death of its
        workers, comes as such. Raises WriteError when no worker can write, SimulationError when the scheduler, or all
        workers, stay away."""
        todo = _Waiting(jobs)
        while todo:
            flying = {}
            try:
                yield from self._session(function, todo, flying)
            except Lost:
                todo.back(flying.values())
                self._reconnect()

    def _session(self, function, todo, flying):
        _, distributed = require_cluster()
        client, coming = self._site.client, distributed.as_completed()
        try:
            self._fill(client, function, todo, flying, coming)
            while flying:
                future = self._next(coming)
                job, status = flying.pop(future), future.status
                if status in ("cancelled", "lost", "pending"):
                    flying[future] = job
                    raise Lost
                outcome = future.exception() if status == "error" else future.result()
                if isinstance(outcome, dict) and outcome.get("status") == UNWRITTEN:
                    self._send_away(client, outcome)
                    todo.back([job])
                else:
                    yield job, outcome
                del future
                self._fill(client, function, todo, flying, coming)
        except (OSError, TimeoutError, distributed.CancelledError) as error:  # a closed connection is an OSError
            raise Lost from error

    def _next(self, coming):
        """The next future that is done. Raises SimulationError when there has been no worker for too long."""
        since = clock.monotonic()
        while not coming.has_ready():
            now = clock.monotonic()
            if now > self._counted + LOOK:
                self._count(now)
                since = since if not self._workers else now
            if now > since + self._patience:
                raise SimulationError(f"no worker for {self._patience:g} s; --resume goes on where it was")
            clock.sleep(GLANCE)
        return next(coming)

    def _count(self, now):
        self._counted, self._workers = now, len(self._site.workers())
        self._site.replace_lost(self._workers)
        self._room = AHEAD * max(1, self._workers)

    def _fill(self, client, function, todo, flying, coming):
        if clock.monotonic() > self._counted + LOOK:
            self._count(clock.monotonic())
        while todo and len(flying) < self._room:
            job = todo.take()
            self._sent += 1
            future = client.submit(function, job, key=f"{function.__name__}-{self._sent}", pure=False,
                                   resources=self._resources)
            flying[future] = job
            coming.add(future)

    def _send_away(self, client, outcome):
        worker = outcome["work"]["worker"]
        there = self._site.workers()
        if worker in there and len(there) == 1:
            raise WriteError(f"{outcome['reason']}\nno worker is left that can write: make room, and --resume goes on")
        if worker in there:
            self._say(f"worker {worker} is sent away: {outcome['reason']}")
            client.retire_workers([worker])

    def _reconnect(self):
        if self._site.address is None:
            raise SimulationError("the cluster of this campaign is gone; --resume goes on where it was")
        _, distributed = require_cluster()
        self._say(f"the scheduler {self._site.address} is gone: waiting {self._patience:g} s for it")
        with contextlib.suppress(Exception):
            self._site.client.close(timeout=1)
        until = clock.monotonic() + self._patience
        while True:
            try:
                self._site.client = connect(distributed, self._site.address, patience=5.0)
                self._say(f"the scheduler {self._site.address} is back")
                return
            except InputError:
                if clock.monotonic() > until:
                    raise SimulationError(f"the scheduler {self._site.address} is gone; --resume completes the campaign"
                                          " when there is one again") from None
                clock.sleep(1.0)
