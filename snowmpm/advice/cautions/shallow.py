"""Rules: where a depth-averaged flow is not shallow, along the paths of blocks that slide down from the release."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS

MOST_BEND = 0.2
"""Depth over radius of curvature of the ground, from which terms that the equations leave out are no longer small.
Chosen: they neglect it against 1 (Savage and Hutter, 1991, doi:10.1007/BF01175958)."""
STEEPEST = 60.0
"""Slope [degrees] from which snow falls rather than slides. Chosen: the snow is then twice as deep vertically as it is
thick."""

PLAN = [name for name, entry in METHODS.items() if entry.capabilities.plan]


@rule(*PLAN)
def not_shallow(facts):
    """A ground that bends too sharply, is too steep or drops away under the flow."""
    course = facts.forecast.course
    if course is None:
        return
    cure = 'compute that part in three dimensions (solver.method = "mpm"), or smooth the terrain'
    if course.bend > MOST_BEND:
        yield Caution("", "terrain", f"on the way down, the release is {course.bend:.2g} of the ground's radius of"
                      f" curvature deep (border {MOST_BEND:g}): a depth-averaged flow must be thin against it", cure)
    if course.slope > STEEPEST:
        yield Caution("", "terrain", f"the way down is up to {course.slope:.0f} degrees steep (border {STEEPEST:g}):"
                      " there snow falls, and depth-averaged it slides", cure)
    if course.lift > 1.0:
        yield Caution("", "terrain", f"at a step, the ground would have to pull the snow down with"
                      f" {course.lift - 1.0:.2g} of its weight: there snow flies, and depth-averaged it follows the"
                      " ground without friction", cure)
