"""How a saw test cuts its weak layer, and what its record reads of it: a layer of particles, or what a component has in
its place."""

import numpy as np

from snowmpm import components
from snowmpm.registry import resolved
from snowmpm.saw_test.layer_work import ParticleLayer

STROKE = 0.5
"""Advance of the saw at a time [cells]: the grid resolves no less."""


def weak_layer_of(scene):
    """`WeakLayer` of a scene with a saw test, or that of a component that carries it."""
    body = next(body for body in scene.bodies if body.name == "weak_layer")
    for component in components.used(scene):
        if component.saw and component.carries(scene, body):
            return resolved(component.saw)(scene)
    return WeakLayer(scene)


class WeakLayer:
    """A weak layer of particles, which the saw removes."""

    EACH_STEP = False
    """whether its work and arrivals are followed in each step"""

    def __init__(self, scene):
        self.scene, self.dx, self.spec = scene, scene.solver.dx, scene.saw_test.drawn(scene.solver.dx).weak_layer

    @property
    def finest(self):
        """Least width of the bins of a record [m]."""
        return self.dx

    @property
    def stroke(self):
        """Advance of the saw at a time [m]."""
        return STROKE * self.dx

    def rows(self, spacing):
        """Particles through the layer, which lie `spacing` [m] apart."""
        return max(1, round(self.spec.thickness / spacing))

    def along(self, positions, lean, bottom):
        """Coordinates (n,) [m] along the column of its particles; lean: of its ends, which begin at z = bottom [m]."""
        return positions[:, 0] - lean * (positions[:, -1] - bottom)

    def interval(self, bin_width, wave):
        """Time between rows of the record [s]: in which a wave [m/s] crosses a bin [m]."""
        return bin_width / wave

    def cut(self, simulation, body, reached):
        """Remove the layer, `body`, with x < reached [m]."""
        fields = simulation.particles
        gone = (fields["body"] == body) & (fields["position"][:, 0] < reached)
        if gone.any():
            simulation.solver.remove(gone)

    def followed(self, solver, weak, slab, population, law):
        """A probe (`particles.probe.Probe`) of the slab's particles `slab` (k,), which of its rows these are, and
        `layer_work.LayerWork` of the layer's, `weak` (n,)."""
        first, total = len(weak), len(population.volumes)
        probe = solver.particles.probe(np.concatenate([weak, slab]), total)
        return probe, slice(first, None), ParticleLayer(probe, slice(first), law, solver)
