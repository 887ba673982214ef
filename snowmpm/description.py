"""What a scene will cost, in numbers, before it runs."""

import numpy as np

from snowmpm import memory
from snowmpm.io import layout


def _run_file(scene, particles):
    """Expected size of the run file [bytes]."""
    frames = 1 + max(1, round(scene.end_time / scene.output.interval))
    components = 3 + sum({"velocity": 3, "stress": 6}.get(name, 1) for name in scene.output.fields)
    return layout.expected_size(scene.dimension, frames, particles, components)


def describe(model, solver):
    """What will be modelled: {"dimension", "particles": {body: n}, "blocks", "memory": most of a run, "run_file" and
    "checkpoint": sizes [bytes], "bytes_per_particle", "fields", "dt" [s], "dt_cause", "steps", "domain"}."""
    scene, store = model.scene, solver.particles
    counts = np.diff([*model.body_starts, len(model.population.volumes)])
    dt, cause = solver.stable_dt()
    dt = scene.solver.dt or dt
    steps = int(np.ceil(scene.end_time / dt))
    particles = int(counts.sum())
    return {
        "dimension": scene.dimension,
        "particles": {body.name: int(n) for body, n in zip(scene.bodies, counts, strict=True)},
        "mass": solver.particles.mass,
        "blocks": len(solver.particles.blocks),
        "memory": memory.of_run(scene.dimension, particles, store.bytes_per_particle, store.layout.width,
                                solver.bytes),
        "run_file": _run_file(scene, particles),
        "checkpoint": particles * store.layout.width * store.numpy_dtype().itemsize + 8 * particles,
        "bytes_per_particle": solver.particles.bytes_per_particle,
        "fields": dict(solver.particles.layout.sizes),
        "dt": dt,
        "dt_cause": "fixed" if scene.solver.dt else cause,
        "steps": steps,
        "domain": (model.lower.tolist(), model.upper.tolist()),
    }
