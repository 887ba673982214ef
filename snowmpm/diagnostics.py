"""The audit of a run: what is conserved, what is dissipated, how far the snow got.

Energies per run [J] (per metre of width in 2-D): kinetic m v^2 / 2; affine m D C:C / 2, the part of an affine transfer
that v leaves out (D: second moment of the spline); elastic psi V with psi of each law; potential -m g.x. The remainder
is what the scheme itself takes: start minus now, less plastic work, what contact took and what left the domain.

Null-space noise: the share of the kinetic energy of the particles, affine part included, that the grid cannot see,

    (T_p - T_g) / T_p,   T_g = sum_i |sum_p w_ip m_p (v_p + C_p (x_i - x_p))|^2 / 2 m_i

with C in APIC and AFLIP only. It lies between 0 and 1 (Jensen's inequality, node by node); 0 means that all particles
around each node agree on its velocity. A linear velocity has none in APIC; in PIC and FLIP it shows the variation
within a cell, D |grad v|^2 / v^2. What is beyond that are modes without force: they do no harm until they move
particles apart.

Emptied cells have no particle, but one on either side of them along an axis: where a body was stretched until its
particles lie more than a cell apart, the grid is about to tear it, whatever its material (numerical fracture). Grains
in the air count too.
"""

import numpy as np

from snowmpm.blocks import keys_of

UNITS = {
    "mass": "kg", "momentum_x": "kg m/s", "momentum_y": "kg m/s", "momentum_z": "kg m/s", "kinetic_energy": "J",
    "affine_energy": "J", "elastic_energy": "J", "potential_energy": "J", "plastic_work": "J", "contact_work": "J",
    "removed_energy": "J", "energy_remainder": "J", "null_space_noise": "1", "occupied_cells": "1",
    "emptied_cells": "1",
    "momentum_residual": "1", "max_speed": "m/s", "front": "m", "runout": "m", "removed_particles": "1",
    "removed_mass": "kg", "unconverged": "1", "plastic_fraction": "1", "min_J": "1", "max_J": "1", "dt": "s",
    "steps": "1", "particles": "1",
}

FRONT_SHARE = 0.995
"""Share of the moving mass behind the front: single grains that fly ahead are not the avalanche."""

MOVED_CELLS = 2.0
"""Displacement [cells] beyond which snow counts as moving."""


def occupied_and_emptied(cells):
    """Number of grid cells that hold particles, and of those that hold none between two that do; cells (n, dim):
    positions in cells. 0.15 s for 5e5 particles."""
    dim = cells.shape[1]
    occupied = np.unique(keys_of(np.floor(cells).astype(np.int64)))
    emptied = []
    for step in keys_of(np.eye(dim, dtype=np.int64)) - keys_of(np.zeros((1, dim), np.int64)):
        bridged = occupied[np.isin(occupied + 2 * step, occupied) & ~np.isin(occupied + step, occupied)]
        emptied.append(bridged + step)
    return len(occupied), len(np.unique(np.concatenate(emptied)))


class Audit:
    """History values of a solver against its state at the start.

    Moving snow is what has left its place by `MOVED_CELLS` grid spacings. front: where its front is, along `direction`
    (unit vector in plan), from the centroid of all snow at the start; runout: the same from the highest place it left.
    A slab that lets go as a whole has a front as soon as it has left its place: at its lower end, its length away.
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
        solver, mass, v, x = self._solver, fields["mass"], fields["velocity"], fields["position"]
        return {
            "kinetic_energy": 0.5 * float(mass @ (v**2).sum(axis=1)),
            "affine_energy": 0.5 * solver.second_moment() * float(mass @ (fields.velocity_gradient() ** 2).sum(axis=1)),
            "elastic_energy": solver.materials.elastic_energy(fields["material"], fields.kirchhoff(), fields.state(),
                                                              fields["volume"] / fields["J"]),
            "potential_energy": -float(mass @ ((x - self._reference) @ solver.gravity)),
        }

    def values(self, fields):
        """One row of the history."""
        solver, removed = self._solver, self._solver.particles.removed
        mass, v, x = fields["mass"], fields["velocity"], fields["position"]
        momentum = mass @ v
        names = ["momentum_x", "momentum_z"] if solver.dim == 2 else ["momentum_x", "momentum_y", "momentum_z"]
        energies = self._energies(fields)
        row = {"mass": float(mass.sum()), **dict(zip(names, momentum.tolist(), strict=True)), **energies}
        row["plastic_work"], row["contact_work"] = solver.plastic_work, solver.contact_work
        lift = float(self._reference @ solver.gravity)  # of the place where the potential energy is zero
        row["removed_energy"] = removed["energy"] + removed["mass"] * lift
        row["energy_remainder"] = self._start_energy - sum(energies.values()) - sum(
            row[name] for name in ("plastic_work", "contact_work", "removed_energy"))
        row["momentum_residual"] = self._momentum_residual(momentum)
        row["max_speed"] = float(np.sqrt((v**2).sum(axis=1).max(initial=0.0)))
        row["front"], row["runout"] = self._front(x, mass, fields["id"])
        row["removed_particles"], row["removed_mass"] = removed["count"], removed["mass"]
        row["unconverged"] = solver.unconverged
        row["plastic_fraction"] = solver.n_plastic / max(1, len(mass))
        row["min_J"], row["max_J"] = float(fields["J"].min(initial=1.0)), float(fields["J"].max(initial=1.0))
        row["occupied_cells"], row["emptied_cells"] = occupied_and_emptied((x - solver.frame.origin) / solver.dx)
        row["steps"], row["particles"] = solver.steps, len(mass)
        # Last: the particles may have to be sorted for it, and some removed
        motion = row["kinetic_energy"] + row["affine_energy"]
        row["null_space_noise"] = solver.null_space_noise(motion) if motion > 0.0 else 0.0
        return row

    def _momentum_residual(self, momentum):
        """|p - p_start - impulses| over the sum of their sizes: 0 when the balance closes."""
        s = self._solver
        parts = [momentum, -self._start_momentum, s.particles.removed["momentum"], -s.weight_impulse, -s.impulse]
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
