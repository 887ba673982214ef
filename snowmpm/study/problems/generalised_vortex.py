"""The generalised vortex of Hencky elasticity (M7): a ring whose circles turn against each other.

    x = Q(α) X,   α(R, t) = A sin(c π t) h(R),   h = (4R - 3)^2 (4R - 5)^2,   3/4 <= R <= 5/4

After Kamojjala et al. (2015), doi:10.1007/s00366-013-0342-x, with the stress of Hencky elasticity: a simple shear by
γ = R dα/dR in the axes (r, θ) that turn with α. h and dh/dR vanish at both edges of the ring, so that they carry no
load. Displacement and slope are far beyond small: A = 0.1 shears by 0.7, A = 1 by 7.
"""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.study.problems.motion_errors import MotionErrors
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import free_solver, lattice

LAW = Elastic(density=1000.0, youngs_modulus=1000.0, poisson_ratio=0.3)
OUTER = 1.25
FREQUENCY = 1.0
"""c [1/s]."""


class Vortex:
    """Fields of the exact motion at reference positions X (n, 2) [m] and time t [s]; amplitude: A [-]."""

    def __init__(self, amplitude):
        self.amplitude = amplitude

    def angle(self, R, t):
        """α [rad]."""
        return self.amplitude * np.sin(FREQUENCY * np.pi * t) * (4 * R - 3) ** 2 * (4 * R - 5) ** 2

    def position(self, X, t):
        return _turned(X, self.angle(np.hypot(*X.T), t))

    def _rates(self, R, t):
        """dα/dt and d2α/(dR dt)."""
        rate = self.amplitude * FREQUENCY * np.pi * np.cos(FREQUENCY * np.pi * t)
        return rate * (4 * R - 3) ** 2 * (4 * R - 5) ** 2, rate * 64 * (R - 1) * (4 * R - 3) * (4 * R - 5)

    def velocity(self, X, t):
        x, (rate, _) = self.position(X, t), self._rates(np.hypot(*X.T), t)
        return rate[:, None] * np.stack([-x[:, 1], x[:, 0]], axis=1)

    def gradient(self, X, t):
        """grad v (n, 2, 2), of v = dα/dt e_z x x: the radius stays, so dR is the same in both configurations."""
        x, R = self.position(X, t), np.hypot(*X.T)
        rate, slope = self._rates(R, t)
        across = np.stack([-x[:, 1], x[:, 0]], axis=1)
        spin = np.array([[0.0, -1.0], [1.0, 0.0]])
        return rate[:, None, None] * spin + (slope / R)[:, None, None] * across[:, :, None] * x[:, None, :]

    def _shear(self, R, t):
        """γ and dγ/dR."""
        S = self.amplitude * np.sin(FREQUENCY * np.pi * t)
        q1 = 64 * (R - 1) * (4 * R - 3) * (4 * R - 5)
        q2 = 64 * (48 * (R - 1) ** 2 - 1)
        return R * S * q1, S * (q1 + R * q2)

    def kirchhoff(self, X, t):
        """τ_xx, τ_yy, τ_xy (n, 3) [Pa]: τ_rθ = μ f, τ_θθ = -τ_rr = μ f γ / 2, in the polar axes of the place x."""
        R = np.hypot(*X.T)
        gamma, mu = self._shear(R, t)[0], LAW.shear_modulus
        shear = mu * 2 * np.arcsinh(gamma / 2) / np.sqrt(1 + gamma**2 / 4)
        hoop = 0.5 * shear * gamma
        c, s = (self.position(X, t) / R[:, None]).T
        return np.stack([hoop * (s**2 - c**2) - 2 * shear * c * s, hoop * (c**2 - s**2) + 2 * shear * c * s,
                         shear * (c**2 - s**2) - 2 * hoop * c * s], axis=1)

    def body_force(self, X, t):
        """b (n, 2) [m/s2]: what keeps the motion in balance."""
        R = np.hypot(*X.T)
        (gamma, slope), mu, rho = self._shear(R, t), LAW.shear_modulus, LAW.density
        a, w = np.arcsinh(gamma / 2), np.sqrt(1 + gamma**2 / 4)
        f, f_slope = 2 * a / w, (1 - a * gamma / (2 * w)) / w**2
        h = (4 * R - 3) ** 2 * (4 * R - 5) ** 2
        S, C = np.sin(FREQUENCY * np.pi * t), np.cos(FREQUENCY * np.pi * t)
        radial = (-R * (self.amplitude * FREQUENCY * np.pi * C * h) ** 2
                  + (mu * (f_slope * gamma + f) * slope / 2 + mu * f * gamma / R) / rho)
        around = (-R * self.amplitude * (FREQUENCY * np.pi) ** 2 * S * h - mu * (f_slope * slope + 2 * f / R) / rho)
        e = X / R[:, None]
        return _turned(radial[:, None] * e + around[:, None] * np.stack([-e[:, 1], e[:, 0]], axis=1), self.angle(R, t))


def vortex_errors(scheme, cells, amplitude=0.1, per_axis=2, courant=0.3):
    """`MotionErrors` at t = 1 s, when all is back: over A R, R = 1 m, and over the root mean square of the stress when
    the ring was turned furthest.

    cells: per metre; courant: c dt / dx [-]. v starts half a step early, as symplectic Euler keeps it: the scheme is
    then second order in time.
    """
    dx = 1.0 / cells
    positions, volumes = lattice([-OUTER - dx, -OUTER - dx], [OUTER + dx, OUTER + dx], dx, per_axis)
    ring = np.abs(np.hypot(*positions.T) - 1.0) < OUTER - 1.0
    solver = free_solver(positions[ring], volumes[ring], LAW, scheme, dx)
    states, motion = ParticleStates(solver), Vortex(amplitude)
    X, steps = states.reference, int(np.ceil(LAW.wave_speed() / (courant * dx)))
    dt = 1.0 / steps
    states.drive(motion, scheme, steps, dt)
    off = states.positions() - motion.position(X, 1.0)
    stress = states.column("stress")[:, [0, 1, 3]] - motion.kirchhoff(X, 1.0)
    turned = motion.kirchhoff(X, 0.5 / FREQUENCY)
    return MotionErrors.of(off, stress, amplitude, np.sqrt((turned**2).sum(axis=1).mean()))


def _turned(vectors, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1)
