"""Scenes of a profile: the law of its weak layer, and its saw test."""

import math
from dataclasses import dataclass, replace

from snowmpm.errors import InputError, shown_line
from snowmpm.pit import mechanics
from snowmpm.pit.column import Column, Plate
from snowmpm.scenes.starts import quoted

SLOPE, COHESION, HARDENING = 1.0, 0.3, 0.15
"""M, beta and xi of the weak layer's law in a saw test: chosen; crushed it rubs as M / sqrt(3) = 0.58, 30 degrees."""
STIFFEST_WEAK = 5e5
"""Young's modulus [Pa] that the weak layer of a scene has at the most. The moduli of `mechanics` are those of slabs;
with them a weak layer of this strength and energy is ductile, and no crack runs."""
CELLS = 8
"""Over the slab of a saw test, whose crack is then within a tenth of that on fine cells (`snowmpm docs interface`)."""
POINTS = 8
"""Of the weak layer of a saw test, a cell and direction."""
LEAST_COLUMN, LONGEST_COLUMN = 1.5, 8.0
"""Length of a saw test [m]."""
SOFTEST, MOST_BRITTLE = 0.05, 60.0
"""Rates of softening that are tried."""
BEARS = 1.5
"""Shear strength over shear stress at the least: the slab was there when the pit was dug, whatever the law of strength
says of its weak layer; how much more it bears is chosen."""


@dataclass(frozen=True)
class WeakLaw:
    """Numbers of `anticrack_cam_clay` for a weak layer: M, p0 [Pa], softening [-]; strength in shear under the slab
    [Pa] and energy of its collapse [J/m2], as they came out."""

    slope: float
    p0: float
    softening: float
    strength: float
    energy: float


def weak_law(column: Column, slope: float = SLOPE) -> WeakLaw:
    """The law whose shear strength under the slab, and whose energy of collapse, are those of the weak layer.

    Needs a running Taichi, as the energy is that of the law's oedometric curve. Raises InputError where no law
    gives the strength of its form. A layer that could not bear its slab gets BEARS times the shear stress.
    """
    from snowmpm.materials import AnticrackCamClay
    from snowmpm.saw_test import theory

    weak, (sigma, tau) = softened(column).weak, column.stresses
    if weak.strength is None:
        raise InputError("no scenes: no law gives the strength of the grain form of this weak layer")
    strength = max(weak.strength, BEARS * tau)

    def law(p0, softening):
        return AnticrackCamClay(
            kind="anticrack_cam_clay", density=weak.density, youngs_modulus=weak.youngs_modulus,
            poisson_ratio=weak.poisson_ratio, critical_slope=slope, cohesion=COHESION, hardening=HARDENING, p0=p0,
            softening=softening)

    p0 = _bisected(lambda value: _or_zero(theory.shear_strength(law(value, 1.0), sigma)) - strength, 100.0, 1e6)
    most = min(MOST_BRITTLE, 0.9 * law(p0, 1.0).critical_hardening() / HARDENING)

    def energy(softening):
        found = theory.fracture_energy(law(p0, softening), weak.thickness)
        return math.inf if math.isnan(found) else found  # it does not soften within the curve

    if energy(most) > weak.energy:
        softening = most
    elif energy(SOFTEST) < weak.energy:
        softening = SOFTEST
    else:
        softening = math.exp(_bisected(lambda log: weak.energy - energy(math.exp(log)), math.log(SOFTEST),
                                       math.log(most), 16))
    return WeakLaw(slope, p0, softening, theory.shear_strength(law(p0, softening), sigma), energy(softening))


def softened(column: Column) -> Column:
    """The column with a weak layer no stiffer than STIFFEST_WEAK."""
    weak = column.weak
    return replace(column, weak=replace(weak, youngs_modulus=min(weak.youngs_modulus, STIFFEST_WEAK)))


