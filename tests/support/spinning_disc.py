"""A disc that spins as a rigid body (M2), and the stress that turns it round."""

import numpy as np

from snowmpm.materials import Elastic

RADIUS, DX, OMEGA = 0.2, 0.02, 1.0
LAW = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3)


def turning_stress(x):
    """Stress (n, 4) [Pa] and strain of the disc under its centrifugal load."""
    nu, r2 = LAW.poisson_ratio, (x**2).sum(axis=1)
    k = LAW.density * OMEGA**2 / (8 * (1 - nu))
    radial = k * (3 - 2 * nu) * (RADIUS**2 - r2)
    hoop = k * ((3 - 2 * nu) * RADIUS**2 - (1 + 2 * nu) * r2)
    c, s = (x / np.sqrt(r2)[:, None]).T
    stress = np.stack([radial * c**2 + hoop * s**2, radial * s**2 + hoop * c**2, nu * (radial + hoop),
                       (radial - hoop) * c * s], axis=1)
    strain = (1 + nu) * stress
    strain[:, :3] -= nu * stress[:, :3].sum(axis=1, keepdims=True)
    return stress, strain / LAW.youngs_modulus
