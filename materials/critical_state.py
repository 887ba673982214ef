"""What the Cam-Clay laws share: ellipse, hardening variable, initial state, derived fields."""

from typing import ClassVar

import numpy as np

from .law import Law, NonNegative, Positive


class CriticalStateLaw(Law):
    """Yield ellipse in (p, q) whose size is the preconsolidation pressure p₀ [Pa]:

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0
        p₀ = K sinh(ξ max(ζ, 0)),   initially ζ₀ = asinh(p₀/K) / ξ

    ξ = 0 is perfect plasticity: p₀ keeps its value. β <= 1: no stronger in tension than in compression.
    """

    OUTPUTS: ClassVar[dict[str, str]] = {"p0": "Pa", "damage": "-"}

    critical_slope: Positive  # M, q/p at critical state for β = 0 [-]
    hardening: NonNegative  # ξ [-]
    p0: NonNegative  # initial p₀ [Pa]

    @property
    def beta(self):
        """β: tensile strength (apex of the ellipse at p = −β p₀) over compressive strength [-]."""
        return 0.0

    @property
    def initial_zeta(self):
        """ζ₀ [-]"""
        return float(np.arcsinh(self.p0 / self.bulk_modulus) / self.hardening) if self.hardening > 0.0 else 0.0

    def p0_at(self, zeta):
        """p₀ [Pa] at the hardening variable ζ. NumPy."""
        if self.hardening == 0.0:
            return np.full(np.shape(zeta), self.p0)
        return self.bulk_modulus * np.sinh(self.hardening * np.maximum(zeta, 0.0))

    def beta_at(self, state):
        """β that belongs to state (..., n_state). NumPy."""
        return self.beta

    def yield_function(self, p, q, state):
        """y(p, q) [Pa²] at state (..., n_state), <= 0 where admissible. NumPy."""
        state = np.asarray(state)
        p0, beta = self.p0_at(state[..., 0]), self.beta_at(state)
        return (1.0 + 2.0 * beta) * np.square(q) + self.critical_slope**2 * (p + beta * p0) * (p - p0)

    def outputs(self, state):
        """p0 [Pa] and damage, the share of the initial strength that is lost (1: no bonds left)."""
        p0 = self.p0_at(np.asarray(state)[..., 0])
        left = p0 / self.p0 if self.p0 > 0.0 else np.zeros_like(p0)
        return {"p0": p0, "damage": 1.0 - np.clip(left, 0.0, 1.0)}

    def ellipse_parameters(self):
        """K, G, ξ, β, p₀ where it is fixed (ξ = 0) else 0, 3G/M², 6G²/M²: the first numbers of `parameters`."""
        K, G, slope2 = self.bulk_modulus, self.shear_modulus, self.critical_slope**2
        fixed = self.p0 if self.hardening == 0.0 else 0.0
        return K, G, self.hardening, self.beta, fixed, 3.0 * G / slope2, 6.0 * G * G / slope2
