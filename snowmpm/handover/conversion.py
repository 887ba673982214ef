"""From one method's particles to another's."""

from dataclasses import replace

from snowmpm.handover.filling import filled
from snowmpm.handover.gathering import gathered


def converted(fields, start, before, part, model):
    """`Handed` to the method that takes over: particles in space as columns in plan, or columns as particles.

    fields: `particles.fields.ParticleFields`; start (numbers, 3) [m]: where each was at time zero, by number; before,
    part: scenes of the methods before and after; model: `setup.model.Model` of the whole scene.
    """
    if part.solver.in_plan:
        return gathered(fields, start, part.solver.spacing(3), len(part.bodies))
    return filled(fields, start, model.surface, before.solver.dx, part, replace(model, scene=part).laws)
