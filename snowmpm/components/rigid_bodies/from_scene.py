"""The bodies of a scene, and what they may touch."""

from snowmpm.components.rigid_bodies.body import Body
from snowmpm.components.rigid_bodies.motion import FreeMotion
from snowmpm.components.rigid_bodies.world import World
from snowmpm.errors import InputError
from snowmpm.scenes.space import AXES
from snowmpm.terrain import DistanceField

SUNK = 0.05
"""Share of its radius by which a body may lie in the ground or in another solid at the start."""


def motion_of(scene, i, shape):
    """`FreeMotion` of obstacle i of a scene with this `SolidShape`, None of one without a mass."""
    return FreeMotion.of_shape(spec, shape) if (spec := scene.obstacles[i].free) else None


def is_free(obstacle):
    """Whether forces move it."""
    return isinstance(obstacle.motion, FreeMotion)


def rigid_world(model):
    """`World` of the free obstacles of a `Model` at time zero. InputError: one that lies in the ground or a solid."""
    scene = model.scene
    bodies = [Body(i, obstacle, scene.solver.dx, scene.obstacles[i].free.friction, scene.obstacles[i].free.restitution)
              for i, obstacle in enumerate(model.obstacles) if is_free(obstacle)]
    ground = None
    if model.surface is not None:
        # A ball is told by the distance of its centre
        reach = max(2.0 * body.probe_radius for body in bodies) + model.depth + 5.0 * scene.solver.dx
        ground = DistanceField(model.surface, reach).query
    world = World(bodies, [obstacle for obstacle in model.obstacles if not is_free(obstacle)], ground, _sides(model),
                  (model.lower, model.upper))
    for body, what, depth in world.overlaps():
        if depth > SUNK * body.radius:
            raise InputError(f"{scene.source}: obstacles.{body.number} ({body.name}): lies {depth:.3g} m deep in {what}"
                             " at the start\na free body must lie on what carries it, or above")
    _refuse_light(model, bodies)
    return world


def _refuse_light(model, bodies):
    """Raise InputError for a body that the snow in the cells around it would outweigh."""
    density = max(law.density for law in model.laws)
    for body in bodies:
        mass, inertia = body.held(density, model.scene.solver.dx)
        if (most := max(mass, inertia)) > 1.0:
            what = "mass" if mass >= inertia else "moment of inertia"
            raise InputError(f"{model.scene.source}: obstacles.{body.number} ({body.name}): too light a free body for"
                             f" this grid: the snow in the cells around it has up to {most:.3g} times its {what}\n"
                             "give it more mass, or lower solver.dx")


def _sides(model):
    """Axis, direction inwards and level [m] of the sides of the domain that hold bodies."""
    domain, axes = model.scene.domain, AXES[model.scene.dimension]
    names = domain.sides(model.scene.dimension) if domain else {}
    return [(axis, 1 - 2 * end, float((model.lower, model.upper)[end][axis]))
            for axis, letter in enumerate(axes) for end, where in enumerate(("min", "max"))
            if names.get(f"{letter}_{where}", "open") not in ("open", "periodic")]
