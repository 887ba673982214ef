"""Progress of a run: a live display on a terminal, plain lines elsewhere. Before the first step, a run reports stages
(`snowmpm.stages`) like any other command.

All displays take the run's progress object: time, end_time, dt [s], dt_cause, n_particles, max_speed [m/s], front [m],
steps, wall [s], frames, particle_steps, audit (the last row of the history: energies [J] by name).
"""

import sys
from collections import deque
from contextlib import contextmanager

from snowmpm.cli import watch
from snowmpm.cli.watch import sentences, unwatched
from snowmpm.cli.wording import count, duration, short, step
from snowmpm.stages import stages

WINDOW = 20.0  # s of wall time over which the current speed is measured
SAMPLE_INTERVAL = 0.5
BAR = 36  # characters
WIDE = 100  # characters: a narrower terminal shows the facts in two columns

ENERGIES = {"kinetic_energy": "kinetic", "elastic_energy": "elastic", "plastic_work": "plastic work",
            "contact_work": "contact"}
"""Energies of the history in the display, in addition to the potential energy lost since the start."""

CAUSES = {"elastic": "elastic waves", "breaking": "bonds that break", "advective": "fastest particle",
          "deformation": "fast deformation", "fixed": "fixed by the scene", "output": "cut to end on a frame"}
"""Causes of the step length in words."""


class Pace:
    """Speed of a run over the last `WINDOW` seconds: particle-steps per second and wall time left."""

    def __init__(self):
        self._samples = deque()  # (wall, simulated time, particle-steps)

    def add(self, progress):
        """Take a sample, at most every `SAMPLE_INTERVAL`."""
        samples = self._samples
        if samples and progress.wall - samples[-1][0] < SAMPLE_INTERVAL:
            return
        samples.append((progress.wall, progress.time, progress.particle_steps))
        while len(samples) > 2 and progress.wall - samples[1][0] > WINDOW:
            samples.popleft()

    @property
    def speed(self):
        """Particle-steps per second, or None while unknown."""
        return self._rate(2)

    def time_left(self, progress):
        """Wall time to the end [s], or None while unknown."""
        rate = self._rate(1)
        return (progress.end_time - progress.time) / rate if rate else None

    def _rate(self, column):
        if len(self._samples) < 2:
            return None
        first, last = self._samples[0], self._samples[-1]
        return (last[column] - first[column]) / (last[0] - first[0])


def _metres(front):
    # The front is nan until something moves.
    return "-" if front is None or front != front else f"{front:.1f} m"


def energies(progress, start):
    """(name, joules) of the energies in the display; `start`: potential energy of the first row, or None."""
    found = {word: progress.audit[name] for name, word in ENERGIES.items() if name in progress.audit}
    if start is not None and "potential_energy" in progress.audit:
        found = {"potential lost": start - progress.audit["potential_energy"], **found}
    return found


class Lines:
    """Plain lines: the first call, every `watch.LINE_INTERVAL` of wall time, and the end; late: nothing of what is
    shorter than an interval."""

    def __init__(self, name, stream, late=False):
        self._name, self._stream = name, stream
        self._pace = Pace()
        self._due, self._begun = watch.LINE_INTERVAL if late else 0.0, not late

    def __call__(self, progress):
        self._pace.add(progress)
        ended = progress.time >= progress.end_time and self._begun
        if progress.wall < self._due and not ended:
            return
        self._due, self._begun = progress.wall + watch.LINE_INTERVAL, True
        share = progress.time / progress.end_time
        where = f"{self._name}: {progress.time:.3f} of {progress.end_time:g} s ({share:.0%})"
        print(", ".join([where, *self._facts(progress)]), file=self._stream, flush=True)

    def _facts(self, progress):
        yield f"dt {progress.dt:.2e} s ({progress.dt_cause})"
        yield f"{count(progress.n_particles)} particles"
        yield f"max {progress.max_speed:.3g} m/s"
        if progress.front is not None:  # saw tests and periodic domains have no front
            yield f"front {_metres(progress.front)}"
        yield f"{short(self._pace.speed)} particle-steps/s"
        yield f"{duration(self._pace.time_left(progress))} left"


