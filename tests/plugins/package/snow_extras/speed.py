"""A field of particles: the magnitude of their velocity."""

import numpy as np

import snowmpm
from snowmpm.particles.fields import ParticleField

snowmpm.register(ParticleField("speed", "m/s", lambda fields: np.linalg.norm(fields["velocity"], axis=1)))
