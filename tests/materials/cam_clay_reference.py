"""Cam-Clay integrated from its equations alone, with SciPy: nothing of the project's laws is used.

    ḃ = l b + b lᵀ − 2 γ̇ N b,   N = ∂y/∂τ,   ż = γ̇ y_p,   γ̇ from ẏ = 0,   p₀ = K sinh(ξ max(z, 0))

b is followed as ε = ½ ln b only through its eigenvalues at each evaluation, so rotation is exact to the tolerance.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Reference:
    """E, ν, M, β, ξ, p₀(0); SI."""

    youngs_modulus: float
    poisson_ratio: float
    critical_slope: float
    cohesion: float
    hardening: float
    p0: float

    @property
    def moduli(self):
        E, nu = self.youngs_modulus, self.poisson_ratio
        return E / (3.0 * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))

    def size(self, z):
        """p₀ and its derivative at z."""
        K, xi = self.moduli[0], self.hardening
        return K * np.sinh(xi * z), K * xi * np.cosh(xi * z)

    def stress(self, b):
        """τ, p, q of b."""
        K, G = self.moduli
        values, vectors = np.linalg.eigh(b)
        strain = (vectors * (0.5 * np.log(values))) @ vectors.T
        volume = np.trace(strain)
        tau = K * volume * np.eye(3) + 2.0 * G * (strain - volume / 3.0 * np.eye(3))
        p = -np.trace(tau) / 3.0
        s = tau + p * np.eye(3)
        return tau, p, np.sqrt(1.5 * np.sum(s * s))

    def y(self, b, z):
        """Yield function [Pa²]."""
        _, p, q = self.stress(b)
        p0, _ = self.size(z)
        return q**2 * (1 + 2 * self.cohesion) + self.critical_slope**2 * (p + self.cohesion * p0) * (p - p0)

    def rates(self, b, z, gradient, plastic):
        """ḃ, ż under a velocity gradient."""
        K, G = self.moduli
        change = gradient @ b
        change = change + change.T
        if not plastic:
            return change, 0.0
        tau, p, _ = self.stress(b)
        (p0, dp0), beta, slope2 = self.size(z), self.cohesion, self.critical_slope**2
        y_p = slope2 * (2.0 * p - (1.0 - beta) * p0)
        y_p0 = slope2 * ((beta - 1.0) * p - 2.0 * beta * p0)
        N = -y_p / 3.0 * np.eye(3) + 3.0 * (1.0 + 2.0 * beta) * (tau + p * np.eye(3))

        def stiff(a):
            return K * np.trace(a) * np.eye(3) + 2.0 * G * (a - np.trace(a) / 3.0 * np.eye(3))

        d = 0.5 * (gradient + gradient.T)
        # ẏ = N : C : (d − γ̇ N) + y_p0 p₀' γ̇ y_p = 0
        flow = np.sum(N * stiff(d)) / (np.sum(N * stiff(N)) - y_p0 * dp0 * y_p)
        assert flow > -1e-9, "the path of a reference must keep loading once it yields"
        return change - 2.0 * flow * N @ b, flow * y_p

    def integrate(self, velocity_gradient, duration, points=11):
        """τ (n, 3, 3), p, q, z, y/p₀² at n times from 0 to `duration`; velocity_gradient(t) (3, 3)."""
        z0 = np.arcsinh(self.p0 / self.moduli[0]) / self.hardening
        start, times = np.concatenate([np.eye(3).ravel(), [z0]]), np.linspace(0.0, duration, points)

        def right(plastic):
            def function(t, state):
                b, z = state[:9].reshape(3, 3), state[9]
                change, dz = self.rates(0.5 * (b + b.T), z, velocity_gradient(t), plastic)
                return np.concatenate([change.ravel(), [dz]])

            return function

        def yields(t, state):
            return self.y(state[:9].reshape(3, 3), state[9]) / self.p0**2

        yields.terminal, yields.direction = True, 1.0
        options = dict(method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
        # Short first step: without cohesion the stress-free start lies on the surface itself
        elastic = solve_ivp(right(False), (0.0, duration), start, events=yields, first_step=1e-6 * duration, **options)
        at_yield, end = elastic.t[-1], elastic.y[:, -1]
        assert elastic.status == 1, "a reference path must reach yield"
        plastic = solve_ivp(right(True), (at_yield, duration), end, **options)
        states = np.array([(elastic if t <= at_yield else plastic).sol(t) for t in times])
        found = [(*self.stress(s[:9].reshape(3, 3)), s[9], yields(0.0, s)) for s in states]
        return (times, *(np.array(column) for column in zip(*found, strict=True)))
