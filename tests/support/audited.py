"""The audit of a solver that no simulation holds."""

import numpy as np

from snowmpm.particles.fields import ParticleFields
from snowmpm.running.audit import Audit


def audit_of(solver):
    fields = ParticleFields(solver.particles)
    start = np.empty_like(fields["position"])
    start[fields["id"]] = fields["position"]
    direction = np.eye(solver.dim - 1)[0]
    return Audit(solver, fields, direction, start)