class Json:
    """An object a line on stderr, at most every `watch.JSON_INTERVAL` of wall time, and at the end."""

    def __init__(self, name):
        self._name, self._pace, self._due = name, Pace(), 0.0

    def __call__(self, progress):
        self._pace.add(progress)
        if progress.wall < self._due and progress.time < progress.end_time:
            return
        self._due = progress.wall + watch.JSON_INTERVAL
        front, left = progress.front, self._pace.time_left(progress)
        watch.print_json(self._name, share=round(progress.time / progress.end_time, 6), time=progress.time,
                         end_time=progress.end_time, step=progress.dt, particles=progress.n_particles,
                         max_speed=float(progress.max_speed), frames=progress.frames, seconds=round(progress.wall, 3),
                         front=None if front is None or front != front else float(front),
                         seconds_left=None if left is None else round(left, 3))


class Screen:
    """A bar and a table of facts below it, redrawn four times a second."""

    def __init__(self, name):
        self._name = name
        self._pace = Pace()
        self._progress, self._start = None, None

    def __call__(self, progress):
        self._pace.add(progress)
        self._progress = progress
        if self._start is None:
            self._start = progress.audit.get("potential_energy")

    def __rich_console__(self, console, options):
        from rich.text import Text

        progress = self._progress
        if progress is None:
            doing = sentences(stages()) or "preparing (the first run of a scene also compiles its kernels)"
            yield Text(f"{self._name}: {doing}")
            return
        yield self._bar(progress)
        yield self._table(progress, 3 if options.max_width >= WIDE else 2)
        yield self._energies(progress, options.max_width)

    def _bar(self, progress):
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        bar = Table.grid(padding=(0, 1))
        left = duration(self._pace.time_left(progress))
        bar.add_row(
            Text(self._name, style="bold"),
            ProgressBar(total=progress.end_time, completed=progress.time, width=BAR),
            Text(f"{progress.time / progress.end_time:4.0%}", style="bold"),
            Text.assemble((left, "bold cyan"), " left"),
        )
        return bar

    def _table(self, progress, columns):
        from rich.table import Table

        table = Table.grid(padding=(0, 2))
        for _ in range(columns):
            table.add_column(style="dim", min_width=10, no_wrap=True)
            table.add_column(min_width=16, no_wrap=True)
        facts = [("time", f"{progress.time:.3f} / {progress.end_time:g} s"), ("particles", count(progress.n_particles)),
                 ("frames", count(progress.frames)), ("max speed", f"{progress.max_speed:.3g} m/s"),
                 *([("front", _metres(progress.front))] if progress.front is not None else []),
                 ("running", duration(progress.wall)),
                 ("step", step(progress.dt)),
                 ("limited by", CAUSES.get(progress.dt_cause, progress.dt_cause)),
                 ("pace", f"{short(self._pace.speed)} particle-steps/s")]
        for k in range(0, len(facts), columns):
            table.add_row(*(word for fact in facts[k : k + columns] for word in fact))
        return table

    def _energies(self, progress, width):
        """The energies, wrapped between entries."""
        from rich.text import Text

        found = Text("energy", style="dim")
        used = len(found)
        for word, joules in energies(progress, self._start).items():
            number = f"{short(joules)}{'' if short(joules)[-1] in 'kMG' else ' '}J"
            length = 4 + len(word) + len(number)
            if used + length > width:
                found.append("\n      ")
                used = 6
            found.append(f"   {word} ", style="dim").append(number, style="not dim")
            used += length
        return found


@contextmanager
def display(name, quiet=False):
    """The callback for a run named `name`, in the form of `--progress` or what fits where stderr goes; None for no
    output. Plain lines that were asked for come from the first step to the end, for the log of a batch job; quiet:
    nothing, also on a terminal."""
    if quiet or sys.stderr is None:
        yield None
    elif watch.form() is watch.Form.json:
        yield Json(name)
    elif watch.form() is watch.Form.lines:
        yield Lines(name, sys.stderr)
    elif not sys.stderr.isatty():
        yield Lines(name, sys.stderr, late=True)
    else:
        from rich.console import Console
        from rich.live import Live

        screen, console = Screen(name), Console(stderr=True)
        with unwatched(), Live(screen, console=console, refresh_per_second=4, get_renderable=lambda: screen):
            yield screen
