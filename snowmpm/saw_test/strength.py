"""Which layer of a saw test does not bear the snow above it, before anything is cut."""

from dataclasses import dataclass

import numpy as np

from snowmpm.saw_test import theory


@dataclass(frozen=True)
class Load:
    """What the weight puts on the foot of a layer: normal stress, in compression, and shear stress [Pa]; strength: the
    shear stress that its law bears beside that normal stress [Pa], 0 where that alone crushes it."""

    layer: str
    material: str
    normal: float
    shear: float
    strength: float

    @property
    def share(self):
        """Shear stress over strength; 1 and more does not stand."""
        if self.strength > 0.0:
            return self.shear / self.strength
        return np.inf

    def __str__(self):
        if self.strength == 0.0:
            return (f"the normal stress of {self.normal:.0f} Pa on the foot of {self.layer} (materials.{self.material})"
                    " crushes it before anything is cut")
        return (f"{self.layer} (materials.{self.material}) bears {self.strength:.0f} Pa of shear under"
                f" {self.normal:.0f} Pa of normal stress; weight and slope put {self.shear:.0f} Pa on its foot,"
                f" {self.share:.2f} times as much, before anything is cut")


def loads(scene):
    """`Load` of every layer of a scene with a saw test whose law has a strength, from the ground up.

    Of an infinite slope, sigma = W cos(slope), tau = W sin(slope) with W the weight per area above and sideways K0 of
    each law: the free ends of a column are loaded more, within about a slab's thickness of them.
    """
    test = scene.saw_test
    above, found = 0.0, []
    angle = np.radians(abs(test.slope_angle))
    for name, layer in reversed(test.layers):
        law = scene.materials[layer.material]
        above += law.density * scene.gravity * layer.thickness
        normal, shear = above * np.cos(angle), above * np.sin(angle)
        strength = theory.shear_strength(law, normal)
        if np.isfinite(strength):
            found.append(Load(name, layer.material, float(normal), float(shear), float(strength)))
    return found[::-1]


def overloaded(scene):
    """The `Load`s that do not stand; none of a scene without a saw test."""
    return [load for load in loads(scene) if load.share >= 1.0] if scene.saw_test else []
