"""The mechanics of a profile above one weak layer: what theories of the saw test and scenes take."""

import math
from dataclasses import dataclass, replace

from snowmpm.errors import InputError
from snowmpm.pit import mechanics
from snowmpm.pit.profile import Layer, SnowProfile
from snowmpm.quantities.snow_codes import main_class
from snowmpm.saw_test.theory import GRAVITY, Slab

THICKEST = 0.05
"""Thickness of a weak layer that takes part in its failure, at most [m]: chosen; a layer of half a metre does not
collapse as a whole."""
TOLERANCE = 1e-3
"""Depth [m] below the top of a layer that is its top."""
USUAL_ANGLE = 0.0
"""Slope [degrees] where nobody gives one."""


@dataclass(frozen=True)
class Plate:
    """A layer of the slab: thickness normal to the slope [m], density [kg/m3], Young's modulus [Pa]; source: of the
    density, a key of `mechanics.DENSITY_SCATTER`."""

    thickness: float
    density: float
    youngs_modulus: float
    source: str
    poisson_ratio: float = mechanics.POISSON_RATIO

    @property
    def shear_modulus(self) -> float:
        return self.youngs_modulus / (2.0 + 2.0 * self.poisson_ratio)


@dataclass(frozen=True)
class WeakLayer:
    """thickness normal to the slope, that takes part [m]; density [kg/m3], source of it; size of its grains [mm];
    Young's modulus [Pa]; strength: in shear without load [Pa], None for a form that has no law; energy: of its collapse
    [J/m2]."""

    thickness: float
    density: float
    source: str
    size: float
    youngs_modulus: float
    strength: float | None
    energy: float
    poisson_ratio: float = mechanics.POISSON_RATIO
    strength_exponent: float = 0.0
    """of the density, in the law of the strength"""


@dataclass(frozen=True)
class Column:
    """plates: of the slab, from the weak layer up; angle: of the slope [degrees]; assumed: what the profile does not
    say, in words; law: of the moduli, a key of `mechanics.MODULI`."""

    plates: tuple[Plate, ...]
    weak: WeakLayer
    angle: float
    law: str
    assumed: tuple[str, ...] = ()

    @property
    def thickness(self) -> float:
        """Of the slab, normal to the slope [m]."""
        return sum(plate.thickness for plate in self.plates)

    @property
    def density(self) -> float:
        """Mean of the slab [kg/m3]."""
        return sum(plate.thickness * plate.density for plate in self.plates) / self.thickness

    @property
    def slab(self) -> Slab:
        return Slab.of([(plate.thickness, plate) for plate in self.plates])

    @property
    def stresses(self) -> tuple[float, float]:
        """Normal and shear stress on the weak layer from the weight of the slab [Pa], both positive."""
        weight, angle = self.density * GRAVITY * self.thickness, math.radians(self.angle)
        return weight * math.cos(angle), weight * math.sin(angle)


def column_of(profile: SnowProfile, index: int, angle: float | None = None,
              law: str = mechanics.USUAL_MODULUS, depth: float | None = None) -> Column:
    """The column above the weak layer `index` of a profile.

    angle: of the slope [degrees], in place of the profile's. law: of the moduli. depth: at which the layer fails [m],
    its top when missing: what of it lies above belongs to the slab. Raises InputError where nothing tells the
    density of a layer of the slab or of the weak layer, or where nothing lies above it.
    """
    where = profile.source
    if not index:
        raise InputError(f"{where}: the layer at the surface has no slab above it")
    assumed = []
    if angle is None:
        angle = profile.slope_angle
    if angle is None:
        angle = USUAL_ANGLE
        assumed.append("the file has no slope angle: taken as level; --slope gives one")
    across = math.cos(math.radians(angle))
    plates, sources = [], dict.fromkeys(mechanics.DENSITY_SCATTER, 0)
    weak = profile.layers[index]
    above = list(profile.layers[:index])
    if depth is not None:  # at the bottom of a layer it fails by its last centimetres
        depth = min(depth, weak.bottom - min(weak.thickness, THICKEST))
    if depth is not None and weak.top + TOLERANCE < depth:
        above.append(replace(weak, bottom=depth))
        weak = replace(weak, top=depth)
    for n, (layer, bottom) in enumerate(zip(above, [0.0, *(one.bottom for one in above)], strict=False), 1):
        gap = layer.top - bottom
        if gap > TOLERANCE:  # the file says nothing of it
            rho, source = _density(where, n, layer)
            plates.append(Plate(gap * across, rho, mechanics.youngs_modulus(rho, law), source))
        for part in _halves(layer):
            rho, source = _density(where, n, part)
            sources[source] += 1
            plates.append(Plate(part.thickness * across, rho, mechanics.youngs_modulus(rho, law), source))
    rho, source = _density(where, index + 1, weak)
    size, form = weak.size, main_class(weak.form or weak.second_form)
    if size is None:
        size = mechanics.GRAIN_SIZE.get(form, 1.0)
        assumed.append(f"grain size of the weak layer is not in the file: {size:g} mm")
    words = {"hardness": "density by hardness and form (Geldsetzer & Jamieson 2000)", "form": "density by form alone",
             "hardness alone": "density by hardness alone"}
    assumed += [f"{words[name]}: {count} of {len(plates)} layers of the slab"
                for name, count in sources.items() if count and name in words]
    thickness = weak.thickness * across
    if thickness > THICKEST:
        assumed.append(f"the weak layer is {100 * thickness:.0f} cm thick; {100 * THICKEST:.0f} cm of it are taken to"
                       " fail")
    strength = mechanics.shear_strength(weak, rho)
    if strength is None:
        assumed.append(f"no law of strength for {weak.form or 'a form that was not observed'}")
    return Column(tuple(reversed(plates)), WeakLayer(
        min(thickness, THICKEST), rho, source, size, mechanics.youngs_modulus(rho, law), strength, mechanics.COLLAPSE,
        strength_exponent=mechanics.SHEAR_STRENGTH.get(form, (0.0, 0.0))[1]),
        angle, law, tuple(assumed))


def _halves(layer: Layer):
    """A layer whose hardness differs from top to bottom counts as two."""
    if layer.hardness is None or layer.hardness[0] == layer.hardness[1] or layer.density is not None:
        return [layer]
    upper, lower = layer.hardness
    return [replace(layer, bottom=layer.middle, hardness=(upper, upper)),
            replace(layer, top=layer.middle, hardness=(lower, lower))]


def _density(where, n, layer):
    found = mechanics.density(layer)
    if found is None:
        raise InputError(f"{where}: layer {n}, {100 * layer.top:.4g} to {100 * layer.bottom:.4g} cm: density is"
                         " missing, and neither a grain form nor the hardness tells it")
    return found