def saw_test_scene(column: Column, law: WeakLaw, name: str, about: str, expected: float | None) -> str:
    """Text of the scene of a saw test on the profile: its weak layer an interface, its slab elastic.

    about: of the profile, for the header; expected: critical length [m], which sets the length of the column.
    """
    column = softened(column)
    thickness = column.thickness
    cut = min(3.0 * (expected or 0.5), 0.4 * LONGEST_COLUMN)
    length = min(max(LEAST_COLUMN, cut + 5.0 * thickness, 2.5 * cut), LONGEST_COLUMN)
    dx = rounded(thickness / CELLS)
    plates = merged(column.plates, dx)
    slab = "\n".join(f'[[saw_test.slab]]\nmaterial = "slab_{n}"\nthickness = {plate.thickness:.4g}'
                     for n, plate in enumerate(plates, 1))
    laws = "\n\n".join(f'[materials.slab_{n}]\nkind = "elastic"\n{elastic(plate)}'
                       for n, plate in enumerate(plates, 1))
    return f"""# Saw test on a snow profile: {shown_line(about, 100)}
#
{header(column, law, plates)}
name = {quoted(name)}
dimension = 2
end_time = {max(0.5, 0.25 + length / 8.0):.2g}

[output]
interval = 0.01
fields = ["velocity", "material", "damage"]

[solver]
dx = {dx:g}
transfer = "aflip"
flip_ratio = 0.99

[saw_test]
length = {length:.3g}
slope_angle = {column.angle:g}
ends = "vertical"
weak_layer = {{ material = "weak_layer", thickness = {column.weak.thickness:.4g}, interface = {POINTS} }}
saw_start = 0.02
saw_speed = {max(2.0, 5.0 * cut):.3g}
saw_length = {cut:.3g}

{slab}

{weak_table(column, law)}

{laws}

[initial]
stress = "settle"
"""


def merged(plates, least: float) -> list[Plate]:
    """Plates with the thin ones joined to the neighbour whose density is nearest, until none is thinner than `least`
    [m]: masses, and stiffness in stretching, are kept."""
    parts = list(plates)
    while len(parts) > 1:
        k = min(range(len(parts)), key=lambda n: parts[n].thickness)
        if parts[k].thickness >= least - 1e-9:
            break
        sides = [n for n in (k - 1, k + 1) if 0 <= n < len(parts)]
        other = min(sides, key=lambda n: abs(parts[n].density - parts[k].density))
        low = min(k, other)
        parts[low:low + 2] = [_joined(parts[low], parts[low + 1])]
    return parts


def _joined(first, second):
    total = first.thickness + second.thickness

    def mean(name):
        return (first.thickness * vars(first)[name] + second.thickness * vars(second)[name]) / total

    return Plate(total, mean("density"), mean("youngs_modulus"), first.source)


def header(column, law, plates):
    """Comment lines of a scene: slab, weak layer, and what is assumed."""
    source = mechanics.MODULI[column.law][0]
    weak = column.weak
    lines = [
        f"Slab of {100 * column.thickness:.0f} cm normal to the slope, {column.density:.0f} kg/m3 in the mean; layers"
        f" from the weak layer up, thin ones joined: {len(plates)}.",
        f"Moduli: {source}.",
        f"Weak layer: shear strength {law.strength:.0f} Pa under the slab, whose weight puts"
        f" {column.stresses[1]:.0f} Pa of shear on it.",
        f"Its modulus is {1e-6 * weak.youngs_modulus:.2g} MPa, its collapse takes {law.energy:.2f} J/m2 (asked:"
        f" {weak.energy:.2f}).",
        *_raised(column), *column.assumed]
    return "\n".join(f"# {line}" for line in lines)


def _raised(column):
    strength, tau = column.weak.strength, column.stresses[1]
    if strength is not None and strength < BEARS * tau:
        yield (f"By its form and density its shear strength would be {strength:.0f} Pa, less than {BEARS:g} times the"
               " shear stress of the slab, which is taken.")


def weak_table(column: Column, law: WeakLaw) -> str:
    """Table of the material `weak_layer`."""
    weak = column.weak
    return (f'[materials.weak_layer]\nkind = "anticrack_cam_clay"\ndensity = {weak.density:.4g}\n'
            f"youngs_modulus = {weak.youngs_modulus:.4g}\npoisson_ratio = {weak.poisson_ratio:g}\n"
            f"critical_slope = {law.slope:g}\ncohesion = {COHESION:g}\nhardening = {HARDENING:g}\n"
            f"p0 = {law.p0:.4g}\nsoftening = {law.softening:.4g}")


def elastic(plate):
    """Keys of the density and the moduli of a material."""
    return (f"density = {plate.density:.4g}\nyoungs_modulus = {plate.youngs_modulus:.4g}\n"
            f"poisson_ratio = {plate.poisson_ratio:g}")


def _bisected(function, lower, upper, tries=40):
    """Where a function that grows passes zero, between two places."""
    for _ in range(tries):
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if function(middle) > 0.0 else (middle, upper)
    return 0.5 * (lower + upper)


def _or_zero(value):
    return value if math.isfinite(value) else 0.0


def rounded(length):
    """To two digits."""
    return float(f"{length:.2g}")
