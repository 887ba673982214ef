"""How a run shows where it is: a live display on a terminal, a line now and then elsewhere.

Both take the run's progress object: time, end_time, dt [s], dt_cause, n_particles, max_speed [m/s], front [m], steps,
wall [s], frames, particle_steps.
"""

import sys
from collections import deque
from contextlib import contextmanager

from snowmpm.cli.wording import count, duration, short

LINE_INTERVAL = 10.0  # s of wall time between lines when not on a terminal
WINDOW = 20.0  # s of wall time over which the present speed is measured
SAMPLE_INTERVAL = 0.5


class Pace:
    """Speed of a run over the last `WINDOW` seconds: particle-steps per second and wall time left."""

    def __init__(self):
        self._samples = deque()  # (wall, simulated time, particle-steps)

    def add(self, progress):
        samples = self._samples
        if samples and progress.wall - samples[-1][0] < SAMPLE_INTERVAL:
            return
        samples.append((progress.wall, progress.time, progress.particle_steps))
        while len(samples) > 2 and progress.wall - samples[1][0] > WINDOW:
            samples.popleft()

    @property
    def speed(self):
        """Particle-steps per second, or None while nothing is known."""
        return self._rate(2)

    def time_left(self, progress):
        """Wall time to the end [s], or None while nothing is known."""
        rate = self._rate(1)
        return (progress.end_time - progress.time) / rate if rate else None

    def _rate(self, column):
        if len(self._samples) < 2:
            return None
        first, last = self._samples[0], self._samples[-1]
        return (last[column] - first[column]) / (last[0] - first[0])


def facts(progress, pace):
    """What both displays tell, in their order."""
    yield f"dt {progress.dt:.2e} s ({progress.dt_cause})"
    yield f"{count(progress.n_particles)} particles"
    yield f"max {progress.max_speed:.3g} m/s"
    yield f"front {_metres(progress.front)}"
    yield f"{short(pace.speed)} particle-steps/s"
    yield f"{duration(pace.time_left(progress))} left"


def _metres(front):
    # A front is nan as long as nothing moves.
    return "-" if front is None or front != front else f"{front:.1f} m"


class Lines:
    """Plain lines: the first call, every `LINE_INTERVAL` of wall time, and the end."""

    def __init__(self, name, stream):
        self._name, self._stream = name, stream
        self._pace = Pace()
        self._due = 0.0

    def __call__(self, progress):
        self._pace.add(progress)
        if progress.wall < self._due and progress.time < progress.end_time:
            return
        self._due = progress.wall + LINE_INTERVAL
        share = progress.time / progress.end_time
        where = f"{self._name}: {progress.time:.3f} of {progress.end_time:g} s ({share:.0%})"
        print(", ".join([where, *facts(progress, self._pace)]), file=self._stream, flush=True)


class Screen:
    """A bar and a line of facts below it, redrawn four times a second."""

    def __init__(self, name):
        self._name = name
        self._pace = Pace()
        self._progress = None

    def __call__(self, progress):
        self._pace.add(progress)
        self._progress = progress

    def __rich__(self):
        from rich.console import Group
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        progress = self._progress
        if progress is None:
            return Text(f"{self._name}: preparing (the first run of a scene also compiles its kernels)")
        bar = Table.grid(padding=(0, 1))
        bar.add_row(
            Text(self._name, style="bold"),
            ProgressBar(total=progress.end_time, completed=progress.time, width=40),
            f"{progress.time:.3f} / {progress.end_time:g} s",
            f"{progress.frames} frames, {duration(progress.wall)}",
        )
        return Group(bar, Text("  ".join(facts(progress, self._pace)), style="dim"))


@contextmanager
def display(name):
    """The callback for a run named `name`, in the form that fits where stderr goes."""
    if not sys.stderr.isatty():
        yield Lines(name, sys.stderr)
        return
    from rich.console import Console
    from rich.live import Live

    screen = Screen(name)
    with Live(screen, console=Console(stderr=True), refresh_per_second=4, get_renderable=lambda: screen):
        yield screen
