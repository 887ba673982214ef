"""Dams that break at x = 0: the theory of shallow water.

With g_z = g cos(zeta), m0 = g_z (tan zeta - tan delta), c = sqrt(g_z h0) on a plane at zeta with friction delta, x
along it and h normal to it:

    h = (2 c - x/t + m0 t/2)^2 / (9 g_z)  from  m0 t/2 - c  to  m0 t/2 + 2 c = x/t      (zeta = delta = 0: Ritter)

On a wet bed (Stoker), the fan ends at a plateau, and that at a shock.
"""

from dataclasses import dataclass

import numpy as np

from tests.support.depth_flows import G


@dataclass(frozen=True)
class DryDam:
    """Snow 1 m deep on a plane, both angles in degrees."""

    slope: float = 0.0
    friction: float = 0.0

    @property
    def g_z(self):
        return G * np.cos(np.radians(self.slope))

    @property
    def drive(self):
        """m0 [m/s2]"""
        return self.g_z * (np.tan(np.radians(self.slope)) - np.tan(np.radians(self.friction)))

    def place(self, depth, time):
        """x at which the flow is so deep; depth 0: the front."""
        c = np.sqrt(self.g_z)
        return time * (2.0 * c + 0.5 * self.drive * time - 3.0 * np.sqrt(self.g_z * depth))

    def depth(self, x, time):
        fan = np.clip(x, self.place(1.0, time), self.place(0.0, time))
        return ((self.place(0.0, time) - fan) / time) ** 2 / (9.0 * self.g_z)


@dataclass(frozen=True)
class WetDam:
    """1 m of snow beside 0.1 m, on the flat, without friction."""

    plateau: float = 0.396175
    speed: float = 2.321355
    shock: float = 3.105134
    ahead: float = 0.1

    @property
    def end_of_fan(self):
        """x/t"""
        return self.speed - np.sqrt(G * self.plateau)

    def depth(self, x, time):
        z, c = x / time, np.sqrt(G)
        fan = (2.0 * c - np.clip(z, -c, self.end_of_fan)) ** 2 / (9.0 * G)
        return np.where(z < self.end_of_fan, fan, np.where(z < self.shock, self.plateau, self.ahead))
