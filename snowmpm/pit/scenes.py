"""Scenes of a profile: its saw test, and the release of its slab on a slope of its angle."""

import math
from dataclasses import dataclass, replace

from snowmpm.errors import InputError, shown_line
from snowmpm.pit import mechanics
from snowmpm.pit.column import Column, Plate

SLOPE, COHESION, HARDENING = 1.2, 0.3, 0.15
"""M, beta and xi of the weak layer's law: chosen; M / sqrt(3) = 0.69, 35 degrees, is the friction of the crushed layer
on the slope."""
RUBS = 0.8
"""M of the slab and of the weak layer of a release: a crushed layer rubs as M / sqrt(3) = 0.46, 25 degrees."""
TENSION = 0.297
"""Strength in uniaxial tension over p0 of a cohesive Cam-Clay law with M = 0.8 and beta = 0.3."""
CELLS = 8
"""Over the slab of a saw test, whose crack is then within a tenth of that on fine cells (`snowmpm docs interface`)."""
RELEASE_CELLS = 2
"""Over the slab of a release, which its interface allows."""
POINTS = {"saw_test": 8, "release": 2}
LEAST_COLUMN, LONGEST_COLUMN = 1.5, 8.0
"""Length of a saw test [m]."""
SOFTEST, MOST_BRITTLE = 0.05, 60.0
"""Rates of softening that are tried."""
STIFFEST = 2e6
"""Young's modulus [Pa] that a layer of a release has at the most: who slides and where it tears hangs on strength, and
waves in stiffer snow only shorten the steps."""
TEARS = 3.0
"""Length of a patch over that at which its weight, less friction, tears the slab along one side."""
GENTLE = 28.0
"""Slope [degrees] below which no release is drawn: avalanches of slabs are rare there."""
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

    weak, (sigma, tau) = column.weak, column.stresses
    if weak.strength is None:
        raise InputError("no scene of this weak layer: no law gives the strength of its grain form")
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


def saw_test_scene(column: Column, law: WeakLaw, name: str, about: str, expected: float | None) -> str:
    """Text of the scene of a saw test on the profile: its weak layer an interface, its slab elastic.

    about: of the profile, for the header; expected: critical length [m], which sets the length of the column.
    """
    thickness = column.thickness
    length = min(max(LEAST_COLUMN, 3.0 * (expected or 0.5), 4.0 * thickness), LONGEST_COLUMN)
    dx = _rounded(thickness / CELLS)
    plates = merged(column.plates, dx)
    slab = "\n".join(f'[[saw_test.slab]]\nmaterial = "slab_{n}"\nthickness = {plate.thickness:.4g}'
                     for n, plate in enumerate(plates, 1))
    laws = "\n\n".join(f'[materials.slab_{n}]\nkind = "elastic"\n{_elastic(plate)}'
                       for n, plate in enumerate(plates, 1))
    return f"""# Saw test on a snow profile: {shown_line(about, 100)}
#
{_header(column, law, plates)}
name = {_quoted(name)}
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
weak_layer = {{ material = "weak_layer", thickness = {column.weak.thickness:.4g}, interface = {POINTS["saw_test"]} }}
saw_start = 0.02
saw_speed = {max(2.0, 2.5 * length):.3g}

{slab}

{weak_table(column, law)}

{laws}

[initial]
stress = "settle"
"""


def of_release(column: Column) -> Column:
    """The column with its moduli no larger than STIFFEST, and its plates no thinner than a cell (`cell_of_release`)."""
    soft = [replace(plate, youngs_modulus=min(plate.youngs_modulus, STIFFEST)) for plate in column.plates]
    weak = replace(column.weak, youngs_modulus=min(column.weak.youngs_modulus, STIFFEST))
    return replace(column, plates=tuple(merged(soft, cell_of_release(column))), weak=weak)


def cell_of_release(column: Column) -> float:
    """[m]"""
    return _rounded(column.thickness / RELEASE_CELLS)


def tearing_length(column: Column) -> float:
    """Length [m] of slab whose weight, less the friction of the crushed layer, its tensile strength just holds:
    L (tau - mu sigma) = sum of strengths times thicknesses."""
    sigma, tau = column.stresses
    strength = sum(mechanics.tensile_strength(plate.density) * plate.thickness for plate in column.plates)
    drive = tau - RUBS / math.sqrt(3.0) * sigma
    return strength / drive if drive > 0.0 else math.inf


def slab_laws(plates) -> str:
    """Tables of the materials `slab_1` and on, each with the tensile strength of its density (`mechanics`)."""
    return "\n\n".join(
        f'[materials.slab_{n}]\nkind = "cohesive_cam_clay"\n{_elastic(plate)}\ncritical_slope = {RUBS:g}\n'
        f"cohesion = {COHESION:g}\nhardening = 1.0\n"
        f"p0 = {mechanics.tensile_strength(plate.density) / TENSION:.4g}" for n, plate in enumerate(plates, 1))


