"""Water and grains of a depth-averaged flow with columns of their own."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.components.flow_water.one_phase import FlowWater


@dataclass(frozen=True)
class TwoPhaseWater(FlowWater):
    """`FlowWater` of materials that come in pairs, first those of grains and then, in the same order, those of the
    water in their pores. A volume is that of the grains or of the water alone.

    grain_density: of the grains [kg/m3], above that of water; porosity (materials / 2,): at the start; drag: law of
    `water.drag`.
    """

    grain_density: float
    porosity: np.ndarray
    drag: Any

    @classmethod
    def of(cls, porosity, grain_density, drag, *, density, consolidation, excess, layers, drained, gravity):
        """Of the porosities (k,) of k materials."""
        none = np.zeros(len(porosity))
        return cls(np.append(none, none + density), np.append(1.0 - porosity, 1.0 - porosity),
                   np.append(none + grain_density, none), density, 1.0, consolidation, excess, layers, drained, gravity,
                   grain_density, np.asarray(porosity, float), drag)

    @property
    def second(self):
        """Whether each material is water."""
        return np.arange(len(self.dry)) >= len(self.porosity)

    @property
    def buoyant(self):
        """rho_s - rho_w: grains bear that times N h_s at the ground. Columns of water know what grains there bear."""
        return np.full(len(self.dry), self.grain_density - self.density)

    @property
    def overburden(self):
        """No grains lie above the water."""
        return np.zeros(len(self.dry))

    @property
    def hydrostatic(self):
        """Density of water over the share of the grains in the depth (materials,) [kg/m3], at the start."""
        return self.density / np.tile(1.0 - self.porosity, 2)

    def borne(self, material, thickness, time):
        """As `FlowWater.borne`, of grains and water that move together."""
        n = self.porosity[material % len(self.porosity)]
        weight = (1.0 - n) * (self.grain_density - self.density)
        return weight / (weight + self.density) * (1.0 - self.excess * np.exp(-self.slowest(thickness) * time))
