"""When a method hands over."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from snowmpm.annotations import Floats
from snowmpm.particles.fields import ParticleFields
from snowmpm.quantities.motion import MOVING_SPEED
from snowmpm.scenes.switch import BROKEN, FLOWING, REACHED, Switch
from snowmpm.seeding.regions import Region, regions_of

LOOK = 20
"""Steps between two looks at the snow, of a moment that follows from it; fewer where it crosses a cell in them."""


class Moment:
    """The moment of a `scenes.switch.Switch`; surface: the terrain. InputError for a region that cannot be."""

    switch: Switch

    def __init__(self, switch: Switch, surface: Any, base_dir: Path, key: str) -> None:
        self.switch = switch
        self._regions = []
        if switch.when == REACHED:
            self._regions = regions_of(switch.region, surface, base_dir, f"{key}.region")

    def has_come(self, simulation: Any) -> bool:
        """Whether it is now, between two steps."""
        switch = self.switch
        if switch.time is not None:
            return simulation.time >= switch.time * (1.0 - 1e-12)
        if switch.when == FLOWING and simulation.max_speed <= switch.speed:
            return False
        share = self.share(simulation.particles)
        return share > switch.least_share or (share == switch.least_share > 0.0)

    def share(self, fields: ParticleFields) -> float:
        """Share of the snow that meets the condition, of `particles.fields.ParticleFields`."""
        switch, mass = self.switch, fields["mass"]
        if switch.when == FLOWING:
            counts = np.linalg.norm(fields["velocity"], axis=1) > switch.speed
        elif switch.when == BROKEN:
            bonded, counts = _bonds(fields)
            mass = mass * bonded
        else:
            counts = self.inside(fields["position"][:, :2])
        whole = mass.sum()
        return float(mass[counts].sum() / whole) if whole > 0.0 else 0.0

    def inside(self, plan: Floats) -> NDArray[np.bool_]:
        """Whether places (n, 2) [m] lie in the region (n,)."""
        return inside(self._regions, plan)

    def outside(self, lower: Floats, upper: Floats) -> bool:
        """Whether its region lies outside the box between two corners (dim,) [m]."""
        axes = slice(len(lower) - 1)
        return all((region.upper <= lower[axes]).any() or (region.lower >= upper[axes]).any()
                   for region in self._regions)

    def distance(self, positions: Floats) -> float:
        """From the nearest of places (n, 3) to the box around the region, in plan [m]."""
        return distance(self._regions, positions)


def inside(regions: list[Region], plan: Floats) -> NDArray[np.bool_]:
    """Whether places (n, 2) [m] lie in one of the regions (n,)."""
    found: NDArray[np.bool_] = np.zeros(len(plan), bool)
    for region in regions:
        box: Any = ((plan >= region.lower) & (plan <= region.upper)).all(axis=1)
        if region.polygons is not None:
            box[box] = region.polygons.contains(plan[box])
        found |= box
    return found


def distance(regions: list[Region], positions: Floats) -> float:
    """From the nearest of places (n, 3) to the boxes around the regions, in plan [m]."""
    gaps = [np.maximum(0.0, np.maximum(region.lower - positions[:, :2], positions[:, :2] - region.upper))
            for region in regions]
    return min(float(np.linalg.norm(gap, axis=1).min()) for gap in gaps)


def _bonds(fields):
    """Whether each particle is of a law with bonds, and whether it has lost them."""
    material, state = fields["material"], fields.state()
    bonded, lost = np.zeros(len(material), bool), np.zeros(len(material), bool)
    for index, law in enumerate(fields.materials.laws):
        if law.BONDS is not None and law.bonds_last_below > 0.0:
            own = material == index
            bonded[own], lost[own] = True, state[own, law.BONDS] >= law.bonds_last_below
    return bonded, lost


def at_rest(fields):
    """Particles slower than `MOVING_SPEED` (n,)."""
    return np.linalg.norm(fields["velocity"], axis=1) < MOVING_SPEED
