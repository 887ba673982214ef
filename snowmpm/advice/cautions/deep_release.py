"""Rule: a release far deeper than snow lies: centimetres given as metres."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS
from snowmpm.setup.release_plan import release_plan

DEEPEST = 15.0
"""Mean depth of a release [m] beyond which it is taken for a mistake; slabs are 0.2 to 5 m thick."""


@rule(*METHODS)
def deep_release(facts):
    """The mean depth of snow on an elevation model."""
    terrain = facts.scene.terrain
    if terrain is None or terrain.kind != "dem" or facts.scene.dimension != 3:
        return
    area = release_plan(facts.model).area
    depth = facts.model.release_volume / area if area > 0.0 else 0.0
    if depth > DEEPEST:
        yield Caution("", "bodies", f"the release is {depth:.3g} m deep in the mean",
                      "thickness and top are in metres; snow this deep does not release")
