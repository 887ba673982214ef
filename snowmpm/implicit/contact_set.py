"""Contact of a step that may change in it: snow that sticks by friction or slides, lies on a surface or parts from it.

Each line of nodes across a surface (`lines`) is in one state at the end of a step. With n out of the solid, the force F
on the line, F_n = n . F, and w = u - u*, u the displacement where the line meets the surface (u*: that with which it
ends at rest; 0 without inertia):

    open    F = 0,                                n . u >= 0
    stick   w = 0,                                F_n >= 0,  |F_t| <= mu F_n
    slide   n . u = 0,   F_t = -mu F_n w_t/|w_t|,  F_n >= 0

A surface that slips never parts from the snow, and rubs where F_n > 0. States are sought as an active set: a step is
solved with those at hand, lines that contradict theirs change it, until none does (Hueeber, Stadler & Wohlmuth 2008,
doi:10.1137/060671061). Within a set Newton's method is exact: friction follows from F_n, and so from the residuals at
the followers, so that it is a change of the test functions (`held.Held.rub`). A line that changes again and again has
no state: its followers are held one by one, and judged together. One that neither sticks nor slides then slides, one
that neither lies nor parts is open: there is no tension and no more friction than Coulomb's, and snow may come nearer
to the surface by a little. In 3-D the direction of sliding is that of the solution before.
"""

import numpy as np
from scipy import sparse

from snowmpm.implicit.held import FAINT, Held
from snowmpm.implicit.lines import Lines
from snowmpm.implicit.newton import NotConverged
from snowmpm.stepping.contact_velocity import OPEN, SEPARATE, SLIP, STICK

MOST_ROUNDS = 60

MOST_CHANGES = 4
"""Of a line, before it is left without a state."""

FORCE, WAY, TURN = 1e-8, 1e-7, 3e-3
"""Of the forces, of the largest displacement, and of a direction [rad]: what is left is within what Newton leaves."""


