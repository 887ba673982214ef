"""The largest stable step and what limits it.

    elastic      dt <= C dx / c,     c = c_0 sqrt(1 + e),  c_0 = sqrt((K + 4G/3) / rho_0)
    advective    dt <= C dx / |v|
    deformation  dt <= 0.3 / |grad v|,  0.8 / |grad v| for snow without stress

with e the largest elastic compression (Hencky strain): the speed of a wave seen on the grid is sqrt(M (1 - ln F) /
rho_0), hence the factor sqrt(1 + e). Laws that stiffen (`Law.stiffness`) report the c of their state, if it is larger.
"""

import math
from dataclasses import dataclass

DEFORMATION_LIMIT = 0.3
"""Largest |dt grad v| of a step (Frobenius norm): f = I + dt grad v must not turn a particle inside out."""

FREE_LIMIT = 0.8
"""The same for a grain that carries no stress: only its volume follows from it, to |dt grad v|^3 / 6 a step. One grain
in the air would else set the step of all. Below 1 I + dt grad v cannot turn it inside out."""


@dataclass(frozen=True)
class Extremes:
    """What a step leaves behind for the choice of the next one."""

    speed: float = 0.0
    """Largest particle speed [m/s]."""
    gradient: float = 0.0
    """Largest |grad v| [1/s]; that of grains without stress counts DEFORMATION_LIMIT / FREE_LIMIT of it."""
    elastic_deviation: float = 0.0
    """Largest |be - I| [-]."""
    wave_speed: float = 0.0
    """Largest wave speed of the laws that stiffen, at their present state [m/s]."""


def stable_step(dx, cfl, wave_speed, extremes):
    """-> (dt [s], cause): the smallest of the three limits. wave_speed: c_0 of the stiffest material [m/s]."""
    wave_speed = max(wave_speed, extremes.wave_speed)
    compression = -0.5 * math.log(max(1.0 - extremes.elastic_deviation, 0.01))
    limits = {
        "elastic": cfl * dx / (wave_speed * math.sqrt(1.0 + compression)),
        "advective": cfl * dx / extremes.speed if extremes.speed > 0.0 else math.inf,
        "deformation": DEFORMATION_LIMIT / extremes.gradient if extremes.gradient > 0.0 else math.inf,
    }
    cause = min(limits, key=limits.get)
    return limits[cause], cause
