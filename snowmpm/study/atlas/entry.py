"""One entry of the atlas: a failure, the smallest scene that shows it, and where it begins."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from snowmpm.measured.borders import Border

RESOLUTION = 0.02
"""To which a border is bisected, over itself."""

WORST = 1e6
"""What counts for a symptom beyond it, or of a run that failed."""


@dataclass(frozen=True)
class Entry:
    """A failure as a number over one parameter and some settings.

    scene, seen, cure: words for the page; parameter, unit: of the abscissa; values: of the map, ascending; settings:
    {label: arguments of `measure`}; symptom: what `measure(value, **setting)` gives, and `limit`: from where on it
    counts as a failure; fails: "above" or "below" the border; shown, cured: labels of a setting that fails and of one
    that does not where the first does (None where no setting cures it, only a value on the other side); resolution: to
    which a border is bisected, over itself.
    """

    name: str
    title: str
    scene: str
    seen: str
    cure: str
    parameter: str
    unit: str
    values: tuple
    settings: dict
    symptom: str
    limit: float
    measure: Callable
    shown: str
    cured: str | None = None
    fails: str = "above"
    resolution: float = RESOLUTION

    @property
    def words(self):
        """What its `Border`s say of it."""
        return {"title": self.title, "parameter": self.parameter, "unit": self.unit, "cure": self.cure}

    def symptom_at(self, value, setting):
        """The symptom, at most `WORST`; also for a symptom that is not a number."""
        found = abs(self.measure(value, **self.settings[setting]))
        return min(found, WORST) if math.isfinite(found) else WORST

    def fails_at(self, value, setting):
        return self.symptom_at(value, setting) > self.limit

    def row(self, setting):
        """Symptoms over `values`."""
        return [self.symptom_at(value, setting) for value in self.values]

    def border(self, setting, symptoms):
        """`Border` of a setting whose `row` is known: the first failing value, bisected."""
        above = self.fails == "above"
        order = list(zip(self.values, symptoms, strict=True))[:: 1 if above else -1]
        found = {"entry": self.name, "setting": setting, "fails": self.fails, "lowest": float(self.values[0]),
                 "highest": float(self.values[-1]), **self.words}
        first = next((k for k, (_, symptom) in enumerate(order) if symptom > self.limit), None)
        if first is None or first == 0:
            return Border(value=None, held=first is None, **found)
        good, bad = order[first - 1][0], order[first][0]
        geometric = good > 0.0 and bad > 0.0
        while abs(bad - good) > self.resolution * max(abs(good), abs(bad)):
            middle = math.sqrt(good * bad) if geometric else 0.5 * (good + bad)
            if self.fails_at(middle, setting):
                bad = middle
            else:
                good = middle
        return Border(value=float(good), held=False, **found)
