"""The audit of a run: conserved quantities, dissipation, position of the front.

Energies per run [J] (per metre of width in 2-D): kinetic m v^2 / 2; affine m D C:C / 2, the part of an affine transfer
that v leaves out (D: second moment of the spline); elastic psi V with psi of each law; potential -m g.x, or minus the
work of gravity where that changes with time. Along a periodic axis this potential is not defined, since positions
repeat; there it is minus the work that gravity has done,

    W = g . int P dt,   P = P_start + impulses of weight, ground and loads - what left

which is -m g.(displacement of the centre of mass), however often the snow has crossed the domain. The remainder is the
dissipation of the scheme itself: energy at the start minus energy now, plus the work of the scene's forces, minus
plastic work, work taken by contact and damping, and energy that left the domain.

Null-space noise: the share of the kinetic energy of the particles, affine part included, that the grid cannot see,

    (T_p - T_g) / T_p,   T_g = sum_i |sum_p w_ip m_p (v_p + C_p (x_i - x_p))|^2 / 2 m_i

with C in APIC and AFLIP only. It lies between 0 and 1 (Jensen's inequality, node by node); 0 means that all particles
around each node agree on its velocity. A linear velocity has none in APIC; in PIC and FLIP it shows the variation
within a cell, D |grad v|^2 / v^2. Noise beyond that consists of modes without restoring force:
they are harmless until they move particles apart.

Emptied cells have no particle, but have particles on both sides along an axis. Where a body is stretched until its
particles are more than a cell apart, the grid is about to tear it, whatever its material (numerical fracture). Airborne
particles count too.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from snowmpm.particles.blocks import keys_of
from snowmpm.quantities.motion import Motion
from snowmpm.quantities.table import HISTORY, units_of
from snowmpm.stepping.abilities import null_space_noise, second_moment

UNITS = units_of(HISTORY)
"""Unit of each column of the history."""

FRONT_SHARE = 0.995
"""Share of the moving mass behind the front, so that single particles flying ahead do not count."""

MOVED_CELLS = 2.0
"""Displacement [cells] beyond which snow counts as moving."""

MOVED_SHARE = 0.005
"""Share of all snow that must have moved to define a front: a few displaced particles are not enough."""


TURNED = ("kinetic_energy", "elastic_energy", "plastic_work", "contact_work", "force_work")
"""Energies of a row that tell what was turned over, beside what components gave."""


def occupied_and_emptied(cells):
    """Number of grid cells with particles, and of empty cells between two of them along an axis; cells (n, dim):
    positions in cells. And which particles (n,) lie beside such an empty cell."""
    dim, keys = cells.shape[1], keys_of(np.floor(cells).astype(np.int64))
    occupied = _sorted_once(keys)
    emptied, beside = [], []
    for step in keys_of(np.eye(dim, dtype=np.int64)) - keys_of(np.zeros((1, dim), np.int64)):
        bridged = occupied[_among(occupied + 2 * step, occupied) & ~_among(occupied + step, occupied)]
        emptied.append(bridged + step)
        beside += [bridged, bridged + 2 * step]
    parted = _among(keys, _sorted_once(np.concatenate(beside)))
    return len(occupied), len(_sorted_once(np.concatenate(emptied))), parted


def _sorted_once(keys):
    """Sorted keys, each once: ten times as fast as `np.unique`, which hashes them."""
    ordered = np.sort(keys)
    return ordered[np.append(True, ordered[1:] != ordered[:-1])] if len(ordered) else ordered


def _among(wanted, keys):
    """Which of the wanted keys are among sorted ones."""
    if not len(keys):
        return np.zeros(len(wanted), bool)
    return keys[np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)] == wanted


def _sum(mass, values):
    """sum m a. Not by BLAS, which would share it among threads that then wait at work for 0.1 s, and whose last digits
    would be others on another number of cores."""
    return float((mass * values).sum())


def _sums(mass, rows):
    """The same of each column of rows (n, dim)."""
    return np.array([_sum(mass, column) for column in rows.T])


def _squares(rows):
    """Squared lengths of rows (n, k): several times as fast as sums of squares along the short axis."""
    return np.einsum("ij,ij->i", rows, rows)


class Audit:
    """History values of a solver against its state at the start.

    Moving snow is snow displaced by more than `MOVED_CELLS` grid spacings. front: position of its front along
    `direction` (unit vector in plan), from the centroid of all snow at the start; front_distance: the same from the
    highest place it left. A slab that is released as a whole has a front as soon as it has moved: at its lower end, one
    slab length away. Both [m] in plan. Both are 0 while less than `MOVED_SHARE` of the snow moves; front is also 0
    while it is behind that centroid, as when the snow is released at the upper end. Neither exists with direction None,
    as in saw tests, nor in a periodic domain, where snow comes back.
    """

    def __init__(self, solver, fields, direction, start_positions, plan=False):
        """solver: a `stepping.contract.Method`; direction: (dim - 1,) or None; start_positions: (n, dim) by particle
        number; plan: whether cells are those of a grid in plan."""
        self._axes = slice(0, -1) if plan else slice(None)
        self._solver, self._moved = solver, MOVED_CELLS * solver.frame.dx
        self.past = None
        """`running.relay.Past` of the methods before the one at work; None of the first."""
        repeats = solver.particles.repeats
        self._direction = None if direction is None or repeats[:-1].any() else np.asarray(direction, float)
        self._falling = np.where(repeats, 0.0, solver.gravity)  # axes with a potential
        x, mass, flows = fields["position"], fields["mass"], fields.flowing()
        self._reference = (mass[flows, None] * x[flows]).sum(axis=0) / max(mass[flows].sum(), 1e-300)
        self._start = start_positions
        self._start_momentum = _sums(mass, fields["velocity"])
        self._start_energy = sum(self.energies(fields).values())
        self.motion = Motion.of(mass[flows], fields["velocity"][flows])
        """Motion at the last row, or at the start (`snowmpm.quantities.motion.Motion`)."""

    def state(self):
        """The reference values, by name."""
        return {"reference": self._reference, "start": self._start, "momentum": self._start_momentum,
                "energy": self._start_energy, "peak_momentum": self.motion.peak_momentum}

    def restore(self, state):
        """Restore the result of `state()`."""
        self._reference, self._start = state["reference"], state["start"]
        self._start_momentum, self._start_energy = state["momentum"], state["energy"]
        # Checkpoints of older versions have no peak: it is the largest from here on
        self.motion = replace(self.motion, peak_momentum=state.get("peak_momentum", 0.0))

    def _along(self, x):
        return (x[:, :-1] - self._reference[:-1]) @ self._direction

    def continue_with(self, solver, relay):
        """Go on with the solver of another method; relay: `running.relay.Relay` that has made it."""
        self._solver, self._start, self.past = solver, relay.start, relay.past
        self._axes = slice(0, -1) if relay.scene.solver.in_plan else slice(None)

    @property
    def _totals(self):
        totals = self._solver.totals
        return self.past.plus(totals) if self.past else totals

    def energies(self, fields):
        """Energies [J] of `particles.fields.ParticleFields` by kind."""
        return self._energies(fields, fields["mass"], fields["velocity"], fields["position"])

    def _energies(self, fields, mass, v, x):
        solver = self._solver
        return {
            "kinetic_energy": 0.5 * _sum(mass, _squares(v)),
            "affine_energy": 0.5 * second_moment(solver) * _sum(mass, _squares(fields.velocity_gradient())),
            "elastic_energy": fields.materials.elastic_energy(fields["material"], fields.kirchhoff(), fields.state(),
                                                              fields["volume"] / fields["J"]),
            "potential_energy": self._potential_energy(mass, x),
        }

    def _own_potential(self):
        """Of a component whose gravity changes [J], else None."""
        found = (one.potential_energy() for one in self._solver.adapters)
        return next((energy for energy in found if energy is not None), None)

    def _potential_energy(self, mass, x):
        """-m g.x from the centroid at the start; along periodic axes, and for gravity that changes, minus its work."""
        solver = self._solver
        if (found := self._own_potential()) is not None:
            return found
        travel = self._start_momentum * solver.time + self._totals.momentum_gain  # [kg m]
        around = float((solver.gravity - self._falling) @ travel)
        return -_sum(mass, (x - self._reference) @ self._falling) - around

    def values(self, fields):
        """One row of the history."""
        solver, removed = self._solver, self._solver.particles.removed
        frame, totals = solver.frame, self._totals
        mass, v, x = fields["mass"], fields["velocity"], fields["position"]
        momentum = _sums(mass, v)
        flows = fields.flowing()
        names = ["momentum_x", "momentum_z"] if frame.dim == 2 else ["momentum_x", "momentum_y", "momentum_z"]
        energies = self._energies(fields, mass, v, x)
        row = {"mass": float(mass[flows].sum()), **dict(zip(names, momentum.tolist(), strict=True)),
               **self._angular_momentum(fields, mass, x, v), **energies}
        row["plastic_work"], row["contact_work"] = totals.plastic_work, totals.contact_work
        row["force_work"] = float(sum(one.force_work() for one in solver.adapters))
        row["damping_work"] = float(sum(one.damping_work() for one in solver.adapters))
        # Position of zero potential energy
        lift = float(self._reference @ self._falling) if self._own_potential() is None else 0.0
        entrained, laid = removed.get("entrained", 0.0), removed.get("laid", 0.0)
        row["removed_energy"] = removed["energy"] + (removed["mass"] + laid - entrained) * lift
        given: dict[str, Any] = {}
        for adapter in solver.adapters:
            row.update(adapter.row())
            given |= adapter.given(lift)
        row.update(given)
        got = row["force_work"] + sum(given.values())
        row["energy_remainder"] = self._start_energy + got - sum(energies.values()) - sum(
            row[name] for name in ("plastic_work", "contact_work", "damping_work", "removed_energy")) - (
            self.past.handover_energy if self.past else 0.0) - totals.handover_energy
        if totals.contact_lines is not None:
            row["contact_lines"], row["contact_spared"] = totals.contact_lines, totals.contact_spared
        turned = sum(abs(energy) for energy in (*(row[name] for name in TURNED), *given.values()))
        row["momentum_residual"] = self._momentum_residual(momentum, totals, np.sqrt(2.0 * row["mass"] * turned))
        row["max_speed"] = float(np.sqrt(_squares(v).max(initial=0.0)))
        self.motion = Motion.of(mass[flows], v[flows], self.motion.peak_momentum, laid)
        row.update(self.motion.row())
        if self._direction is not None:
            row["front"], row["front_distance"] = self._front(x[flows], mass[flows], fields["id"][flows])
        row["removed_particles"], row["removed_mass"] = removed["count"], removed["mass"]
        row["taken_mass"], row["laid_mass"] = removed["taken"], laid
        row["entrained_mass"] = entrained + sum(one.entrained() for one in solver.adapters)
        row["unconverged"] = solver.unconverged
        row["plastic_fraction"] = totals.yielding / max(1, len(mass))
        row["min_J"], row["max_J"] = float(fields["J"].min(initial=1.0)), float(fields["J"].max(initial=1.0))
        cells = ((x - frame.origin) / frame.dx)[:, self._axes]
        row["occupied_cells"], row["emptied_cells"], parted = occupied_and_emptied(cells)
        row["parted_share"] = float(mass[parted].sum() / max(row["mass"], 1e-300))
        row["steps"], row["particles"] = solver.steps, len(mass)
        # Last, since it may have to sort the particles and remove some
        motion = row["kinetic_energy"] + row["affine_energy"]
        row["null_space_noise"] = null_space_noise(solver, motion) if motion > 0.0 else 0.0
        return row

    def _angular_momentum(self, fields, mass, x, v):
        """About the centre of mass at the start [kg m2/s], with what the affine motion of particles has,

            L = sum m (x - x_0) x v + m D (C_ba - C_ab)

        In 2-D from x towards z. Where snow leaves at one side and comes back at the other there is none.
        """
        solver = self._solver
        if solver.particles.repeats.any():
            return {}
        dim, arm, D = solver.frame.dim, x - self._reference, second_moment(solver)
        turns = {"angular_momentum": (0, 1)} if dim == 2 else {
            f"angular_momentum_{axis}": pair for axis, pair in zip("xyz", ((1, 2), (2, 0), (0, 1)), strict=True)}
        C: Any = fields.velocity_gradient() if D else None
        found = {}
        for name, (a, b) in turns.items():
            found[name] = _sum(mass, arm[:, a] * v[:, b] - arm[:, b] * v[:, a])
            if D:
                found[name] += D * _sum(mass, C[:, b * dim + a] - C[:, a * dim + b])
        return found

    def _momentum_residual(self, momentum, totals, least):
        """|p - p_start - impulses| over the sum of their sizes: 0 when the balance closes. least [kg m/s]: smallest
        such sum, sqrt(2 m E) with the energy E that was turned over: where nothing moves, impulses may cancel to
        round-off."""
        left = self._solver.particles.removed["momentum"]
        # What acts on a body at rest cancels with what holds it: each counts for its own size
        given = [impulse for adapter in self._solver.adapters for impulse in adapter.impulses()]
        others = totals.impulse - sum(given)
        parts = [momentum, -self._start_momentum, left, -totals.weight_impulse, -others, *(-one for one in given)]
        size = max(sum(np.linalg.norm(part) for part in parts), least)
        return float(np.linalg.norm(sum(parts)) / size) if size > 0.0 else 0.0

    def _front(self, x, mass, identity):
        origins = self._solver.particles.origins
        start = (self._start if origins is None else origins)[identity]
        moved = _squares(x - start) > self._moved**2
        if not mass[moved].sum() > MOVED_SHARE * mass.sum():
            return 0.0, 0.0
        along, mass = self._along(x[moved]), mass[moved]
        order = np.argsort(along)
        behind = np.cumsum(mass[order])
        front = along[order[np.searchsorted(behind, FRONT_SHARE * behind[-1])]]
        return max(0.0, float(front)), float(front - self._along(start[moved]).min())
