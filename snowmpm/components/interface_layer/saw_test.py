"""Saw tests whose weak layer is an interface: the saw takes the stress of its points, which stay.

Their work is followed in each step (`.probe`): V ( int tau : d dt + psi_0 - psi ) with d the strain of the layer, the
integral of the traction over the displacement.
"""

import numpy as np

from snowmpm.saw_test.layer_work import BROKEN, LayerWork
from snowmpm.saw_test.weak_layer import WeakLayer


class PointedLayer(WeakLayer):
    """A weak layer of points."""

    EACH_STEP = True

    @property
    def finest(self):
        """Distance of its points [m]."""
        return self.dx / self.spec.interface

    @property
    def stroke(self):
        """The same."""
        return self.finest

    def rows(self, spacing):
        """One."""
        return 1

    def along(self, positions, lean, bottom):
        """Of their places on the face."""
        return positions[:, 0]

    def interval(self, bin_width, wave):
        """Time in which a wave crosses half a cell: bins are two points wide, and each step is followed besides."""
        return 0.5 * self.dx / wave

    def cut(self, simulation, body, reached):
        """Take the stress of the points with x < reached [m]."""
        state = simulation.law_of_body(body).severed_state()
        simulation.solver.adapters["interface_layer"].cut(simulation.numbers_of_body(body), reached, state)

    def followed(self, solver, weak, slab, population, law):
        """As of a layer of particles; the probe reads the slab alone."""
        total = len(population.volumes)
        probe = solver.particles.probe(slab, total)
        return probe, slice(None), PointLayer(weak, total, population.volumes[weak], law, solver)


class PointLayer(LayerWork):
    """A layer of points, by what a `PointProbe` follows in each step."""

    def __init__(self, numbers, total, volumes, law, solver):
        """numbers (n,) of the points, of `total`; volumes (n,) [m3] of the layer below them."""
        from snowmpm.components.interface_layer.probe import PointProbe  # it needs the compiler, a scene does not

        super().__init__(law)
        self._probe, self._solver = PointProbe(solver.particles, numbers, total), solver
        self._volumes = volumes.astype(self._probe.stress.dtype).astype(np.float64)  # as particles carry them
        self._probe.work += self._elastic()
        self.broken = self.damage() >= BROKEN

    @property
    def there(self):
        return self._probe.there & (self._probe.cut == 0.0)

    @property
    def dissipated(self):
        return self._probe.work

    def wait_for(self, points):
        """points (n,): those that shall be `broken` from now on when they are."""
        self._probe.waiting[:] = points

    def add_work(self):
        """Take in the step; -> whether some of the points that are waited for have broken in it."""
        self._probe.add_work()
        changed = np.flatnonzero(self._probe.changed)
        if not len(changed):
            return False
        broken = self.damage(changed) >= BROKEN
        news = broken != self.broken[changed]
        self.broken[changed] = broken
        return bool(news.any())

    def _volume(self, chosen):
        return self._volumes[chosen]

    def _stress(self, chosen):
        return self._probe.stress[chosen]

    def _states(self, chosen=slice(None)):
        return self._probe.state[chosen, : len(self._law.STATE)].astype(np.float64)

    def state(self):
        return {"dissipated": self.dissipated, "power": self._probe.load, "read_at": self._solver.time}

    def restore(self, state):
        self._probe.work[:], self._probe.load[:] = state["dissipated"], state["power"]