class ContactSet:
    """The contact of one part of a step. mesh: `Mesh`; surfaces: `surfaces.Surface`s; kernel; volume (n,): of the
    particles [cells]; extended: faint nodes follow others.

    held: `Held` of the states that they have now, without friction at first.
    """

    def __init__(self, mesh, surfaces, kernel, volume, extended=True):
        self.mesh, self._volume = mesh, volume if extended else None
        lines = [Lines(mesh, surface.distance, kernel) for surface in surfaces]
        self._all = list(zip(surfaces, lines, strict=True))
        filled = mesh.W.T @ volume
        faint = filled < FAINT if extended else np.zeros(mesh.n_nodes, bool)
        own = [(surface, found) for surface, found in self._all if not surface.fixed]
        sizes = [len(found) for _, found in own]

        def each(values, dtype=float):
            return np.repeat(np.array(values, dtype), sizes)

        self.code = each([surface.code for surface, _ in own], int)
        self.mu = each([surface.friction for surface, _ in own])
        self.obstacle = each([surface.obstacle for surface, _ in own], int)
        self._centres = [surface.centre for surface, _ in own if surface.obstacle >= 0]
        if not own:
            return
        self.normals = np.concatenate([found.normals for _, found in own])
        self._places = np.concatenate([found.places() for _, found in own])
        self.arrived = np.concatenate([found.arrived(filled) for _, found in own])
        self._of_all = np.concatenate([np.full(len(found), not surface.fixed) for surface, found in self._all])
        self._numbers = np.flatnonzero(self._of_all)
        self._traces = sparse.vstack([found.traces(faint) for _, found in own], format="csr")
        self.mu[faint[np.concatenate([found.heads for _, found in own])]] = 0.0  # a rim that bears next to nothing
        self.state = np.where(self.code == STICK, STICK, np.where(self.mu > 0.0, STICK, SLIP))
        self.state[(self.code == SEPARATE) & ~self.arrived] = OPEN
        self.along = np.zeros_like(self.normals)
        """direction of friction on the snow, 0 where there is none"""
        self._rounds, self._changed = 0, np.zeros(len(self.code), int)
        self._spared = np.zeros(len(self.code), bool)

    @property
    def changes(self):
        """Whether some surface does not hold always in the same way."""
        return len(self.code) > 0

    # ---- what holds the nodes ---------------------------------------------------------------------------------------

    def _held(self, state, past=None):
        codes, first = [], 0
        for surface, found in self._all:
            if surface.fixed:
                codes.append((found, surface.code))
            else:
                codes.append((found, state[first : first + len(found)]))
                first += len(found)
        self._now = Held(self.mesh, codes, self._volume, past)
        """by whose links residuals are forces"""
        return self._now

    def smooth(self, v=None):
        """`Held` without friction: of lines that approach their surface at the velocities v (N, dim) of the nodes,
        all open ones when missing."""
        if not self.changes:
            return self._held(np.zeros(0, int))
        parts = self.code == SEPARATE
        if v is None:
            return self._held(np.where(parts, OPEN, np.where(self.code == STICK, STICK, SLIP)))
        normal, tangent = self._parts(self._traces @ v)
        state = np.where(self.code == STICK, STICK, SLIP)
        state[parts & ~(self.arrived & (normal < 0.0))] = OPEN
        self.state, speed = state.copy(), np.linalg.norm(tangent, axis=1)
        slides = (state == SLIP) & (self.mu > 0.0)
        moving = slides & (speed > 0.0)
        self.state[slides & ~moving] = STICK
        self.along[moving] = -tangent[moving] / speed[moving, None]
        return self._held(state)

    def held(self, past=None):
        """`Held` of the states as they are, with friction. past (N, dim): u* of the nodes [m]."""
        held = self._held(self.state, past)
        if (self.state == SLIP).any() and self.along.any():
            friction = np.zeros((len(self._of_all), self.mesh.dim))
            friction[self._numbers] = np.where((self.state == SLIP)[:, None], self.mu[:, None] * self.along, 0.0)
            held.rub(friction)
        return held

    def _parts(self, vectors):
        """Normal (m,) and tangential part (m, dim) of vectors of the lines."""
        normal = np.einsum("ka,ka->k", vectors, self.normals)
        return normal, vectors - normal[:, None] * self.normals

    @property
    def nodes(self):
        """Which nodes the lines of surfaces that are not `fixed` hold, (N,)."""
        found = np.zeros(self.mesh.n_nodes, bool)
        for surface, lines in self._all:
            if not surface.fixed:
                found[lines.nodes] = True
        return found

    def _felt(self, full):
        """F (m, dim) of the constraints of lines."""
        return self._now.line_forces(full)[0][self._numbers]

    def _slid(self, trial, past=None):
        """How far lines slid (m, dim), 0 where nothing presses them."""
        way = self._now.slid(trial.full, trial.u if past is None else trial.u - past)
        return self._parts(way[self._numbers])[1]

    # ---- what they did ----------------------------------------------------------------------------------------------

    def forces(self, full, rubbing=True):
        """F (m, dim) [N] of residuals of the nodes (N, dim) with the `Held` made last; rubbing: lines that slide
        rub."""
        forces, of_sliding = (each[self._numbers] for each in self._now.line_forces(full))
        normal, tangent = self._parts(forces)
        friction = (rubbing * self.mu * self._parts(of_sliding)[0])[:, None] * self.along
        tangent = np.where((self.state == STICK)[:, None], tangent, friction)
        return np.where((self.state == OPEN)[:, None], 0.0, normal[:, None] * self.normals + tangent)

    def taken(self, trial):
        """Energy that friction took [J], with the forces at the end of the step."""
        return -float((self._parts(self.forces(trial.full))[1] * self._slid(trial)).sum())

    def counts(self):
        """Lines that touch, or are settled by a rule; those settled by a rule, since no state was found for them."""
        return int(((self.state != OPEN) | self._spared).sum()), int(self._spared.sum())

    def on_obstacles(self, full, dx, rubbing=True):
        """Force [N] and its moment [N m] (1 or 3 numbers) that the snow gives each obstacle, (n, dim + 1 or 3)."""
        dim, F = self.mesh.dim, -self.forces(full, rubbing)
        rows = []
        for i, centre in enumerate(self._centres):
            own = self.obstacle == i
            arm = dx * (self._places[own] - centre)
            moment = np.cross(np.pad(arm, ((0, 0), (0, 3 - dim))), np.pad(F[own], ((0, 0), (0, 3 - dim)))).sum(axis=0)
            rows.append([*F[own].sum(axis=0), *(moment[2:] if dim == 2 else moment)])
        return np.reshape(rows, (len(rows), dim + (1 if dim == 2 else 3)))

    def settle(self, trial, past=None):
        """Whether the `Trial` agrees with all states; else those that do not are others from now on. past: of `held`.

        Raises NotConverged when no set of states is found.
        """
        state, along = self._wanted(trial, past)
        turned = (np.abs(along - self.along) > TURN).any(axis=1)
        differs = np.flatnonzero(((state != self.state) | turned) & ~self._spared)
        if not len(differs):
            return True
        often = differs[self._changed[differs] >= MOST_CHANGES]
        slides = (self.state[often] != OPEN) & (state[often] != OPEN)
        along[often] = np.where(slides[:, None], np.where(along[often] == 0.0, self.along[often], along[often]), 0.0)
        state[often], self._spared[often] = np.where(slides, SLIP, OPEN), True
        self.state[differs], self.along[differs] = state[differs], along[differs]
        self._changed[differs] += 1
        self._rounds += 1
        if self._rounds > MOST_ROUNDS:
            raise NotConverged("what sticks, slides or parts was not found", node=np.round(self._places[differs[0]]))
        return False

    def _wanted(self, trial, past):
        """States and directions that a trial asks for."""
        state, along = self.state.copy(), self.along.copy()
        normal, tangent = self._parts(self._felt(trial.full))
        little, short = FORCE * trial.scale, WAY * np.abs(trial.u).max(initial=0.0)
        way = self._traces @ (trial.u if past is None else trial.u - past)
        approach, slid = self._parts(way)
        sliding = self._slid(trial, past)
        slid = np.where(sliding.any(axis=1)[:, None], sliding, slid)
        rubs, parts = self.mu > 0.0, self.code == SEPARATE
        pull, far = np.linalg.norm(tangent, axis=1), np.linalg.norm(slid, axis=1)

        closed = self.state != OPEN
        leaves = closed & parts & (normal < -little)
        state[leaves] = OPEN
        meets = ~closed & self.arrived & (approach < -short)
        state[meets] = SLIP

        gives = closed & ~leaves & rubs & (self.state == STICK) & (
            pull > self.mu * np.maximum(normal, 0.0) + little)
        state[gives] = SLIP
        pressed = gives & (normal > 0.0)
        along[pressed] = tangent[pressed] / pull[pressed, None]

        slides = closed & ~leaves & rubs & (self.state == SLIP)
        moves = slides & (far > short)
        ahead = np.einsum("ka,ka->k", slid, self.along)
        idle = slides & (normal < -little)
        stops = slides & ~idle & ((moves & (ahead > 0.0)) | (~moves & ~self.along.any(axis=1) & (normal > little)))
        state[stops] = STICK
        turns = moves & ~idle & ~stops
        along[turns] = -slid[turns] / far[turns, None]
        along[idle | (state != SLIP)] = 0.0
        return state, along
