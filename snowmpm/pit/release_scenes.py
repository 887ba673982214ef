"""Scenes of the release of a profile's slab in 3-D: on a plane slope of its angle, and on a terrain.

A weak layer lies between firm snow above and at both sides. A saw cuts it across the slope; beyond the critical length
the crack runs, and the slab tears off where firm snow holds it.
"""

import math
from dataclasses import replace

import numpy as np

from snowmpm.errors import InputError, shown_line
from snowmpm.pit import mechanics
from snowmpm.pit.column import Column
from snowmpm.pit.scenes import COHESION, WeakLaw, elastic, header, merged, rounded, weak_table
from snowmpm.scenes.starts import quoted

RUBS = 0.8
"""M of the slab and of the weak layer of a release: a crushed layer rubs as M / sqrt(3) = 0.46, 25 degrees."""
FRICTION = RUBS / math.sqrt(3.0)
"""Of a crushed weak layer, and of the ground below."""
TENSION = 0.297
"""Strength in uniaxial tension over p0 of a cohesive Cam-Clay law with M = 0.8 and beta = 0.3."""
RELEASE_CELLS = 2
"""Over the slab of a release, which its interface allows."""
STIFFEST = 2e6
"""Young's modulus [Pa] that a layer of a release has at the most: who slides and where it tears depends on strength,
and waves in stiffer snow only shorten the steps."""
STIFFEST_LAYER = 1e7
"""Modulus over thickness [Pa/m] that the weak layer of a release has at the most, for the same reason."""
TEARS = 3.0
"""Length of a patch over that at which its weight, less friction, tears the slab along one side."""
GENTLE = 28.0
"""Slope [degrees] below which no release is drawn: avalanches of slabs are rare there."""
POINTS = 2
"""Of the weak layer, a cell and direction."""
ABOVE, BESIDE = 3.0, 2.0
"""Firm snow above and at each side [thicknesses of the slab]: chosen."""
SAW = 4.0
"""Width of the band that the saw cuts [thicknesses]."""
SHARE = 0.8
"""Of the width of the weak layer: length of the cut across the slope."""
SLIDES = 4.0
"""Way of the slab at the end of a scene [thicknesses], with the friction of its weak layer."""


def of_release(column: Column) -> Column:
    """The column with its moduli no larger than STIFFEST, and its plates no thinner than a cell (`cell_of_release`)."""
    soft = [replace(plate, youngs_modulus=min(plate.youngs_modulus, STIFFEST)) for plate in column.plates]
    weak = replace(column.weak, youngs_modulus=min(column.weak.youngs_modulus, STIFFEST_LAYER * column.weak.thickness))
    return replace(column, plates=tuple(merged(soft, cell_of_release(column))), weak=weak)


def cell_of_release(column: Column) -> float:
    """[m]"""
    return rounded(column.thickness / RELEASE_CELLS)


def tearing_length(column: Column) -> float:
    """Length [m] of slab whose weight, less the friction of the crushed layer, its tensile strength just holds:
    L (tau - mu sigma) = sum of strengths times thicknesses. Raises InputError for a slope on which no slab slides."""
    sigma, tau = column.stresses
    drive = tau - FRICTION * sigma
    if column.angle < GENTLE or drive <= 0.0:
        raise InputError(f"no release on {column.angle:.3g} degrees: a slab slides from about {GENTLE:g} degrees on")
    return sum(mechanics.tensile_strength(plate.density) * plate.thickness for plate in column.plates) / drive


def release_on_plane(column: Column, law: WeakLaw, name: str, about: str) -> str:
    """Text of the scene of a release on a plane slope of the column's angle, TEARS times as long as the slab needs to
    tear off.

    column: `of_release`; law: of its weak layer with M = RUBS. Raises InputError for an angle on which no slab slides.
    """
    D, tan = column.thickness, math.tan(math.radians(column.angle))
    long = max(16.0 * D, TEARS * tearing_length(column))
    wide = max(10.0 * D, 0.7 * long)
    foot, margin = 10.0 * D + long, 5.0 * D
    flat, ends = 2.0 * foot, 3.0 * foot
    place = (10.0 * D + 0.5 * long, margin + 0.5 * wide)

    def height(plan):
        return tan * (flat - plan[0])

    ground = f"""[domain]
min = [0.0, 0.0, {-2.0 * D:.4g}]
max = [{ends:.4g}, {wide + 2.0 * margin:.4g}, {flat * tan + margin:.4g}]

[terrain]
kind = "profile"
points = [[0.0, {flat * tan:.4g}], [{flat:.4g}, 0.0], [{ends:.4g}, 0.0]]
fillet = {20.0 * D:.3g}"""
    return _release(column, law, name, about, ground, np.array(place), np.array([1.0, 0.0]), (long, wide), height)


