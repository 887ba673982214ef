"""What a scene asks of its method and the method cannot do: refused here, from its capabilities, and nowhere else."""

from snowmpm.errors import InputError
from snowmpm.methods import METHODS, who_can
from snowmpm.scenes.gravity import Gravity


def demands(scene):
    """(capability, what it must be or hold, key, value) of all that a scene asks for."""
    yield "dimensions", scene.dimension, "dimension", scene.dimension
    yield "precisions", scene.solver.precision, "solver.precision", scene.solver.precision
    if scene.saw_test:
        yield "saw_test", True, "solver.method", scene.solver.method
    if scene.terrain:
        yield "terrain", True, "terrain.kind", scene.terrain.kind
    if scene.obstacles:
        yield "obstacles", True, "obstacles.0.name", scene.obstacles[0].name
    for i, body in enumerate(scene.bodies):
        if body.contact == "separate":
            yield "separate_bodies", True, f"bodies.{i}.contact", body.contact
    if scene.domain and "periodic" in scene.domain.sides(scene.dimension).values():
        yield "periodic", True, "domain.boundary", "periodic"
    if scene.initial.stress != "none":
        yield "initial_stress", True, "initial.stress", scene.initial.stress
    if scene.initial.stress == "settle":
        yield "settling", True, "initial.stress", scene.initial.stress
    for i, event in enumerate(scene.events):
        yield event.NEEDS, True, f"events.{i}.kind", event.kind
    if isinstance(scene.gravity, Gravity):
        yield "forcing", True, "gravity", "a table"
    for i, force in enumerate(scene.forces):
        yield "forcing", True, f"forces.{i}.kind", force.kind
    if scene.damping:
        yield "forcing", True, "damping.coefficient", scene.damping.coefficient


def refuse_beyond(scene):
    """Refuse, by an InputError, a scene that asks for what its method cannot do."""
    for capability, wanted, key, value in demands(scene):
        require(scene, capability, key, value, wanted)


def require(scene, capability, key, value, wanted=True, what=""):
    """Refuse `key` = `value`, by an InputError, where the scene's method lacks a capability.

    what: of the message, where the key does not say it all.
    """
    name = scene.solver.method
    able = who_can(capability, wanted)
    if name in able:
        return
    others = " or ".join(f'"{other}"' for other in able) or "another one"
    own = getattr(METHODS[name].capabilities, capability)
    bound = f", which has {' and '.join(map(str, own))} only" if isinstance(own, tuple) else ""
    if key == "solver.method":
        allowed = f"must be {others} {what or f'beside {capability}'}"
    else:
        allowed = f'needs solver.method = {others} in place of "{name}"{bound}'
    raise InputError.at(key, value, allowed, scene.source)
