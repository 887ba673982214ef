"""The audit of a run: what is conserved, what is dissipated, how far the snow got.

Energies per run [J] (per metre of width in 2-D): kinetic m v^2 / 2; elastic psi V with psi of each law; potential
-m g.x. The remainder is what the scheme
itself takes: start minus now, less plastic work, less what contact took.
"""

import numpy as np

UNITS = {
    "mass": "kg", "momentum_x": "kg m/s", "momentum_y": "kg m/s", "momentum_z": "kg m/s", "kinetic_energy": "J",
    "elastic_energy": "J", "potential_energy": "J", "plastic_work": "J", "contact_work": "J", "energy_remainder": "J",
    "momentum_residual": "1", "max_speed": "m/s", "front": "m", "runout": "m", "removed_particles": "1",
    "removed_mass": "kg", "unconverged": "1", "plastic_fraction": "1", "min_J": "1", "max_J": "1", "dt": "s",
    "steps": "1", "particles": "1",
}

FRONT_SHARE = 0.995
"""Share of the moving mass behind the front: single grains that fly ahead are not the avalanche."""

MOVED_CELLS = 2.0
"""Displacement [cells] beyond which snow counts as moving."""


class Audit:
    """History values of a solver against its state at the start.

    Moving snow is what has left its place by `MOVED_CELLS` grid spacings. front: where its front is, along `direction`
    (unit vector in plan), from the centroid of all snow at the start; runout: the same from the highest place it left.
    Both [m] in plan; 0 while nothing moves.
    """

    def __init__(self, solver, fields, direction, start_positions):
        """start_positions: (n, dim) by particle number."""
        self._solver = solver
        self._direction = np.asarray(direction, float)
        x, mass = fields["position"], fields["mass"]
        self._reference = (mass[:, None] * x).sum(axis=0) / max(mass.sum(), 1e-300)
        self._start = start_positions
        self._start_momentum = mass @ fields["velocity"]
        self._start_energy = sum(self._energies(fields).values())

    def state(self):
        """The reference values, by name."""
        return {"reference": self._reference, "start": self._start, "momentum": self._start_momentum,
                "energy": self._start_energy}

    def restore(self, state):
        """Take over what `state()` gave."""
        self._reference, self._start = state["reference"], state["start"]
        self._start_momentum, self._start_energy = state["momentum"], state["energy"]

    def _along(self, x):
        return (x[:, :-1] - self._reference[:-1]) @ self._direction

    def _energies(self, fields):
        mass, v, x = fields["mass"], fields["velocity"], fields["position"]
        return {
            "kinetic_energy": 0.5 * float(mass @ (v**2).sum(axis=1)),
            "elastic_energy": self._elastic(fields),
            "potential_energy": -float(mass @ ((x - self._reference) @ self._solver.gravity)),
        }

    def _elastic(self, fields):
        tau, material = fields.kirchhoff(), fields["material"]
        volume = fields["volume"] / fields["J"]
        state, energy = fields.state(), 0.0
        for m, law in enumerate(self._solver.materials.laws):
            own = material == m
            energy += float(volume[own] @ law.elastic_energy(tau[own], state[own]))
        return energy

    def values(self, fields):
        """One row of the history."""
        solver = self._solver
        mass, v, x = fields["mass"], fields["velocity"], fields["position"]
        momentum = mass @ v
        names = ["momentum_x", "momentum_z"] if solver.dim == 2 else ["momentum_x", "momentum_y", "momentum_z"]
        row = {"mass": float(mass.sum()), **dict(zip(names, momentum.tolist(), strict=True)), **self._energies(fields)}
        row["plastic_work"], row["contact_work"] = solver.plastic_work, solver.contact_work
        row["energy_remainder"] = (self._start_energy - row["kinetic_energy"] - row["elastic_energy"]
                                   - row["potential_energy"] - solver.plastic_work - solver.contact_work)
        row["momentum_residual"] = self._momentum_residual(momentum)
        row["max_speed"] = float(np.sqrt((v**2).sum(axis=1).max(initial=0.0)))
        row["front"], row["runout"] = self._front(x, mass, fields["id"])
        row["removed_particles"], row["removed_mass"] = solver.removed["count"], solver.removed["mass"]
        row["unconverged"] = solver.unconverged
        row["plastic_fraction"] = solver.n_plastic / max(1, len(mass))
        row["min_J"], row["max_J"] = float(fields["J"].min(initial=1.0)), float(fields["J"].max(initial=1.0))
        row["steps"], row["particles"] = solver.steps, len(mass)
        return row

    def _momentum_residual(self, momentum):
        """|p - p_start - impulses| over the sum of their sizes: 0 when the balance closes."""
        s = self._solver
        parts = [momentum, -self._start_momentum, s.removed["momentum"], -s.weight_impulse, -s.impulse]
        size = sum(np.linalg.norm(part) for part in parts)
        return float(np.linalg.norm(sum(parts)) / size) if size > 0.0 else 0.0

    def _front(self, x, mass, identity):
        start = self._start[identity]
        moved = np.linalg.norm(x - start, axis=1) > MOVED_CELLS * self._solver.dx
        if not moved.any():
            return 0.0, 0.0
        along, mass = self._along(x[moved]), mass[moved]
        order = np.argsort(along)
        behind = np.cumsum(mass[order])
        front = along[order[np.searchsorted(behind, FRONT_SHARE * behind[-1])]]
        return float(front), float(front - self._along(start[moved]).min())
