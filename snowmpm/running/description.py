"""Description of a scene before it runs: model and size in numbers."""

import numpy as np

from snowmpm import components, memory
from snowmpm.io import layout
from snowmpm.running.forecast import forecast
from snowmpm.running.friction_class import class_chosen
from snowmpm.scenes.stop import rests_until
from snowmpm.scenes.switch import parts
from snowmpm.stepping.abilities import expected_dt


def written_fields(scene):
    """Names of the fields of a frame: those that the scene names, and the depth of columns, which films need."""
    in_plan = any(part.solver.in_plan for part in parts(scene))
    return dict.fromkeys([*scene.output.fields, *(["depth"] if in_plan else [])])


def expected_run_file(scene, particles):
    """Expected size of the run file [bytes]."""
    frames = 1 + max(1, round((scene.end_time - rests_until(scene)) / scene.output.interval))
    components = 3 + sum({"velocity": 3, "stress": 6}.get(name, 1) for name in written_fields(scene))
    return layout.expected_size(scene.dimension, frames, particles, components)


def _acting(model):
    """Facts of a scene beyond its numbers of particles: reference system, cut bodies, another run, forces, damping."""
    scene, told = model.scene, {}
    if scene.terrain and scene.terrain.get("file"):
        system = model.surface.system
        told["coordinates"] = system.name if system else "the terrain names no system: taken as metres"
    cut = {name: f"{100.0 * share:.4g} % of its volume, the rest lies beyond symmetric sides"
           for name, share in model.shares.items() if share < 1.0}
    if cut:
        told["cut_bodies"] = cut
    if scene.solver.in_plan:
        told["method"] = (f"depth-averaged{' outside the zone' if scene.zone else ''}: of the materials, only their"
                          " densities play a part; the friction of the ground is all that resists")
    if scene.choices:
        told["chosen"] = "; ".join(map(str, scene.choices))
    if model.taken:
        source = model.taken.source
        told["starts_from"] = (f"{source['run']} (scene {source['scene']}) at t = {source['time']:.6g} s:"
                               f" {', '.join(model.taken.bodies)}")
        if model.taken.differences:
            told["changed_since"] = "; ".join(model.taken.differences)
    if model.gravity is not None:
        first, last = model.gravity.at(0.0), model.gravity.at(scene.end_time)
        told["gravity"] = f"from {_vector(first)} to {_vector(last)} m/s2"
    forces = {f"{i} {force.kind}": f"{force.told()}{force.when}" for i, force in enumerate(scene.forces)}
    if forces:
        told["forces"] = forces
    if begin := rests_until(scene):
        told["begins"] = f"at t = {begin:g} s, the last frame before the first event: until then the settled snow rests"
    for component in components.used(scene):
        told.update(component.told(scene))
    return told


def _vector(values):
    return f"[{', '.join(f'{round(float(value), 4) + 0.0:g}' for value in values)}]"


SLOW = 1.0
"""Speed [m/s] of blocks below which it says nothing of a flow, which its own pressure drives."""


def describe(model, solver):
    """Facts of the model: {"dimension", "particles": {body: n}, "blocks", "memory": most of a run, "run_file" and
    "checkpoint": sizes [bytes], "bytes_per_particle", "fields", "dt" [s], "dt_cause", "steps", "domain"}; before
    them, where a scene has them, "coordinates" (their reference system), "cut_bodies", "chosen" (numerics that it
    leaves open, and why), "starts_from", "gravity", "forces" and "damping", in words."""
    scene, store, told = model.scene, solver.particles, _acting(model)
    counts = np.diff([*model.body_starts, len(model.population.volumes)])
    coming, kind = forecast(scene, solver), scene.solver.pieces
    steps = int(np.ceil(coming.steps))
    if coming.course:
        speed = f", at {coming.course.speed:.0f} m/s" if coming.course.speed >= SLOW else ""
        told["expected_end"] = f"at t = {coming.end:.3g} s, by blocks that slide without pressure{speed}"
    if chosen := class_chosen(model):
        told["friction"] = f"{chosen}, by the volume of the release, {model.release_volume:.4g} m3"
    maps = model.map_grid.memory if scene.dimension == 3 else 0.0
    particles, width = int(counts.sum()), sum(store.sizes.values())
    return {
        **told,
        "dimension": scene.dimension,
        kind: {"with snow at the start": store.count} if scene.solver.in_volumes else {
            body.name: int(n) for body, n in zip(scene.bodies, counts, strict=True)},
        "mass": store.mass,
        "blocks": store.n_blocks,
        "memory": memory.of_run(scene.dimension, particles, store.bytes_per_particle, width, solver.memory + maps),
        "run_file": expected_run_file(scene, particles),
        "checkpoint": particles * width * store.number_bytes + 8 * particles,
        "bytes_per_particle": store.bytes_per_particle,
        "fields": store.sizes,
        "dt": coming.dt,
        "dt_cause": "fixed" if scene.solver.dt else expected_dt(solver)[1],
        "steps": steps,
        "domain": (model.lower.tolist(), model.upper.tolist()),
    }
