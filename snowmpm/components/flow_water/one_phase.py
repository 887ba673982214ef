"""Water that moves with the snow of a depth-averaged flow: what columns hold, and what their skeleton bears."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FlowWater:
    """Water of a scene's columns.

    water (materials,): mass of water in a volume of snow [kg/m3]; grains (materials,): share of the volume [-]; dry
    (materials,): mass of the grains in a volume [kg/m3]. density: of water [kg/m3]; level: depth of the water over that
    of the snow, above 0; consolidation: c_v [m2/s]; excess: share of the weight that the skeleton would bear which the
    pressure at the ground bears at the start; layers: of the mesh over the depth; drained: plan places (n, 2) -> bool
    (n,), whether the ground lets water out; gravity: [m/s2].
    """

    water: np.ndarray
    grains: np.ndarray
    dry: np.ndarray
    density: float
    level: float
    consolidation: float
    excess: float
    layers: int
    drained: Callable
    gravity: float

    @property
    def buoyant(self):
        """rho' (materials,) [kg/m3]: the skeleton bears rho' N h at the ground under hydrostatic water."""
        return self.dry + self.water - self.level * self.density

    @property
    def hydrostatic(self):
        """Pressure at the ground of hydrostatic water over N h (materials,) [kg/m3]."""
        return np.full(len(self.dry), self.level * self.density)

    @property
    def overburden(self):
        """Share of it (materials,) that lies above the water: snow and no buoyancy."""
        return self.dry * (1.0 - self.level) / self.buoyant

    def borne(self, material, thickness, time):
        """Share of the weight (n,) that the skeleton of snow of a material (n,) and thickness (n,) [m] bears after a
        time [s] without change of load, by the slowest part of the pressure over a sealed ground."""
        share = (self.buoyant / (self.dry + self.water))[material]
        return share * (1.0 - self.excess * np.exp(-self.slowest(thickness) * time))

    def slowest(self, thickness):
        """Rate [1/s] at which the slowest part of the pressure falls over a sealed ground, of thickness (n,) [m]."""
        return self.consolidation * (0.5 * math.pi / (self.level * thickness)) ** 2
