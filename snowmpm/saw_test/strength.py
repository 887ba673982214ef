"""Layers of a saw test that fail under the snow above them before anything is cut."""

from dataclasses import dataclass

import numpy as np

from snowmpm.saw_test import theory
from snowmpm.saw_test.prediction import column_of


@dataclass(frozen=True)
class Load:
    """Stress at the foot of a layer from the weight: normal, positive in compression, and shear [Pa]; strength: the
    largest shear stress that its law bears under that normal stress [Pa], 0 if the normal stress alone crushes it."""

    layer: str
    material: str
    normal: float
    shear: float
    strength: float
    at_end: bool = False
    """At the lower end of the column instead of the infinite slope."""

    @property
    def share(self):
        """Shear stress over strength; the layer fails from 1 on."""
        if self.strength > 0.0:
            return self.shear / self.strength
        return np.inf

    def __str__(self):
        if self.at_end:
            return (f"the lower end of {self.layer} (materials.{self.material}) carries about {self.normal:.0f} Pa of"
                    f" normal stress and {self.shear:.0f} Pa of shear, as the ends of the column are normal to the"
                    f" slope, and bears {self.strength:.0f} Pa of shear beside it: it is worn before the saw comes, and"
                    " a critical length is that of its end")
        if self.strength == 0.0:
            return (f"the normal stress of {self.normal:.0f} Pa on the foot of {self.layer} (materials.{self.material})"
                    " crushes it before anything is cut")
        return (f"{self.layer} (materials.{self.material}) bears {self.strength:.0f} Pa of shear under"
                f" {self.normal:.0f} Pa of normal stress; weight and slope put {self.shear:.0f} Pa on its foot,"
                f" {self.share:.2f} times as much, before anything is cut")


def loads(scene):
    """`Load` of every layer of a scene with a saw test whose law has a strength, from the ground up.

    As on an infinite slope: sigma = W cos(slope), tau = W sin(slope) with W the weight per area above, and lateral
    stress by K0 of each law. Near the free ends of a column, within about a slab's thickness, loads are larger
    (`load_of_end`).
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


def load_of_end(scene):
    """Estimated `Load` of the weak layer at the lower end of a column whose ends are normal to the slope.

    None for vertical ends, for a level column, and for a law without a strength.
    The end face lacks the shear force tau D / 2 of an infinite slope. This force loads the end of a beam (the slab, D
    thick) on springs (the weak layer, t thick, k = E' / t). The normal stress at the end is then

        sigma_end = sigma + tau D lambda,    lambda = (k / (4 B))^(1/4),   B the slab's stiffness in bending

    with sigma and tau the stresses on an infinite slope. The shear stress stays tau.
    """
    test = scene.saw_test
    if test.ends == "vertical" or test.slope_angle == 0.0:
        return None
    slab, law, thickness = column_of(scene)
    normal, shear = slab.stresses(abs(test.slope_angle), scene.gravity)
    bending = slab.bending_modulus * slab.thickness**3 / 12.0
    stiffness = law.youngs_modulus / (1.0 - law.poisson_ratio**2) / thickness
    normal += shear * slab.thickness * (stiffness / (4.0 * bending)) ** 0.25
    strength = theory.shear_strength(law, normal, at_end=True)
    if not np.isfinite(strength):
        return None
    return Load("weak_layer", test.weak_layer.material, float(normal), float(shear), float(strength), at_end=True)


def overloaded(scene):
    """List of the `Load`s that fail.

    It holds those on an infinite slope; if none of them fails, that of the column's lower end. It is empty for a scene
    without a saw test.
    """
    if not scene.saw_test:
        return []
    found = [load for load in loads(scene) if load.share >= 1.0]
    end = load_of_end(scene)
    return found or [load for load in [end] if load and load.share >= 1.0]
