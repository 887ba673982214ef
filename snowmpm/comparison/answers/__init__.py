"""Reference solutions of scenes, one file each, with source.

An answer is made for a `Case` and has

    SOURCE                    literature
    quantities()  -> [Quantity]              numbers of the run with their reference
    facts()       -> {name: text}            reference facts without a number in the run
    profile()     -> (label, s, height) or None      a line to draw over the profiles [m]
    history()     -> History or None         a curve over time or strain, of the run and of the reference
    centre()      -> (x, y) or None          origin of the distance of a round profile
"""

from snowmpm.comparison.answers.answer import Answer, History
from snowmpm.comparison.answers.cantilever import Cantilever
from snowmpm.comparison.answers.column import PlaneColumn, RoundColumn
from snowmpm.comparison.answers.oedometer import Oedometer
from snowmpm.comparison.answers.slope_stability import SlopeStability
from snowmpm.comparison.answers.wall_thrust import WallThrust

ANSWERS = {"plane_column": PlaneColumn, "round_column": RoundColumn, "cantilever": Cantilever, "oedometer": Oedometer,
           "wall_thrust": WallThrust, "slope_stability": SlopeStability}
"""By the kind that a scene's `reference` names."""


def answer_of(case):
    """The reference solution of a case, or None if its scene names none."""
    reference = case.scene.get("reference")
    return ANSWERS[reference["kind"]](case, reference) if reference else None


__all__ = ["ANSWERS", "Answer", "History", "answer_of"]
