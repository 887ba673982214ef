"""From particles in space to columns in plan.

All particles of a body over a square in plan become one column: a square is the share of a cell that a column has at
the start. It lies at their centre of mass and moves at their mean velocity in plan, so that mass, centre of mass and
momentum in plan stay to round-off. What gets lost is the motion that columns do not have (differences of velocity over
the depth and within a square, motion off the ground, affine motion) and elastic energy.
"""

import numpy as np

from snowmpm.handover.handed import Handed, first_numbers
from snowmpm.handover.heaps import Heaps
from snowmpm.particles.population import Population


def gathered(fields, start, side, n_bodies):
    """`Handed` columns of particles.

    fields: `particles.fields.ParticleFields`; start (numbers, 3) [m]: where each was at time zero, by number; side [m]:
    of a column's square.
    """
    position, body = fields["position"], fields["body"]
    volume = fields.column("volume")[:, 0]
    heaps = Heaps(position[:, :2], volume, fields["velocity"], np.column_stack([position[:, 2], start[fields["id"]]]),
                  body).merged(side)
    material = np.zeros(n_bodies, int)
    material[body] = fields["material"]
    population = Population(np.column_stack([heaps.plan, heaps.more[:, 0]]), heaps.volume, material[heaps.body],
                            heaps.velocity)
    return Handed(population, first_numbers(heaps.body, n_bodies), heaps.more[:, 1:])
