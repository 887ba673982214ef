"""Drag between skeleton and water with a velocity each, and its exact integration over a step.

    force on the water per volume: -C (w - v), on the skeleton: +C (w - v)

    Darcy        C = n² mu / K                                     (hydraulic conductivity K rho_w g / mu)
    Forchheimer  C = n² mu / K + 1.75 n³ rho_w (1 - n) / (d n³) |w - v|          (Ergun 1952)
    Anderson     C = n (1 - n) (rho_s - rho_w) g / (V_T n^m), V_T the terminal velocity of a grain, m about 1.7 to 4.6
                 (Anderson & Jackson 1967, doi:10.1021/i160024a007, in the form of Pastor et al. 2020, eqs. 37, 40)
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from snowmpm.annotations import Floats


@dataclass(frozen=True)
class Darcy:
    """mobility: K / mu [m2/(Pa s)]."""

    mobility: float

    def coefficient(self, porosity: Floats, slip: Floats) -> Floats:
        """C [Pa s/m2] at the porosity n and |w - v| [m/s]."""
        return porosity**2 / self.mobility + 0.0 * slip


@dataclass(frozen=True)
class DarcyOfPorosity:
    """mobility: function of the porosity -> K / mu [m2/(Pa s)]."""

    mobility: Callable

    def coefficient(self, porosity: Floats, slip: Floats) -> Floats:
        """C [Pa s/m2] at the porosity n and |w - v| [m/s]."""
        return porosity**2 / self.mobility(porosity) + 0.0 * slip


@dataclass(frozen=True)
class Forchheimer(Darcy):
    """grain_size: d [m]; density: rho_w [kg/m3]."""

    grain_size: float
    density: float = 1000.0

    def coefficient(self, porosity: Floats, slip: Floats) -> Floats:
        """C [Pa s/m2] at the porosity n and |w - v| [m/s]."""
        return super().coefficient(porosity, slip) + _ergun(self.density, self.grain_size, porosity, slip)


@dataclass(frozen=True)
class ForchheimerOfPorosity(DarcyOfPorosity):
    """grain_size: d [m]; density: rho_w [kg/m3]."""

    grain_size: float
    density: float = 1000.0

    def coefficient(self, porosity: Floats, slip: Floats) -> Floats:
        """C [Pa s/m2] at the porosity n and |w - v| [m/s]."""
        return super().coefficient(porosity, slip) + _ergun(self.density, self.grain_size, porosity, slip)


def _ergun(density, grain_size, porosity, slip):
    """Part of C that grows with the slip [Pa s/m2]."""
    return 1.75 * density * (1.0 - porosity) / grain_size * np.abs(slip)


@dataclass(frozen=True)
class Anderson:
    """weight: (rho_s - rho_w) g [N/m3]; terminal: V_T [m/s]; power: m [-]."""

    weight: float
    terminal: float
    power: float = 2.0

    def coefficient(self, porosity: Floats, slip: Floats) -> Floats:
        """C [Pa s/m2] at the porosity n and |w - v| [m/s]."""
        return porosity * (1.0 - porosity) * self.weight / (self.terminal * porosity**self.power) + 0.0 * slip


def relaxed(v: Floats, w: Floats, pull_v: Floats, pull_w: Floats, masses: tuple[Floats, Floats], drag: Floats,
            dt: float) -> tuple[Floats, Floats]:
    """Velocities after dt [s] of skeleton v and water w of the masses (m_v, m_w), under constant forces `pull` and the
    drag force drag (w - v):

        u = w - v,   u' = u exp(-l dt) + (a_w - a_v) (1 - exp(-l dt)) / l,   l = drag (1 / m_v + 1 / m_w)

    exact for a drag in proportion to u, for any dt; momentum grows by the forces alone. For one that depends on u, with
    the coefficient of the start, the steady slip is exact.
    """
    m_v, m_w = masses
    rate = drag * (1.0 / m_v + 1.0 / m_w)
    rate_dt = rate * dt
    mean_share = np.where(rate_dt > 1e-12, -np.expm1(-rate_dt) / np.where(rate_dt > 1e-12, rate_dt, 1.0), 1.0)
    slip = (w - v) * np.exp(-rate_dt) + dt * (pull_w / m_w - pull_v / m_v) * mean_share
    mean = (m_v * v + m_w * w + dt * (pull_v + pull_w)) / (m_v + m_w)
    return mean - slip * m_w / (m_v + m_w), mean + slip * m_v / (m_v + m_w)
