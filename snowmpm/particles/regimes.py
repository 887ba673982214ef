"""How fast grains are sheared for the pressure on them: rate, inertial number, regime.

    rate = sqrt(2 D':D'),   I = rate d sqrt(rho_s / p),   phi(I) = phi_max - (phi_max - phi_min) I

(GDR MiDi 2004, doi:10.1140/epje/i2003-10153-0; Jop, Forterre and Pouliquen 2006, doi:10.1038/nature04801). In simple
shear the rate is the shear rate. phi(I) is the share of the volume that grains take in steady flow, phi_max and phi_min
those of glass beads (Pouliquen, Cassar, Jop, Forterre and Nicolas 2006, doi:10.1088/1742-5468/2006/07/P07020).
"""

import numpy as np
from numpy.typing import ArrayLike

from snowmpm.annotations import Floats

DENSE, COLLISIONAL = 1e-3, 1e-1
"""I from which on a flow is dense, and collisional."""

DENSEST, LOOSEST = 0.6, 0.5
"""phi_max and phi_min of glass beads."""

NO_GRAINS, QUASI_STATIC, DENSE_FLOW, COLLISIONAL_FLOW = range(4)
"""Numbers of the regimes: no grains or none that press, quasi-static, dense, collisional."""


def strain_rate(gradient: Floats) -> Floats:
    """sqrt(2 D':D') [1/s] (n,) of velocity gradients (n, dim * dim) [1/s], row major; in 2-D of plane strain."""
    n, dim = len(gradient), round(gradient.shape[1] ** 0.5)
    L = np.asarray(gradient).reshape(n, dim, dim)
    D = 0.5 * (L + L.transpose(0, 2, 1))
    trace = np.trace(D, axis1=1, axis2=2)
    square = np.maximum((D**2).sum(axis=(1, 2)) - trace**2 / 3.0, 0.0)
    return np.asarray(np.sqrt(2.0 * square))


def inertial_number(rate: Floats, p: Floats, diameter: Floats, density: Floats) -> Floats:
    """I (n,) of rates [1/s], pressures [Pa], and diameters [m] and densities [kg/m3] of grains; 0 for p <= 0."""
    root = np.sqrt(np.divide(density, p, out=np.zeros(len(rate)), where=p > 0.0))
    return np.asarray(rate * diameter * root)


def regime(number: Floats) -> Floats:
    """Number of the regime (n,) of inertial numbers."""
    return np.where(number > 0.0, 1.0 + np.digitize(number, (DENSE, COLLISIONAL)), float(NO_GRAINS))


def steady_fraction(number: Floats, densest: ArrayLike = DENSEST, loosest: ArrayLike = LOOSEST) -> Floats:
    """phi(I) (n,) of inertial numbers; not below phi_min, which it has at I = 1."""
    most = np.asarray(densest, float)
    return np.asarray(most - (most - np.asarray(loosest, float)) * np.minimum(number, 1.0))
