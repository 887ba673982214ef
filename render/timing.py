"""Which frames of a run a film shows, how often each, and how its time goes beside that of the run."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError

MOST_PICTURES = 100_000
"""Pictures of a film beyond which its speed is taken for a mistake: an hour at 25 a second."""
EVEN = 0.01
"""Share by which the pace of a film may differ from real time and be called so."""


@dataclass(frozen=True)
class Timing:
    """fps: pictures a second of film; speed: simulated seconds in a second of film, None: every frame is one picture;
    begin, end [s]: of the run, None: all of it; every: takes every n-th frame, without a speed."""

    fps: float = 25.0
    speed: float | None = None
    begin: float | None = None
    end: float | None = None
    every: int = 1

    @property
    def chosen(self):
        """Whether anything but the usual is asked for, besides fps."""
        return (self.speed, self.begin, self.end, self.every) != (None, None, None, 1)

    def check(self, path, times):
        """Raise InputError for what a film of these times [s] cannot have."""
        if not self.fps > 0:
            raise InputError.at("fps", self.fps, "must be > 0")
        if self.speed is not None and not self.speed > 0:
            raise InputError.at("speed", self.speed, "must be > 0: simulated seconds in a second of film")
        if self.every < 1:
            raise InputError.at("every", self.every, "must be >= 1")
        if self.speed is not None and self.every > 1:
            raise InputError("--speed chooses the frames, and --every too: give one of them")
        if not len(times):
            return
        last = float(times[-1]) * (1.0 + 1e-9)
        for key, value in (("from", self.begin), ("to", self.end)):
            if value is not None and not 0.0 <= value <= last:
                raise InputError.at(key, value, f"{path} goes from 0 to {times[-1]:g} s")
        begin, end = self._span(times)
        if begin > end:
            raise InputError.at("from", self.begin, f"must be before to = {self.end:g}")
        pictures = 0.0 if self.speed is None else (end - begin) / self.speed * self.fps
        if pictures > MOST_PICTURES:
            raise InputError.at("speed", self.speed, f"makes a film of {pictures:.2g} pictures, over {MOST_PICTURES}")

    def _span(self, times):
        begin = float(times[0]) if self.begin is None else self.begin
        return begin, float(times[-1]) if self.end is None else self.end

    def frames(self, times):
        """Numbers of the frames of times (n,) [s], picture by picture; with a speed some come more than once, and
        others never."""
        times = np.asarray(times, float)
        begin, end = self._span(times)
        if self.speed is None:
            slack = 1e-9 * max(1.0, end)
            inside = np.flatnonzero((times >= begin - slack) & (times <= end + slack))
            return (inside if len(inside) else np.array([_nearest(times, begin)]))[:: self.every]
        count = 1 + int(np.floor((end - begin) / self.speed * self.fps * (1.0 + 1e-9)))
        return _nearest(times, begin + np.arange(count) * self.speed / self.fps)

    def pace(self, times):
        """Simulated seconds in a second of this film; None of a single picture."""
        if self.speed is not None:
            return self.speed
        shown = np.asarray(times, float)[self.frames(times)]
        return float(np.median(np.diff(shown))) * self.fps if len(shown) > 1 else None


def _nearest(times, wanted):
    """Numbers of the times nearest to those wanted."""
    after = np.clip(np.searchsorted(times, wanted), 1, max(len(times) - 1, 1))
    before = after - 1
    if len(times) == 1:
        return np.zeros_like(before)
    return np.where(wanted - times[before] <= times[after] - wanted, before, after)


def pace_in_words(pace):
    """ "real time", or how many times that; "" of no film."""
    if pace is None:
        return ""
    if abs(pace - 1.0) <= EVEN:
        return "real time"
    return f"{pace:.3g} times real time"
