"""The weak layer of a saw test: its particles as they are now, and the work that they took,

    V ( int tau : d dt + psi_0 - psi ),     d = sym grad v
"""

import numpy as np

from snowmpm.materials.symmetric import PAIRS, size

BROKEN = 0.99
"""Damage of a particle that has lost its strength."""


class LayerWork:
    """What all kinds of layers share; each knows `there` (n,), the particles that no saw has taken or cut, `broken`
    (n,), those that have lost their strength, and the columns `_stress` (n, sym_size) and `_state` (n, STATE of the
    law)."""

    def __init__(self, law):
        self._law = law

    def wait_for(self, particles):
        """particles (n,): those of which `follow` shall tell when they break; of one that is not followed in each
        step, none."""

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

    def add_work(self):
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