def release_scene(column: Column, law: WeakLaw, name: str, about: str) -> str:
    """Text of the scene of a release on a plane slope of the column's angle, in 3-D: a weak layer between firm snow
    above and at both sides, which a saw cuts across, TEARS times as long as the slab needs to tear off.

    column: `of_release`; law: of its weak layer with M = RUBS. Raises InputError for an angle on which no slab slides.
    """
    if column.angle < GENTLE or not math.isfinite(tearing_length(column)):
        raise InputError(f"no release on {column.angle:g} degrees: a slab slides from about {GENTLE:g} degrees on;"
                         " --slope gives the angle of a slope nearby")
    dx, D, t = cell_of_release(column), column.thickness, column.weak.thickness
    tan, long = math.tan(math.radians(column.angle)), max(16.0, TEARS * tearing_length(column) / D)
    wide = max(10.0, 0.7 * long)

    def of(*lengths):
        return "[" + ", ".join(f"{D * length:.4g}" for length in lengths) + "]"

    def body(name, material, bottom, top, x, y, points=""):
        return (f'[[bodies]]\nname = "{name}"\nmaterial = "{material}"\n{points}shape = {{ kind = "layer", bottom = '
                f"{bottom:.4g}, top = {top:.4g}, region = {{ x = {of(*x)}, y = {of(*y)} }} }}")

    interface = f"interface = {POINTS['release']}\n"
    foot = 10.0 + long
    bodies = [body("weak_layer", "weak_layer", 0.0, t, (10, foot), (5, 5 + wide), interface),
              body("firm_above", "firm", 0.0, t, (7, 10), (3, 7 + wide), interface),
              body("firm_left", "firm", 0.0, t, (10, foot), (3, 5), interface),
              body("firm_right", "firm", 0.0, t, (10, foot), (5 + wide, 7 + wide), interface)]
    bottom = t
    for n, plate in enumerate(column.plates, 1):
        bodies.append(body(f"slab_{n}", f"slab_{n}", bottom, bottom + plate.thickness, (7, foot), (3, 7 + wide)))
        bottom += plate.thickness
    flat, ends = 2.0 * foot + 10.0, 3.0 * foot + 30.0
    high, cut = flat * tan, 10.0 + 0.5 * long
    end = 2.0 * math.sqrt(D / 0.5)
    return f"""# Slab release of a snow profile: {shown_line(about, 100)}
#
{_header(column, law, column.plates)}
# Moduli are at most {1e-6 * STIFFEST:g} MPa. Beside the weak layer, above and at both sides, lies firm snow (chosen); a
# saw cuts the weak layer across the slope.
name = {_quoted(name)}
dimension = 3
end_time = {end:.2g}

[output]
interval = {0.1 * end:.2g}
fields = ["velocity", "density", "material", "damage"]

[solver]
dx = {dx:g}
particles_per_cell = 4
transfer = "aflip"
flip_ratio = 0.99

[domain]
min = {of(0, 0, -2)}
max = {of(ends, 10 + wide, high + 5)}

[terrain]
kind = "profile"
points = [{of(0, high)}, {of(flat, 0)}, {of(ends, 0)}]
fillet = {20 * D:.3g}
contact = "separate"
friction = {RUBS / math.sqrt(3.0):.2g}

{slab_laws(column.plates)}

{weak_table(column, law)}

[materials.firm]
kind = "cohesive_cam_clay"
density = 300.0
youngs_modulus = {column.weak.youngs_modulus:.4g}
poisson_ratio = 0.3
critical_slope = 1.5
cohesion = 1.0
hardening = 1.0
p0 = 1.0e5

{chr(10).join(one + chr(10) for one in bodies)}
[[events]]
kind = "cut"
body = "weak_layer"
start = 0.1
speed = {2 * wide * D:.3g}
width = {4 * D:.3g}
path = [{of(cut, 6, (flat - cut) * tan)}, {of(cut, 4 + wide, (flat - cut) * tan)}]

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


def _header(column, law, plates):
    source = mechanics.MODULI[column.law][0]
    lines = [
        f"Slab of {100 * column.thickness:.0f} cm normal to the slope, {column.density:.0f} kg/m3 in the mean, in"
        f" {len(plates)} parts (thin ones are joined).",
        f"Moduli: {source}.",
        f"Weak layer: bears {law.strength:.0f} Pa of shear under the slab, which puts {column.stresses[1]:.0f} Pa on"
        f" it; its collapse takes {law.energy:.2f} J/m2 (asked: {column.weak.energy:.2f}).",
        *_raised(column), *column.assumed]
    return "\n".join(f"# {line}" for line in lines)


def _raised(column):
    strength, tau = column.weak.strength, column.stresses[1]
    if strength is not None and strength < BEARS * tau:
        yield (f"By its form and density it would bear {strength:.0f} Pa, too little for the slab that lies on it:"
               f" taken as {BEARS:g} times the shear stress.")


def weak_table(column: Column, law: WeakLaw) -> str:
    """Table of the material `weak_layer`."""
    weak = column.weak
    return (f'[materials.weak_layer]\nkind = "anticrack_cam_clay"\ndensity = {weak.density:.4g}\n'
            f"youngs_modulus = {weak.youngs_modulus:.4g}\npoisson_ratio = {weak.poisson_ratio:g}\n"
            f"critical_slope = {law.slope:g}\ncohesion = {COHESION:g}\nhardening = {HARDENING:g}\n"
            f"p0 = {law.p0:.4g}\nsoftening = {law.softening:.4g}")


def _elastic(plate):
    return (f"density = {plate.density:.4g}\nyoungs_modulus = {plate.youngs_modulus:.4g}\n"
            f"poisson_ratio = {plate.poisson_ratio:g}")


def _bisected(function, lower, upper, tries=40):
    """Where a function that grows passes zero."""
    for _ in range(tries):
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if function(middle) > 0.0 else (middle, upper)
    return 0.5 * (lower + upper)


def _or_zero(value):
    return value if math.isfinite(value) else 0.0


def _rounded(length):
    """To two digits."""
    return float(f"{length:.2g}")


def _quoted(text):
    return '"' + "".join(c if c.isprintable() and c not in '"\\' else "_" for c in text) + '"'
