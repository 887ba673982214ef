"""The structures of a scene, and the obstacles that their segments are."""

from typing import Any

import numpy as np

from snowmpm.components.structures.declare import STRONG
from snowmpm.components.structures.framework import Framework
from snowmpm.components.structures.framework_mesh import Member
from snowmpm.components.structures.framework_tables import Framework as FrameworkSpec
from snowmpm.components.structures.rod import Rod
from snowmpm.components.structures.rods import Rods, Standing
from snowmpm.components.structures.section import Section
from snowmpm.components.structures.segment_motion import SegmentMotion
from snowmpm.errors import InputError
from snowmpm.registry import resolved
from snowmpm.solids import Obstacle, RigidMotion, SolidShape
from snowmpm.solids.primitives import BOX, CYLINDER

HELD = 1.0
"""Cells around a segment whose snow contact holds at its velocity, about (`rigid.body`)."""


def standing(scene):
    """What `rods.Rods` moves of the structures of a scene, and the `Obstacle`s of their segments."""
    made = [resolved(spec.MAKES)(scene, i) for i, spec in enumerate(scene.structures)]
    pairs = zip(scene.structures, made, strict=True)
    return made, [_segment(spec, rod, s, name, width, scene.dimension) for spec, rod in pairs
                  for s, (name, width) in enumerate(_segments(spec, rod))]


def rods(model):
    """`Rods` of a `Model`, whose last obstacles are their segments. InputError: a structure that snow would outweigh,
    feet outside the domain."""
    scene = model.scene
    density = max(law.density for law in model.laws)
    found, first = [], len(scene.obstacles)
    for i, (spec, rod) in enumerate(zip(scene.structures, model.made["structures"], strict=True)):
        share, mass = heaviest_held(scene, spec, rod, density) if spec.OWN else (0.0, 0.0)
        if share > 1.0 and spec.coupling != "strong":
            strong = ', coupling = "strong"' if scene.solver.method in STRONG else ""
            raise InputError(f"{scene.source}: structures.{i} ({spec.name}): too light for this grid: {mass:.3g} kg/m,"
                             f" and the snow in the cells around it has up to {share * mass:.3g} kg/m\n"
                             f"give it more mass{strong}, or lower solver.dx")
        if isinstance(spec, FrameworkSpec):
            _refuse_feet_outside(model, i, spec)
        if spec.OWN and model.distance is not None:
            _stand(rod, spec, model.distance)
        found.append(Standing(spec.name, rod, first, spec.coupling == "strong", _rests(scene, spec)))
        first += rod.n
    return Rods(found, scene.dimension)


def _rests(scene, spec):
    """When a structure goes to rest, of `Standing`."""
    if not isinstance(spec, FrameworkSpec):
        return "never"
    if spec.response == "static":
        return "always"
    return "first" if scene.initial.stress == "settle" else "never"


def _refuse_feet_outside(model, i, spec):
    for name in spec.feet:
        x = np.asarray(spec.joints[name], float)
        if (x < model.lower).any() or (x > model.upper).any():
            raise InputError.at(f"structures.{i}.joints.{name}", list(spec.joints[name]),
                                "is a foot, and must lie in the domain, from"
                                f" {np.round(model.lower, 2).tolist()} to {np.round(model.upper, 2).tolist()} m",
                                model.scene.source)


def _stand(rod, spec, ground):
    """Let a structure that falls come to lie on the ground at its foot, the first one, taken for a plane."""
    framework = isinstance(spec, FrameworkSpec)
    foot = np.asarray(spec.joints[next(iter(spec.feet))] if framework else spec.foot, float)
    distance, normal = (found[0] for found in ground.query(foot[None]))
    rod.stand_on(in_space(normal), normal @ foot - distance + 0.5 * spec.width)


def heaviest_held(scene, spec, rod, density):
    """Mass of the snow of this density [kg/m3] in the cells around a structure over its own, where that is most; and
    its own there [kg/m]."""
    def share(section):
        return line_mass_held(scene, section.width, density) / section.line_mass

    parts = rod.mesh.members if isinstance(spec, FrameworkSpec) else [rod]
    section = max((part.section for part in parts), key=share)
    return share(section), section.line_mass


def line_mass_held(scene, width, density):
    """Mass along a structure of this width [m] of the snow of this density [kg/m3] in the cells around it [kg/m]."""
    return (2.0 if scene.dimension == 2 else np.pi * width) * HELD * scene.solver.dx * density


def mast(scene, i):
    """`Rod` of structure i of a scene."""
    spec, dim = scene.structures[i], scene.dimension
    return Rod(in_space(spec.foot), in_space(spec.top), spec.segments, _section(spec, spec.width, spec.wall, dim),
               spec.damping)


def framework(scene, i):
    """`Framework` of structure i of a scene. InputError: members that are no structure, since something moves without
    resistance."""
    spec, dim = scene.structures[i], scene.dimension
    members = [Member(first, last, _section(spec, spec.of(member, "width"), spec.of(member, "wall"), dim),
                      spec.of(member, "segments"), member.pinned)
               for member in spec.members for first, last in [member.ends]]
    made = Framework({name: in_space(x) for name, x in spec.joints.items()}, spec.feet, members,
                     poisson_ratio=spec.poisson_ratio, damping=spec.damping, plane=dim == 2)
    if (loose := made.modes.loose) is not None:
        joint = list(spec.joints)[loose]
        raise InputError(f"{scene.source}: structures.{i} ({spec.name}): a mechanism, not a structure: nothing holds"
                         f" joint {joint}, at {list(spec.joints[joint])} m\ngive it fixed feet, fewer pinned ends, or a"
                         " member across")
    return made


def _section(spec, width, wall, dim):
    given = {"yield_stress": spec.yield_stress, "strength": spec.strength, "hardening": spec.hardening}
    if dim == 2:
        return Section.plate(width, spec.youngs_modulus, spec.density, **given)
    return Section.tube(width, wall or 0.5 * width, spec.youngs_modulus, spec.density, **given)


def in_space(point):
    """A point (dim,) as (3,)."""
    return (point[0], 0.0, point[1]) if len(point) == 2 else point


def _segments(spec, rod):
    """Name and width [m] of each segment."""
    if not isinstance(spec, FrameworkSpec):
        return [(f"{spec.name}_{s + 1}", spec.width) for s in range(rod.n)]
    return [(f"{spec.name}_{member.name}_{s + 1}", member.section.width) for member in rod.mesh.members
            for s in range(member.segments)]


def _segment(spec, rod, s, name, width, dim):
    """Segment s as an `Obstacle`: a box in 2-D, a round cylinder in 3-D."""
    motion: Any = SegmentMotion(rod, s, dim)
    origin, half, r = motion.start_centre, 0.5 * rod.lengths[s], 0.5 * width
    along = rod.along[s]
    if dim == 2:
        axes, size, kind = np.array([[along[2], -along[0]], [along[0], along[2]]]), np.array([r, half]), BOX
    else:
        across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
        across /= np.linalg.norm(across)
        axes, size, kind = np.array([across, np.cross(along, across), along]), np.array([r, r, half]), CYLINDER
    if spec.coupling == "one_way":
        motion = RigidMotion(origin)
    return Obstacle(name, SolidShape(kind, origin, axes, size), motion, spec.contact, spec.friction, part=True)
