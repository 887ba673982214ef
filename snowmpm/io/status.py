"""Whether the numbers of a run are final: it reached its end, the snow is at rest, and none of it left the model.

Pictures, maps, vector files, tables and reports all use this status.
"""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm.io.saw_words import not_to_the_end
from snowmpm.quantities.motion import REST_MOMENTUM, REST_SHARE, at_rest
from snowmpm.quantities.quantity import written

END = ("time", "moving_share", "momentum_share", "left_share")
"""State of the run, as stored in the run file on closing."""

LEFT_SHARE = 1e-3
"""Share of the initial mass above which mass that left the model is reported."""


@dataclass(frozen=True)
class Status:
    """Status of the end of a run.

    complete: the program reached the end of the scene; time, end_time [s] (end_time None: not known); moving_share,
    momentum_share (`snowmpm.quantities.motion`; None: an older file does not say); left_share: of the first mass.
    """

    complete: bool
    time: float
    end_time: float | None = None
    moving_share: float | None = None
    momentum_share: float | None = None
    left_share: float = 0.0

    @property
    def at_rest(self):
        """True, False, or None if unknown."""
        if self.moving_share is None:
            return None
        return bool(at_rest(self.moving_share, REST_MOMENTUM if self.momentum_share is None else self.momentum_share))

    @property
    def final(self):
        """Whether run-out, areas and deposit are those of the whole avalanche."""
        return self.complete and self.at_rest is True and self.left_share <= LEFT_SHARE

    @property
    def warnings(self):
        """One sentence for each reason why the numbers are not final."""
        found = []
        if not self.complete:
            end = f" of {self.end_time:g} s" if self.end_time else ""
            found.append(f"The run is not complete: it stands at {self.time:g} s{end}.")
        if self.at_rest is False:
            parts = [f"{written(self.moving_share, 'share')} of the snow is faster than 1 m/s (at rest:"
                     f" {written(REST_SHARE, 'share')})"]
            if self.momentum_share is not None:
                parts.append(f"the momentum is {written(self.momentum_share, 'share')} of its peak (at rest:"
                             f" {written(REST_MOMENTUM, 'share')})")
            found.append(f"Still moving at {self.time:g} s: {', '.join(parts)}.")
        if self.at_rest is None:
            found.append("Whether the snow is at rest is not known: an older version wrote the file.")
        if self.left_share > LEFT_SHARE:
            found.append(f"{written(self.left_share, 'share')} of the mass left the model, over an open side or the"
                         " edge of the terrain.")
        return found

    @property
    def text(self):
        """One line: final, or why not."""
        if self.final:
            return f"final: at rest when it ended, at {self.time:g} s"
        return "NOT FINAL: " + " ".join(self.warnings)

    @property
    def short(self):
        """Short text for a cell of a table."""
        reasons = {"not complete": not self.complete, "still moving": self.at_rest is False,
                   "not known": self.at_rest is None, "mass left": self.left_share > LEFT_SHARE}
        return ", ".join(reason for reason, holds in reasons.items() if holds) or "final"

    @property
    def so_far(self):
        """Suffix of the name of a number: " so far" if it is not final, else ""."""
        return "" if self.final else " so far"

    def record(self):
        """As plain values, for files."""
        return {"final": self.final, "status": self.text, "complete": self.complete, "time": self.time,
                "end_time": self.end_time, "at_rest": self.at_rest, "moving_share": self.moving_share,
                "momentum_share": self.momentum_share, "left_share": self.left_share}


def status_of(run):
    """The `Status` of a `snowmpm.io.Run`: of its end, or of the last row of its history during the run."""
    end = run.provenance.get("end_state")
    if end and all(end.get(name) is not None for name in END):
        return Status(run.complete, end_time=run.provenance.get("end_time"), **{name: end[name] for name in END})
    history, numbers = run.history, run.hazard.get("numbers", {})
    times = run.times if len(run.times) else np.zeros(1)
    mass, removed = history.get("mass", ()), history.get("removed_mass", ())
    # Mass taken by a cut or a removal of the scene is not missing
    gone = (_last(removed) or 0.0) - (_last(history.get("taken_mass", ())) or 0.0) if len(removed) else 0.0
    left = gone / mass[0] if len(mass) and mass[0] > 0.0 else 0.0
    moving, momentum = (_last(history.get(name, ()), numbers.get(name)) for name in ("moving_share", "momentum_share"))
    return Status(run.complete, float(times[-1]), run.provenance.get("end_time"), moving, momentum, float(left))


DRY_SHARE, CLIMB = 0.05, 5.0
"""Share of the thalweg outside of the flow, and climb of its ground [m], above which its length is doubtful."""


def thalweg_doubts(numbers):
    """Sentences on a thalweg, by the numbers of hazard mapping, whose length may not be that of the way of the snow."""
    found = []
    if numbers.get("thalweg_dry", 0.0) > DRY_SHARE:
        found.append(f"{written(numbers['thalweg_dry'], 'share')} of the thalweg lies outside of the flow: run-out and"
                     " travel angle are doubtful.")
    if numbers.get("thalweg_climb", 0.0) > CLIMB:
        found.append(f"The thalweg climbs by {written(numbers['thalweg_climb'], 'm')}: the snow crossed a rise, or went"
                     " round it.")
    return found


def cautions(run):
    """Reasons, one sentence each, why what a picture or a log shows of a `Run` is not final.

    Motion is no such reason for a run without run-out: a saw test ends in motion. Its crack ought to reach the far end.
    """
    status = status_of(run)
    if "runout" not in run.hazard.get("numbers", {}):
        status = replace(status, moving_share=0.0, momentum_share=0.0)
    found = status.warnings
    found += thalweg_doubts(run.hazard.get("numbers", {}))
    crack = run.summary.get("saw_test") and run.saw_test and not_to_the_end(run.summary["saw_test"], run.saw_test)
    return [*found, crack] if crack else found


def _last(values, otherwise=None):
    return float(values[-1]) if len(values) and np.isfinite(values[-1]) else otherwise
