"""Grains, their contacts, and the cell that holds them."""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.micro.grains.kernels import ACTION, MEMORY, Contacts, Grains, step_kernel
from snowmpm.micro.grains.pairs import Pairs, nearest_image

STEP = 0.1
"""Step over sqrt(m / k) of the lightest grain."""

MARGIN = 0.2
"""Gap below which a pair is watched, over the mean radius."""


LOOK = 8
"""Steps between two looks for pairs that come near."""

MANY = 4000
"""Pairs from which on all threads compute a step; fewer are done by one before the others have woken."""


class Assembly:
    """Spheres of one density with one `ContactLaw`.

    positions (n, 3) [m], radii (n,) [m]; box (3,) [m]: sides of a periodic cell, None or 0 along axes without; damping
    [1/s]: viscous, of all velocities; gravity (3,) [m/s2]; fixed (n,): grains that keep their velocity. rates (3,)
    [1/s]: strain rates of the cell; shear (2,) [1/s]: rates of shear of x and y along z; both to be set at will.
    slide (2,) [m]: shift of the image above; deformation F (3, 3): of the cell since its making.
    """

    def __init__(self, positions, radii, law, density=917.0, box=None, damping=0.0, gravity=(0.0, 0.0, 0.0),
                 fixed=None):
        runtime.start()
        radii = np.asarray(radii, float)
        self.law, self.radii, self.box = law, radii, np.zeros(3) if box is None else np.array(box, float)
        self.rates, self.time, self.steps, self.rebuilt = np.zeros(3), 0.0, 0, 0
        self.shear, self.slide, self.deformation = np.zeros(2), np.zeros(2), np.eye(3)
        self.mass = density * 4.0 / 3.0 * np.pi * radii**3
        inertia = 0.4 * self.mass * radii**2
        self._state = np.zeros((len(radii), 9))
        self._state[:, :3] = positions
        self._sizes = np.column_stack([radii, self.mass, inertia])
        self._fixed = np.zeros(len(radii), np.int32) if fixed is None else np.asarray(fixed, np.int32)
        self._pull, self.damping = np.asarray(gravity, float), damping
        stiffest = max(law.stiffness, law.tangential * (3.5 if law.rolling else 2.5))
        self.dt = STEP * float(np.sqrt(self.mass.min() / stiffest))
        self._margin = MARGIN * float(radii.mean())
        self._pairs, self._memory = None, np.zeros((0, MEMORY))
        self._find()

    # ---- state ------------------------------------------------------------------------------------------------

    @property
    def positions(self):
        """(n, 3) [m]; along periodic axes not brought back into the cell."""
        return self._state[:, :3]

    @property
    def velocities(self):
        """(n, 3) [m/s], beside the straining of the cell."""
        return self._state[:, 3:6]

    @property
    def spins(self):
        """(n, 3) [1/s]."""
        return self._state[:, 6:9]

    @property
    def volume(self):
        """Of the periodic cell [m3]."""
        return float(self.box.prod())

    @property
    def void_ratio(self):
        """Pores over grains in the periodic cell."""
        grains = float((4.0 / 3.0 * np.pi * self.radii**3).sum())
        return self.volume / grains - 1.0

    # ---- steps ------------------------------------------------------------------------------------------------

    def step(self, count=1):
        """Advance by so many steps of `dt`."""
        kept = max(0.0, 1.0 - self.damping * self.dt)
        law = np.array([*self.law.numbers(), self.dt, *self._pull, kept])
        cell = np.array([self.box, self.rates, [*self.slide, 0.0], [*self.shear, 0.0]])
        grains = Grains(self._state, self._sizes, self._fixed)
        turn = np.eye(3) + self.dt * self.velocity_gradient
        last = self.steps + count
        with runtime.precision("f64"):
            while self.steps < last:
                if self.steps % LOOK == 0 and self._far():
                    self._find()
                serial = self._pairs.count < MANY
                some = min(last - self.steps, LOOK - self.steps % LOOK) if serial else 1
                contacts = Contacts(self._rows, self._memory, self._action, self._pairs.starts, self._pairs.members)
                step_kernel(serial)(grains, contacts, cell, law, self._pairs.count, some)
                self.box, self.slide = cell[0].copy(), cell[2, :2].copy()
                self.deformation = np.linalg.matrix_power(turn, some) @ self.deformation
                self.time += some * self.dt
                self.steps += some

    @property
    def velocity_gradient(self):
        """L of the cell (3, 3) [1/s]."""
        L = np.diag(self.rates)
        L[:2, 2] = self.shear
        return L

    def _far(self):
        """Whether a pair that is not watched may touch before the next look."""
        strained = self.deformation @ np.linalg.inv(self._found_deformation)
        ahead = LOOK * self.dt
        way = self._state[:, :3] - self._found_at @ strained.T
        moved = np.sqrt((way**2).sum(axis=1).max(initial=0.0))
        moved += ahead * np.sqrt((self.velocities**2).sum(axis=1).max(initial=0.0))
        squeezed = np.linalg.norm(strained - np.eye(3)) + ahead * np.linalg.norm(self.velocity_gradient)
        return 2.0 * moved + 2.0 * self.radii.max() * squeezed > self._margin

    def _find(self):
        """Look for the pairs anew; contacts keep what they remember."""
        before = self._pairs
        periodic = self.box if (self.box > 0.0).any() else None
        if periodic is not None and (periodic == 0.0).any():
            raise ValueError("box: must be periodic along all axes or none")
        self._pairs = Pairs.near(self._state[:, :3], self.radii, self._margin, periodic, self.slide)
        self._memory = self._pairs.carried(before, self._memory)
        room = max(1, self._pairs.count)
        self._memory = np.vstack([self._memory, np.zeros((room - len(self._memory), MEMORY))])
        self._action = np.zeros((room, ACTION))
        self._rows = np.zeros((room, 2), np.int32)
        self._rows[: self._pairs.count] = np.column_stack([self._pairs.first, self._pairs.second])
        self._found_at, self._found_deformation = self._state[:, :3].copy(), self.deformation.copy()
        self.rebuilt += 1

    def bond(self, relaxed=False):
        """Bond all grains that touch; -> number of bonds made. relaxed: each bond, old ones too, and each contact is
        free of force as it is now, as after a long time of sintering."""
        gap = self._gaps()[1]
        memory = self._memory[: self._pairs.count]
        new = (gap < 0.0) & (memory[:, 6] == 0.0)
        memory[new, 3:] = [0.0, 0.0, 0.0, 1.0, 0.0]
        if relaxed:
            held = memory[:, 6] > 0.0
            memory[held, :6], memory[held, 7] = 0.0, -gap[held]
        return int(new.sum())

    @property
    def bonds(self):
        """Number of bonds that hold."""
        return int((self._memory[: self._pairs.count, 6] > 0.0).sum())

    # ---- what it is like --------------------------------------------------------------------------------------

    def _gaps(self):
        """Vectors (m, 3) from the second to the first grain of each pair, and gaps (m,) [m]."""
        i, j = self._pairs.first, self._pairs.second
        way = nearest_image(self._state[i, :3] - self._state[j, :3], self.box, self.slide)
        return way, np.linalg.norm(way, axis=1) - self.radii[i] - self.radii[j]

    def forces(self):
        """(first (k,), second (k,), branch (k, 3) [m], force on the first (k, 3) [N]) of the contacts, as of the last
        step."""
        way, _ = self._gaps()
        force = self._action[: self._pairs.count, :3]
        acts = (force != 0.0).any(axis=1)
        return self._pairs.first[acts], self._pairs.second[acts], way[acts], force[acts]

    def stress(self):
        """Mean stress in the periodic cell (3, 3) [Pa], tension positive: that of Love and Weber, -sum f x l / V, and
        that of the motion, -sum m v x v / V."""
        _, _, branch, force = self.forces()
        v = self._state[:, 3:6]
        return -(force.T @ branch + (self.mass[:, None] * v).T @ v) / self.volume

    def coordination(self):
        """Mean number of contacts of a grain."""
        return 2.0 * len(self.forces()[0]) / len(self.radii)

    def fabric(self):
        """Mean of n x n over the contacts (3, 3); its trace is 1."""
        branch = self.forces()[2]
        n = branch / np.linalg.norm(branch, axis=1, keepdims=True)
        return n.T @ n / max(1, len(n))

    def kinetic_energy(self):
        """Of all grains, beside the straining of the cell [J]."""
        return 0.5 * float(self.mass @ (self.velocities**2).sum(axis=1)
                           + self._sizes[:, 2] @ (self.spins**2).sum(axis=1))


def loose_cell(count, radius, spread=0.2, solid=0.45, seed=1):
    """Positions (n, 3), radii (n,) and box (3,) of grains that hardly overlap: a jittered lattice in random order.

    radius [m]: mean; spread: half width of the uniform distribution of radii, relative; solid: share of the volume.
    """
    rng = np.random.default_rng(seed)
    radii = radius * rng.uniform(1.0 - spread, 1.0 + spread, count)
    side = float((4.0 / 3.0 * np.pi * (radii**3).sum() / solid) ** (1.0 / 3.0))
    cells = int(np.ceil(count ** (1.0 / 3.0)))
    places = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    places = places[rng.permutation(len(places))[:count]]
    return (places + 0.5 + rng.uniform(-0.1, 0.1, (count, 3))) * side / cells, radii, np.full(3, side)
