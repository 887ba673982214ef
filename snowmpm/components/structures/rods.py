"""Rods and frameworks in the snow: loads of their segments, their motion, their numbers in the history.

Weak coupling: in a step the snow meets each segment where it is, with the velocity that it has, as a rigid obstacle;
then the rod moves for as long under the mean forces and moments of that step. Strong: with the mean velocity of
the rod over the step, which is sought (`quasi_newton`), so that a rod may be lighter than the snow that contact holds
at its velocity. One way: the snow meets the rod as it stands at the start, and the rod moves under what that
gives, or is where it would rest under it (`framework_rest`). Where the snow begins settled, a framework begins at rest
under its weight and the loads of the first step.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.components.structures.framework import Framework
from snowmpm.components.structures.framework_rest import bring_to_rest, unknowns
from snowmpm.components.structures.quasi_newton import QuasiNewton
from snowmpm.components.structures.rod import Rod
from snowmpm.errors import SimulationError

STILL = 1e-6
"""Speed over that of waves in a rod that counts as none."""


@dataclass(frozen=True, eq=False)
class Standing:
    """A `Rod` or `Framework`: first, number of the obstacle that is its first segment; strong: whether it answers
    within the step; rests: in which steps it goes to rest in place of moving on, "always" or "first", a `Framework`."""

    name: str
    rod: Rod | Framework
    first: int
    strong: bool = False
    rests: str = "never"


class Rods:
    """All rods and frameworks of a scene."""

    def __init__(self, rods, dim):
        """rods: `Standing`s; dim: of the scene."""
        self.rods, self.dim = list(rods), dim
        self._axes = [0, 2] if dim == 2 else [0, 1, 2]
        self.strong = [each for each in self.rods if each.strong]
        """`Standing`s that answer within the step"""
        self._newton = QuasiNewton(sum(len(each.rod.free) for each in self.strong) * dim)
        self.begin()

    def begin(self):
        """Time zero: straight, at rest."""
        for each in self.rods:
            each.rod.begin()
        self._last, self._gained = None, np.zeros((len(self.rods), 3))
        self._newton.forget()
        self._pushes: Any = 0.0
        self.rounds, self.unsettled = 0, 0

    def advance(self, time, dt, gravity, totals):
        """A step of dt [s] under gravity (dim,) [m/s2]; totals (obstacles, ...): what the snow gave all obstacles so
        far (`stepping.contract.PushesObstacles.obstacle_totals`)."""
        first = self._last is None
        gains = totals - (np.zeros_like(totals) if first else self._last)
        self._last, self._pushes = np.array(totals), gains / dt
        for i, each in enumerate(self.rods):
            forces = self._forces(each, gravity, self._pushes)
            self._gained[i] += dt * forces.sum(axis=0)
            each.rod.met = None
            if each.rests == "always" or (each.rests == "first" and first):
                self._rest(each, dt, forces)
            else:
                each.rod.advance(dt, forces)

    def _rest(self, each, dt, forces):
        """Bring a `Standing` to rest: its feet give what loads and its own momentum do not."""
        lost = each.rod.masses @ each.rod.v + dt * forces.sum(axis=0)
        try:
            bring_to_rest(each.rod, forces)
        except SimulationError as error:
            raise SimulationError(f"structure {each.name} {error}") from None
        each.rod.held[:] -= lost

    def _forces(self, each, gravity, pushes):
        """Forces (nodes, 3) [N] on the nodes of a `Standing`; pushes (obstacles, ...): of the snow, a second."""
        rod, weight = each.rod, np.zeros(3)
        weight[self._axes] = gravity
        forces = rod.masses[:, None] * weight
        force, moment = self._in_space(pushes[each.first : each.first + rod.n, :-1])
        lower, upper = rod.ends.T
        edges = rod.x[upper] - rod.x[lower]
        couple = np.cross(moment, edges) / (edges**2).sum(axis=1)[:, None]
        np.add.at(forces, lower, 0.5 * force - couple)
        np.add.at(forces, upper, 0.5 * force + couple)
        return forces

    def _in_space(self, rows):
        """Forces and moments (n, 3) of rows (n, dim + 1 or 3)."""
        if self.dim == 3:
            return rows[:, :3], rows[:, 3:]
        force, moment = np.zeros((2, len(rows), 3))
        force[:, [0, 2]], moment[:, 1] = rows[:, :2], -rows[:, 2]
        return force, moment

    def workload(self, dt):
        """Of a step of dt [s]: how often each row of the costs of structures counts."""
        frames = [each for each in self.rods if isinstance(each.rod, Framework)]
        moving = [each.rod for each in frames if each.rests != "always"]
        return {"segment": sum(each.rod.n for each in self.rods if each not in frames),
                "element": sum(each.rod.n for each in frames),
                "substep": sum(one.n * int(np.ceil(dt / one.substep)) for one in moving),
                "unknown": sum(unknowns(each.rod) for each in frames if each.rests == "always"),
                "strong segment": len(self.segments_of_strong)}

    # ---- answers within the step ------------------------------------------------------------------------------

    @property
    def segments_of_strong(self):
        """Numbers of the obstacles that are segments of rods that answer within the step."""
        return [each.first + s for each in self.strong for s in range(each.rod.n)]

    def meet(self, x):
        """Let the snow meet the rods that answer with velocities x (m,) [m/s] of their nodes but the clamped ones."""
        at = 0
        for each in self.strong:
            free = each.rod.free
            size = len(free) * self.dim
            each.rod.met = np.zeros_like(each.rod.v)
            each.rod.met[np.ix_(free, self._axes)] = x[at : at + size].reshape(-1, self.dim)
            at += size

    def answer(self, dt, gravity, gains):
        """Their means over a step of dt [s] in which the snow gives gains (obstacles, ...); nothing is moved."""
        found = []
        for each in self.strong:
            kept, start = each.rod.state(), each.rod.x.copy()
            each.rod.advance(dt, self._forces(each, gravity, gains / dt))
            # Light nodes swing within a step: the velocity that they end it with has little to do with their way
            found.append(((each.rod.x - start) / dt)[np.ix_(each.rod.free, self._axes)].ravel())
            each.rod.restore(kept)
        return np.concatenate(found)

    def agree(self, answer, dt, gravity):
        """Find velocities that are their own `answer`(x), and leave the snow met with them. The first guess has the
        forces of the step before."""
        pushes = self._pushes if np.ndim(self._pushes) else np.zeros((max(self.segments_of_strong) + 1, self.dim + 4))
        start = self.answer(dt, gravity, dt * pushes)
        fastest = max(each.rod.wave_speed for each in self.strong)
        floor = max(np.linalg.norm(gravity) * dt, STILL * fastest) * np.sqrt(len(start))
        x, rounds, settled = self._newton.solve(answer, start, floor)
        self.rounds += rounds
        if not settled:
            self.unsettled += 1
            answer(x)

    # ---- reading ----------------------------------------------------------------------------------------------

    def row(self, gravity):
        """Numbers of the history: those of each structure by "NAME_top_x" and so on; what is left open of the balance
        of momentum."""
        found, left, size = {}, 0.0, 0.0
        for each, gained in zip(self.rods, self._gained, strict=True):
            rod = each.rod
            found.update({f"{each.name}_{part}": value for part, (value, _) in rod.numbers(self.dim).items()})
            momentum = rod.masses @ rod.v
            left += float(np.linalg.norm(momentum - gained - rod.held))
            size += float(np.linalg.norm(momentum) + np.linalg.norm(gained) + np.linalg.norm(rod.held))
        return {**found, "structure_energy": sum(each.rod.energy for each in self.rods),
                "structure_momentum_residual": left / size if size > 0.0 else 0.0,
                "structure_rounds": float(self.rounds), "structure_unsettled": float(self.unsettled)}

    def units(self):
        """Unit of each number of `row` that carries the name of a structure."""
        return {f"{each.name}_{part}": unit for each in self.rods
                for part, (_, unit) in each.rod.numbers(self.dim).items()}

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"rods": [each.rod.state() for each in self.rods], "gained": self._gained.copy(),
                "inverse": self._newton.inverse.copy(), "rounds": self.rounds, "unsettled": self.unsettled,
                "pushes": np.zeros((0, 0)) if np.ndim(self._pushes) == 0 else self._pushes.copy(),
                "last": np.zeros((0, 0)) if self._last is None else self._last.copy()}

    def restore(self, state):
        """Take over what `state()` gave."""
        for each, own in zip(self.rods, state["rods"], strict=True):
            each.rod.restore(own)
        self._gained = np.array(state["gained"], float)
        self._last = None if state["last"].size == 0 else np.array(state["last"], float)
        self._newton.inverse = np.array(state["inverse"], float)
        self.rounds, self.unsettled = int(state["rounds"]), int(state["unsettled"])
        self._pushes = 0.0 if state["pushes"].size == 0 else np.array(state["pushes"], float)
