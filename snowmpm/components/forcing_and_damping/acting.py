"""Forces, damping and gravity of a scene, in the steps of a method."""

from snowmpm.components.forcing_and_damping.damping import Damping
from snowmpm.components.forcing_and_damping.fields import AccelerationBy
from snowmpm.components.forcing_and_damping.forcing import Forcing
from snowmpm.errors import InputError
from snowmpm.registry import resolved
from snowmpm.scenes.formula import compiled


def adapter(model):
    """`Forcing` of the scene of a `Model`; its time starts at time zero."""
    scene = model.scene
    names, ends = [body.name for body in scene.bodies], [*model.body_starts, len(model.population.volumes)]
    fields = []
    for i, spec in enumerate(scene.forces):
        if (acts := resolved(type(spec).ACTS)) is None:  # of another component
            continue
        body = names.index(spec.body) if spec.get("body") is not None else None
        numbers = None if body is None else (ends[body], ends[body + 1])
        try:
            fields.append(acts(spec, scene.dimension, scene.base_dir, f"forces.{i}",
                               lambda text: compiled(text, scene.dimension), numbers,
                               model.surface.system if model.surface else None))
            fields[-1].refuse_infinite(model.population.positions[slice(*numbers or (None,))], scene.end_time)
        except InputError as error:
            raise InputError(f"{scene.source}: {error}") from None
    return Forcing(model.gravity, fields, Damping(scene.damping) if scene.damping else None)


def accelerate(solver, function):
    """Let an acceleration, function(x (n, dim), v (n, dim), time) -> (n, dim) or (dim,), act in a solver from now
    on."""
    forcing = next((one for one in solver.adapters if isinstance(one, Forcing)), None)
    if forcing is None:
        forcing = Forcing()
        solver.adapters.add(forcing, solver)
    forcing.fields.append(AccelerationBy(function))
