"""Saw test against theory: names, sources, and likely reasons why they differ."""

import importlib
import importlib.util
from dataclasses import dataclass

APART = 2.0
"""Ratio of a measured number to theory from which on the likely reason is given."""

FLAT = 10.0
"""Slope [degrees] up to which a test is compared with a theory of flat ground."""


@dataclass(frozen=True)
class Theory:
    """measured, predicted: names in the summary's saw_test and in its theory; label: for a legend; below, above: the
    likely reason if the measured number is far below, or above, the prediction; flat: only for flat ground."""

    measured: str
    predicted: str
    label: str
    below: str
    above: str
    flat: bool = False


THEORIES = (
    Theory("critical_length", "critical_length_energy", "energy, rigid weak layer (Heierli 2008)",
           "it takes the weak layer for rigid, while a real one gives way ahead of the saw and yields there",
           "a cut shorter than half of the slab's thickness is no beam, and sets less energy free than this theory has"
           " it; or the saw is too fast for the crack to begin at the cut of a slow one"),
    Theory("critical_length", "critical_length_strength", "shear strength (Gaume 2017)",
           "it knows shear failure alone: on gentle slopes the weak layer collapses under normal stress first",
           "on steep slopes its length goes to zero as the load comes near the strength; nor does it know which way the"
           " saw goes: downslope, bending works against the shear"),
    Theory("critical_length", "critical_length_weac", "energy, elastic weak layer (WEAC)",
           "WEAC's weak layer bears any stress until its energy is used up; this one yields before, at its strength",
           "the saw may be too fast for the crack to begin at the cut of a slow one"),
    Theory("crack_speed", "collapse_wave_speed", "collapse wave on the flat (Heierli 2005)",
           "the load is little above Maxwell's, so that next to nothing is left to drive the crack, or the column is"
           " too short for a steady speed (about 3 m)",
           "shear along the slope drives the crack beside the collapse", flat=True),
    Theory("fracture_energy", "fracture_energy", "collapse of the whole layer",
           "only a row of cells collapses: draw the layer two cells thick (saw_test.weak_layer.cells)",
           "shear and friction behind the tip add to the work of pure collapse"),
)


@dataclass(frozen=True)
class Compared:
    """A `Theory` beside a measured value and the predicted one."""

    theory: Theory
    measured: float
    predicted: float

    @property
    def ratio(self):
        """Measured over predicted."""
        return self.measured / self.predicted

    @property
    def remark(self):
        """Why they differ; None if they do not."""
        if 1.0 / APART < self.ratio < APART:
            return None
        factor = max(self.ratio, 1.0 / self.ratio)
        side, reason = ("below", self.theory.below) if self.ratio < 1.0 else ("above", self.theory.above)
        return (f"{self.theory.measured.replace('_', ' ')}: a factor of {factor:.1f} {side} {self.theory.label}."
                f" Likely reason: {reason}")


def further_theories(run):
    """{name: value} of theories that a run's summary lacks, as they are too dear for the run itself: WEAC, where it is
    installed (`snowmpm.saw_test.theories`, by name: it reads the scene, of which this layer knows nothing)."""
    if run.saw_test is None or importlib.util.find_spec("weac") is None:
        return {}
    return importlib.import_module("snowmpm.saw_test.theories").further_theories(run)


def compared(found, slope_angle, more=None):
    """`Compared` of all theories with a prediction. found: "saw_test" of a run's summary; slope_angle [degrees];
    more: {name: value} of further theories, such as critical_length_weac [m]."""
    said = {**found.get("theory", {}), **(more or {})}
    pairs = [(one, found.get(one.measured), said.get(one.predicted)) for one in THEORIES]
    return [Compared(one, measured, predicted) for one, measured, predicted in pairs
            if measured and predicted and not (one.flat and abs(slope_angle) > FLAT)]
