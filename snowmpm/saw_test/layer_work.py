"""The weak layer of a saw test: its particles as they are now, and the work that they took,

    V ( int tau : d dt + psi_0 - psi ),     d = sym grad v

of an interface (`particles.interface`) with d the strain of the layer, so that the integral is that of the traction
over the displacement.
"""

import numpy as np

from snowmpm.materials.symmetric import PAIRS, size
from snowmpm.particles.interface_probe import InterfaceProbe

BROKEN = 0.99
"""Damage of a particle that has lost its strength."""


class LayerWork:
    """What both kinds of layers share; each knows `there` (n,), the particles that no saw has taken or cut, `broken`
    (n,), those that have lost their strength, and the columns `_stress` (n, sym_size) and `_state` (n, STATE of the
    law)."""

    def __init__(self, law):
        self._law = law

    def damage(self, chosen=slice(None)):
        """Of all or some particles (n,) [-]; 0 for a law without one."""
        states = self._states(chosen)
        return np.broadcast_to(self._law.outputs(states).get("damage", 0.0), len(states))

    def work(self, chosen=slice(None)):
        """Of all or some particles so far (n,) [J]."""
        return self._volume(chosen) * (self.dissipated[chosen] - self._elastic(chosen))

    def _elastic(self, chosen=slice(None)):
        """psi [J/m3], 0 for those that the saw removed."""
        stored = self._stress(chosen)
        stress = np.zeros((len(stored), 6))
        stress[:, : stored.shape[1]] = stored
        return np.where(self.there[chosen], self._law.elastic_energy(stress, self._states(chosen)), 0.0)


class ParticleLayer(LayerWork):
    """A layer of cells, by the stress power of its particles between readings of a `particles.probe.Probe`."""

    def __init__(self, probe, part, law, solver):
        """part: slice of the layer in the probe, which others read too."""
        super().__init__(law)
        self._probe, self._part, self._solver = probe, part, solver
        self._power, self._read_at = self._stress_power(), solver.time
        self.dissipated = self._elastic()

    @property
    def there(self):
        return self._probe.there[self._part]

    @property
    def broken(self):
        return self.damage() >= BROKEN

    def follow(self):
        """Take in the time since the last call, after the probe was read."""
        power, time = self._stress_power(), self._solver.time
        self.dissipated += 0.5 * (self._power + power) * (time - self._read_at)
        self._power, self._read_at = power, time

    def _column(self, name, chosen=slice(None)):
        return self._probe.column(name, self._part)[chosen]

    def _volume(self, chosen):
        return self._column("volume", chosen)[:, 0]

    def _stress(self, chosen):
        return self._column("stress", chosen)

    def _states(self, chosen=slice(None)):
        return self._column("state", chosen)[:, : len(self._law.STATE)]

    def _stress_power(self):
        """tau : d [W/m3] (n,)."""
        dim = self._solver.frame.dim
        stress, gradient = self._column("stress"), self._column("affine").reshape(-1, dim, dim)
        power = sum(stress[:, c] * (gradient[:, i, j] + gradient[:, j, i]) * (0.5 if i == j else 1.0)
                    for c, (i, j) in enumerate(PAIRS[: size(dim)]) if max(i, j) < dim)
        return np.where(self.there, power, 0.0)

    def state(self):
        return {"dissipated": self.dissipated, "power": self._power, "read_at": self._read_at}

    def restore(self, state):
        self.dissipated = np.array(state["dissipated"])
        self._power, self._read_at = state["power"], state["read_at"]


class PointLayer(LayerWork):
    """A layer of points, by what an `InterfaceProbe` follows in each step."""

    def __init__(self, numbers, total, volumes, law, solver):
        """numbers (n,) of the points, of `total`; volumes (n,) [m3] of the layer below them."""
        super().__init__(law)
        self._probe, self._solver = InterfaceProbe(solver.particles, numbers, total), solver
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

    def follow(self):
        """Take in the step; -> whether some of the points that are waited for have broken in it."""
        self._probe.follow()
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