def release_on_terrain(column: Column, law: WeakLaw, name: str, about: str, *, surface, file: str, place, side: float,
                       down) -> str:
    """Text of the scene of a release on an elevation raster, of a square of weak layer.

    surface: `terrain.TerrainSurface`; file: of the raster, as the scene names it; place (2,): middle of the square in
    map coordinates [m]; side: of it in plan [m]; down (2,): unit vector of the fall line in plan. Raises InputError for
    a slope on which no slab slides, and for a square that does not lie on the terrain.
    """
    tearing_length(column)
    D, place = column.thickness, np.asarray(place, float)
    reach = 0.5 * side + (ABOVE + SLIDES + 4.0) * D
    low, high = place - reach, place + reach
    grid = np.stack(np.meshgrid(*np.linspace(low, high, 24).T, indexing="ij"), axis=-1).reshape(-1, 2)
    heights = surface.height(grid)
    if not np.isfinite(heights).all():
        raise InputError(f"the terrain ends, or has a hole, within {reach:.0f} m of {place[0]:.1f}, {place[1]:.1f}:"
                         " choose another place or a smaller --size")
    ground = f"""[domain]
min = [{low[0]:.2f}, {low[1]:.2f}, {heights.min() - 4.0 * D:.2f}]
max = [{high[0]:.2f}, {high[1]:.2f}, {heights.max() + 6.0 * D:.2f}]

[terrain]
kind = "dem"
file = {quoted(file)}
region = {{ x = [{low[0]:.2f}, {high[0]:.2f}], y = [{low[1]:.2f}, {high[1]:.2f}] }}"""
    return _release(column, law, name, about, ground, place, np.asarray(down, float), (side, side),
                    lambda plan: float(surface.height(plan[None])[0]))


def _release(column, law, name, about, ground, place, down, sides, height):
    """place: middle of the weak layer, down: of the slope, in plan; sides: of the weak layer along and across [m];
    height: of the ground at a place [m]."""
    D, t, (long, wide) = column.thickness, column.weak.thickness, sides
    across = np.array([-down[1], down[0]])

    def region(along, aside):
        corners = [place + u * down + v * across for u, v in (
            (along[0], aside[0]), (along[1], aside[0]), (along[1], aside[1]), (along[0], aside[1]))]
        return "[" + ", ".join(f"[{x:.4f}, {y:.4f}]" for x, y in corners) + "]"

    def body(name, material, bottom, top, along, aside, points=""):
        return (f'[[bodies]]\nname = "{name}"\nmaterial = "{material}"\n{points}shape = {{ kind = "layer", bottom = '
                f"{bottom:.4g}, top = {top:.4g}, region = {{ polygon = {region(along, aside)} }} }}")

    interface, u, v = f"interface = {POINTS}\n", 0.5 * long, 0.5 * wide
    top, side = u + ABOVE * D, v + BESIDE * D
    bodies = [body("weak_layer", "weak_layer", 0.0, t, (-u, u), (-v, v), interface),
              body("firm_above", "firm", 0.0, t, (-top, -u), (-side, side), interface),
              body("firm_left", "firm", 0.0, t, (-u, u), (v, side), interface),
              body("firm_right", "firm", 0.0, t, (-u, u), (-side, -v), interface)]
    bottom = t
    for n, plate in enumerate(column.plates, 1):
        bodies.append(body(f"slab_{n}", f"slab_{n}", bottom, bottom + plate.thickness, (-top, u), (-side, side)))
        bottom += plate.thickness
    saw = [place + SHARE * v * across, place - SHARE * v * across]
    path = ", ".join(f"[{x:.3f}, {y:.3f}, {height(np.array([x, y])):.3f}]" for x, y in saw)
    end = end_of_release(column)
    return f"""# Slab release of a snow profile: {shown_line(about, 100)}
#
{header(column, law, column.plates)}
# Moduli are at most {1e-6 * STIFFEST:g} MPa, that of the weak layer {1e-6 * STIFFEST_LAYER:g} MPa/m of its thickness.
# Beside the weak layer, above and at both sides, lies firm snow (chosen); a saw cuts it across the slope.
name = {quoted(name)}
dimension = 3
end_time = {end:.2g}

[output]
interval = {0.1 * end:.2g}
fields = ["velocity", "density", "material", "damage", "id"]

[solver]
dx = {cell_of_release(column):g}
particles_per_cell = 4
transfer = "aflip"
flip_ratio = 0.99

{ground}
contact = "separate"
friction = {FRICTION:.2g}

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
speed = {4.0 * SHARE * wide:.3g}
width = {SAW * D:.3g}
path = [{path}]

[initial]
stress = "settle"
"""


def end_of_release(column: Column) -> float:
    """Time [s] at which the slab has slid SLIDES thicknesses over its crushed weak layer, half a second after the cut
    begins."""
    sigma, tau = column.stresses
    gain = (tau - FRICTION * sigma) / (column.density * column.thickness)
    return 0.6 + math.sqrt(2.0 * SLIDES * column.thickness / max(gain, 0.5))


def slab_laws(plates) -> str:
    """Tables of the materials `slab_1` and on, each with the tensile strength of its density (`mechanics`)."""
    return "\n\n".join(
        f'[materials.slab_{n}]\nkind = "cohesive_cam_clay"\n{elastic(plate)}\ncritical_slope = {RUBS:g}\n'
        f"cohesion = {COHESION:g}\nhardening = 1.0\n"
        f"p0 = {mechanics.tensile_strength(plate.density) / TENSION:.4g}" for n, plate in enumerate(plates, 1))
