"""Failure envelopes of three snows in sigma, tau, fitted to computed grains by Mede et al. (2018), "Snow failure modes
under mixed loading", Geophysical Research Letters, in the form in which weac has them: a line up to (p_T, tau_T), and
from there a quarter of an ellipse to (p_T + p0, 0).

    tau = tau_T (sigma + p0 - p_T) / p0                     sigma <= p_T
    ((sigma - p_T) / p0)^2 + (tau / tau_T)^2 = 1            sigma > p_T

sigma is positive in compression. So p_T is the normal stress at the tip, not a tensile strength, and p_T + p0 the
strength in compression. Where the line meets tau = 0 in tension is an extrapolation. The article itself was not at
hand, weac's code was; its ellipse lacks the scale tau_T, which is put in here.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Envelope:
    """p0, tau_T, p_T [Pa]."""

    p0: float
    tau_T: float
    p_T: float

    @property
    def compression(self):
        """Strength under sigma alone [Pa]."""
        return self.p_T + self.p0

    @property
    def apex(self):
        """Tension [Pa] at which the line has no strength left."""
        return self.p0 - self.p_T

    def on(self, path):
        """(sigma, tau) [Pa] where a load along `path`, (sigma, tau) with tau > 0, meets the envelope."""
        a, b = path
        size = self.apex / (b * self.p0 / self.tau_T - a)
        if not 0.0 < size * a <= self.p_T and a > 0.0:
            terms = [(a / self.p0) ** 2 + (b / self.tau_T) ** 2, -2.0 * a * self.p_T / self.p0**2,
                     (self.p_T / self.p0) ** 2 - 1.0]
            size = np.roots(terms).max()
        return size * np.array([a, b])


MEDE = {"RG1": Envelope(7.00e3, 3.53e3, 1.49e3), "RG2": Envelope(2.33e3, 1.22e3, 0.19e3),
        "FC/DH": Envelope(1.45e3, 0.61e3, 0.17e3)}
"""Two of rounded grains, one of faceted crystals and depth hoar."""
