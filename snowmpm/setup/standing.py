"""The structures of a scene: rods, and the obstacles that their segments are."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.solids import Obstacle, RigidMotion, SolidShape
from snowmpm.solids.primitives import BOX, CYLINDER
from snowmpm.structures.rod import Rod
from snowmpm.structures.rods import Rods, Standing
from snowmpm.structures.section import Section
from snowmpm.structures.segment_motion import SegmentMotion

HELD = 1.0
"""Cells around a segment whose snow contact holds at its velocity, about (`rigid.body`)."""


def standing(scene):
    """`Rod`s of the structures of a scene, and the `Obstacle`s of their segments."""
    made = [_rod(spec, scene.dimension) for spec in scene.structures]
    pairs = zip(scene.structures, made, strict=True)
    return made, [_segment(spec, rod, s, scene.dimension) for spec, rod in pairs for s in range(rod.n)]


def rods(model):
    """`Rods` of a `Model`, whose last obstacles are their segments. InputError: a rod that snow would outweigh."""
    scene = model.scene
    density = max(law.density for law in model.laws)
    found, first = [], len(scene.obstacles)
    for i, (spec, rod) in enumerate(zip(scene.structures, model.rods, strict=True)):
        share = held_share(scene, spec, rod, density)
        if share > 1.0 and spec.coupling != "strong":
            strong = ', coupling = "strong"' if METHODS[scene.solver.method].capabilities.strong_coupling else ""
            mass = rod.section.line_mass
            raise InputError(f"{scene.source}: structures.{i} ({spec.name}): too light for this grid: {mass:.3g} kg/m,"
                             f" and the snow in the cells around it has up to {share * mass:.3g} kg/m\n"
                             f"give it more mass{strong}, or lower solver.dx")
        if model.distance is not None:
            _stand(rod, spec, model.distance)
        found.append(Standing(spec.name, rod, first, spec.coupling == "strong"))
        first += rod.n
    return Rods(found, scene.dimension)


def _stand(rod, spec, ground):
    """Let a `Rod` that falls come to lie on the ground at its foot, taken for a plane."""
    foot = np.asarray(spec.foot, float)
    distance, normal = (found[0] for found in ground.query(foot[None]))
    rod.stand_on(_in_space(normal), normal @ foot - distance + 0.5 * spec.width)


def held_share(scene, spec, rod, density):
    """Mass of the snow of this density [kg/m3] in the cells around a `Rod` over its own."""
    around = (2.0 if scene.dimension == 2 else np.pi * spec.width) * HELD * scene.solver.dx
    return around * density / rod.section.line_mass


def _rod(spec, dim):
    given = {"yield_stress": spec.yield_stress, "strength": spec.strength, "hardening": spec.hardening}
    if dim == 2:
        section = Section.plate(spec.width, spec.youngs_modulus, spec.density, **given)
    else:
        section = Section.tube(spec.width, spec.wall or 0.5 * spec.width, spec.youngs_modulus, spec.density, **given)
    return Rod(_in_space(spec.foot), _in_space(spec.top), spec.segments, section, spec.damping)


def _in_space(point):
    return (point[0], 0.0, point[1]) if len(point) == 2 else point


def _segment(spec, rod, s, dim):
    """Segment s as an `Obstacle`: a box in 2-D, a round cylinder in 3-D."""
    motion = SegmentMotion(rod, s, dim)
    origin, half, r = motion.start_centre, 0.5 * rod.length, 0.5 * spec.width
    along = rod.clamp
    if dim == 2:
        axes, size, kind = np.array([[along[2], -along[0]], [along[0], along[2]]]), np.array([r, half]), BOX
    else:
        across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
        across /= np.linalg.norm(across)
        axes, size, kind = np.array([across, np.cross(along, across), along]), np.array([r, r, half]), CYLINDER
    if spec.coupling == "one_way":
        motion = RigidMotion(origin)
    return Obstacle(f"{spec.name}_{s + 1}", SolidShape(kind, origin, axes, size), motion, spec.contact, spec.friction)
