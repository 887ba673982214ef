"""Standing waves of finite strain in a periodic square (M6), with the body force that keeps them in balance.

    u_i = A sin(k π X_i) sin(c π t + φ_i),   k = 2, φ = (0, π),   F_i = 1 + A k π cos(k π X_i) sin(c π t + φ_i)
    τ_i = λ sum_j ln F_j + 2 μ ln F_i,       b_i = π² u_i (k² (λ + 2μ - τ_i) / (ρ F_i²) - c²)

E = 1e4 Pa, nu = 0.3, rho = 1 kg/m3, c = sqrt(E / rho) = 100 /s: after Kamojjala et al. (2015),
doi:10.1007/s00366-013-0342-x, with Hencky elasticity. Each point swings along both axes by itself.
"""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.problems.motion_errors import MotionErrors
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice

LAW = Elastic(density=1.0, youngs_modulus=1e4, poisson_ratio=0.3)
LAMBDA = LAW.bulk_modulus - 2.0 / 3.0 * LAW.shear_modulus
WAVES, RATE, PHASES = 2, 100.0, np.array([0.0, np.pi])
"""k [1/m], c [1/s], φ."""
DURATION = 0.015
"""One and a half half-periods [s]."""


class StandingWaves:
    """Fields of the exact motion at reference positions X (n, 2) [m] and time t [s]; amplitude: A [m]."""

    def __init__(self, amplitude):
        self.amplitude = amplitude

    def displacement(self, X, t):
        return self.amplitude * np.sin(WAVES * np.pi * X) * np.sin(RATE * np.pi * t + PHASES)

    def velocity(self, X, t):
        return self.amplitude * RATE * np.pi * np.sin(WAVES * np.pi * X) * np.cos(RATE * np.pi * t + PHASES)

    def stretch(self, X, t):
        """F_i (n, 2)."""
        swing = np.sin(RATE * np.pi * t + PHASES)
        return 1.0 + self.amplitude * WAVES * np.pi * np.cos(WAVES * np.pi * X) * swing

    def gradient(self, X, t):
        """grad v (n, 4), row major."""
        swing = RATE * np.pi * np.cos(RATE * np.pi * t + PHASES)
        rates = self.amplitude * WAVES * np.pi * np.cos(WAVES * np.pi * X) * swing / self.stretch(X, t)
        return np.stack([rates[:, 0], 0 * rates[:, 0], 0 * rates[:, 0], rates[:, 1]], axis=1)

    def kirchhoff(self, X, t):
        """τ_i (n, 2) [Pa]."""
        strain = np.log(self.stretch(X, t))
        return LAMBDA * strain.sum(axis=1, keepdims=True) + 2.0 * LAW.shear_modulus * strain

    def body_force(self, X, t):
        """b (n, 2) [m/s2]."""
        modulus = LAMBDA + 2.0 * LAW.shear_modulus
        stiffness = WAVES**2 * (modulus - self.kirchhoff(X, t)) / (LAW.density * self.stretch(X, t) ** 2)
        return np.pi**2 * self.displacement(X, t) * (stiffness - RATE**2)


def wave_errors(scheme, cells, amplitude=0.02, per_axis=2, courant=0.2):
    """`MotionErrors` at the end, when the waves stand highest: over A, and over the root mean square of the stress.

    courant: c dt / dx [-]."""
    dx = 1.0 / cells
    positions, volumes = lattice([0.0, 0.0], [1.0, 1.0], dx, per_axis)
    solver = scheme.solver(Population(positions, volumes, 0), [LAW], dx=dx, origin=np.zeros(2), lower=np.zeros(2),
                           upper=np.ones(2), gravity=np.zeros(2), sides=[["periodic", "periodic"]] * 2)
    states, motion = ParticleStates(solver), StandingWaves(amplitude)
    X, steps = states.reference, int(np.ceil(DURATION * LAW.wave_speed() / (courant * dx)))
    dt = DURATION / steps
    states.drive(motion, scheme, steps, dt)
    off = states.positions() - X - motion.displacement(X, DURATION)
    off -= np.round(off)  # round the torus
    exact = motion.kirchhoff(X, DURATION)
    stress = states.column("stress")[:, :2] - exact
    return MotionErrors.of(off, stress, amplitude, np.sqrt((exact**2).sum(axis=1).mean()))
