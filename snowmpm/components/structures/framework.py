"""Members that meet in joints, rigid or pinned: elastic beams for any rotation, whose ends yield and break.

Corotational beam elements (K. M. Hsiao et al. (1987) and M. A. Crisfield (1990), doi:10.1016/0045-7825(90)90106-V; the
axes of the element as J.-M. Battini and C. Pacoste (2002), doi:10.1016/S0045-7825(01)00352-8, eqs. 9 to 14): with r_1
from one end of an element to the other, r_3 = r_1 x q of the mean q of the second axes of both ends, and theta_i the
rotation vector from the element's axes to those of end i,

    U = E A (|e| - l)^2 / 2 l + G J (theta_b1 - theta_a1)^2 / 2 l + 2 E I / l sum_k (a_k^2 + a_k b_k + b_k^2),
    a_k = theta_ak - plastic_ak,  k = 2, 3

Forces and moments are the derivatives of U, so that they balance, and no rigid movement does work on them. Bending of
an element is exact under loads at its ends; no shear. Moments of places and turns by

    m v' = f,    L' = moment,    omega = R J^-1 R^T L,    R' = omega x R

in substeps of leap-frog, which keep momentum and angular momentum, and energy but for a ripple. An end yields where its
bending moment exceeds the yield moment, along that, and breaks for good where |M| / M_b + |N| / N_b reaches 1: from
then on it passes on no moment, but holds together. The substep in which that happens is cut short: stresses pass the
strength by a thousandth at most, where in whole ones they passed it by a fifth and more. In 2-D the framework lies in
the plane y = 0.
"""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.components.structures import framework_motion as at
from snowmpm.components.structures.framework_mesh import FrameworkMesh
from snowmpm.components.structures.framework_modes import Modes, element_stiffness
from snowmpm.components.structures.rod import SHARE
from snowmpm.components.structures.rod_motion import NEVER


class Framework:
    """State of a framework.

    x, v (p, 3): places, joints first; ends (n, 2): places of each element; along (n, 3), lengths (n,): of the elements
    at the start; free: numbers of the places that are no feet; held (3,) [N s]: impulse that feet, damping and ground
    gave. met (p, 3) [m/s]: velocities with which the snow meets the places while it is sought which they will have;
    None: theirs.
    """

    met = None

    def __init__(self, joints, feet, members, *, poisson_ratio=0.3, damping=0.0, plane=False):
        """joints: name -> (3,) [m]; feet: name of a joint on the ground -> "fixed" or "pinned"; members:
        `framework_mesh.Member`s; poisson_ratio: G = E / 2 (1 + nu) for torsion; damping: share of the critical one in
        the first mode; plane: whether nothing leaves y = const."""
        self.mesh = mesh = FrameworkMesh.of(joints, feet, members, plane)
        self.n, self.feet, self.plane = len(mesh.links), dict(feet), plane
        self.lengths, self.along, self.ends = mesh.lengths, mesh.triads[:, 0], mesh.links[:, :2]
        self.free = np.flatnonzero(~mesh.held)
        sections = [mesh.section(e) for e in range(self.n)]
        axial, bend, line_mass, polar = (np.array([section[name] for section in sections])
                                         for name in ("axial", "bending", "line_mass", "polar_mass"))
        twist = bend / (1.0 + poisson_ratio)  # G J with J = 2 I
        self.modes = Modes(mesh, [element_stiffness(*each) for each in
                                  zip(mesh.triads, mesh.lengths, axial, twist, bend, strict=True)], plane)
        self._drag = 2.0 * damping * self.modes.first if damping else 0.0
        self._places, self._turns = np.zeros((len(mesh.places), 14)), np.zeros((len(mesh.clamped), 20))
        self._elements, self._links, self._numbers = np.zeros((self.n, 32)), mesh.links.copy(), np.zeros(8)
        self._places[:, at.MASS], self._places[:, at.HELD] = mesh.masses, mesh.held
        limits = [[min(section.yield_moment, NEVER), section.hardening, 1.0 / section.breaking_moment,
                   1.0 / section.breaking_force] for section in sections]
        self._elements[:, : at.PLASTIC] = np.column_stack([mesh.triads.reshape(-1, 9), mesh.lengths, axial, twist, bend,
                                                           limits])
        # Modes of an element by itself, whose fastest one bounds those of all that are joined: opposite ends stretch,
        # twist; both ends turn the same way, with J = m l^3 / 24, while they part across
        self.wave_speed = float(np.sqrt(axial / line_mass).max())
        fastest = np.sqrt(np.maximum.reduce([4.0 * axial / line_mass / mesh.lengths**2,
                                             4.0 * twist / polar / mesh.lengths**2,
                                             192.0 * bend / line_mass / mesh.lengths**4]).max())
        self.substep = SHARE * 2.0 / fastest
        self._ground = np.array([0.0, 0.0, 0.0, -1.0])
        self.begin()

    def begin(self):
        """As built, at rest."""
        self._places[:, : at.MASS], self._turns[:], self._numbers[:] = 0.0, 0.0, 0.0
        self._elements[:, at.PLASTIC :] = 0.0
        self._links[:] = self.mesh.links
        self.x[:], self._turns[:, at.Q] = self.mesh.places, 1.0
        self._set_inertias(range(len(self._turns)), self.mesh.inertias(self._links))
        self._elements[:, at.WHOLE :] = self._passing()
        self.met = None

    def stand_on(self, normal, level):
        """Let no place but the feet sink below a plane, without friction or rebound: normal (3,), level along it [m];
        no higher than the framework begins."""
        normal = np.asarray(normal, float)
        self._ground[:] = *normal, min(level, float((self.x[self.free] @ normal).min(initial=np.inf)))

    x = property(lambda self: self._places[:, at.X : at.V])
    v = property(lambda self: self._places[:, at.V : at.F])
    masses = property(lambda self: self._places[:, at.MASS])
    held = property(lambda self: self._numbers[at.GIVEN : at.WORK])
    plastic = property(lambda self: self._elements[:, at.PLASTIC : at.NORMAL].reshape(-1, 2, 2))
    plastic_work = property(lambda self: float(self._numbers[at.WORK]))
    moments = property(lambda self: self._elements[:, at.BENT : at.STRESS].reshape(-1, 2, 2))
    pulls = property(lambda self: self._elements[:, at.NORMAL])
    torsions = property(lambda self: self._elements[:, at.TORSION])
    largest_moment = property(lambda self: float(self._elements[:, at.LARGEST].max()))
    broken = property(lambda self: self._links[:, 2:] != self.mesh.links[:, 2:])

    def advance(self, dt, forces):
        """Move for dt [s] under forces (p, 3) [N] on the places."""
        self._places[:, at.F : at.INNER] = forces
        while True:
            before, count = self.state(), int(np.ceil(max(dt, 0.0) / self.substep))
            h = dt / max(count, 1)
            if not self._move(h, count):
                return
            dt -= self._approach(before, h)
            self._break()

    def _move(self, h, count):
        """`count` substeps of h [s], or as many as it takes until an end has to break; -> whether one has to."""
        self._numbers[[at.SUBSTEP, at.DRAG]] = h, self._drag
        runtime.start()
        with runtime.precision("f64"):
            at.framework_kernel()(self._places, self._turns, self._elements, self._links, self._numbers, self._ground,
                                  count)
        return self._numbers[at.WORST] >= 1.0

    def _approach(self, before, h):
        """Go back to where the strength is reached within `BEYOND`, by a last substep of h [s] that is shortened by
        bisection: stresses are continuous functions of its length. before: `state` at the start; -> time since [s]."""
        done = int(self._numbers[at.DONE])
        if done == 0 or self._numbers[at.WORST] <= 1.0 + BEYOND:
            return done * h
        self.restore(before)
        self._move(h, done - 1)
        last, low, high, share = self.state(), 0.0, 1.0, 0.5
        while not 1.0 <= self._worst_after(last, share * h) <= 1.0 + BEYOND and low < share < high:
            low, high = (low, share) if self._numbers[at.WORST] > 1.0 else (share, high)
            share = 0.5 * (low + high)
        return (done - 1 + share) * h

    def _worst_after(self, last, h):
        """Largest stress over strength after a substep of h [s] from a `state`."""
        self.restore(last)
        self._move(h, 1)
        return self._numbers[at.WORST]

    def _passing(self):
        """Whether each end (n, 2) passes on a moment: to others on its turn, or to a fixed foot. Where none does, what
        is left is the inertia of a single end, which no real one has: it counts neither as stress nor as moment."""
        turns, mesh = self._links[:, 2:], self.mesh
        own = mesh.spare + np.arange(2 * self.n).reshape(-1, 2)
        shared = np.bincount(turns.ravel(), minlength=len(mesh.clamped)) > 1
        return (turns != own) & (shared | mesh.clamped)[turns]

    def _break(self):
        """Give the most stressed end a turn of its own."""
        stress, links, mesh = self._elements[:, at.STRESS : at.LARGEST], self._links, self.mesh
        e, end = divmod(int(stress.argmax()), 2)
        turn, own = int(links[e, 2 + end]), mesh.spare + 2 * e + end
        omega, links[e, 2 + end] = self._omega(turn), own
        self._turns[own, at.Q : at.SPIN] = self._turns[turn, at.Q : at.SPIN]
        inertias = mesh.inertias(links)
        self._set_inertias([turn, own], inertias[[turn, own]])
        for each in (turn, own):
            R = self._rotation(each)
            self._turns[each, at.SPIN : at.MOMENT] = R @ inertias[each] @ R.T @ omega
        self._elements[:, at.WHOLE :] = self._passing()

    def _set_inertias(self, turns, inertias):
        for i, J in zip(turns, inertias, strict=True):
            free = J.any() and not self.mesh.clamped[i]
            self._turns[i, at.FREE] = free
            self._turns[i, at.INVERSE : at.FREE] = np.linalg.inv(J).ravel() if free else 0.0

    def _rotation(self, i):
        w, x, y, z = self._turns[i, at.Q : at.SPIN]
        return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])

    def _omega(self, i):
        """Angular velocity (3,) [rad/s] of a turn."""
        R = self._rotation(i)
        return R @ self._turns[i, at.INVERSE : at.FREE].reshape(3, 3) @ R.T @ self._turns[i, at.SPIN : at.MOMENT]

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def energy(self):
        """Kinetic and elastic energy [J]."""
        spins = self._turns[:, at.SPIN : at.MOMENT]
        turning = sum(float(spins[i] @ self._omega(i)) for i in np.flatnonzero(self._turns[:, at.FREE]))
        axial, twist, bend = self._elements[:, [at.AXIAL, at.TWIST, at.BEND]].T
        a, b = self.moments[:, 0], self.moments[:, 1]
        elastic = self.lengths * (self.pulls**2 / axial + self.torsions**2 / twist
                                  + (a**2 - a * b + b**2).sum(axis=1) / (3.0 * bend))
        return 0.5 * (float(self.masses @ (self.v**2).sum(axis=1)) + turning + float(elastic.sum()))

    @property
    def angular_momentum(self):
        """About the origin (3,) [N m s]."""
        return self.masses @ np.cross(self.x, self.v) + self._turns[:, at.SPIN : at.MOMENT].sum(axis=0)

    def numbers(self, dim):
        """Numbers of the history, by what follows its name: (value, unit).

        Displacements of joints; with which force and moment the framework acts on its feet; of members axial force, the
        largest in size along them (tension > 0), bending moments at their first and last end (2-D: with which they act
        on the joint, positive from +x to +z; 3-D: size), torsion, and the largest moment along them so far; ends of
        elements that yielded and broke."""
        axes, where = ("xz", [0, 2]) if dim == 2 else ("xyz", [0, 1, 2])
        unit, force = ("N m/m", "N/m") if dim == 2 else ("N m", "N")
        mesh, found = self.mesh, {}
        for name, i in mesh.joints.items():
            if name in self.feet:
                acts = self._places[i, at.F : at.INNER] + self._places[i, at.INNER : at.MASS]
                found.update({f"{name}_force_{axis}": (acts[a], force) for axis, a in zip(axes, where, strict=True)})
                if self.feet[name] == "fixed":
                    found.update(_vector(f"{name}_moment", self._turns[i, at.MOMENT : at.INVERSE], dim, unit))
            else:
                moved = self.x[i] - mesh.places[i]
                found.update({f"{name}_{axis}": (moved[a], "m") for axis, a in zip(axes, where, strict=True)})
        for k, member in enumerate(mesh.members):
            own = mesh.elements(k)
            pulls, ends = self.pulls[own], (self.moments[own[0], 0], self.moments[own[-1], 1])
            found[f"{member.name}_axial"] = pulls[np.abs(pulls).argmax()], force
            for which, moment in zip(("first", "last"), ends, strict=True):
                found[f"{member.name}_{which}_moment"] = moment[1] if dim == 2 else np.linalg.norm(moment), unit
            if dim == 3:
                found[f"{member.name}_torsion"] = self.torsions[own].mean(), unit
            found[f"{member.name}_largest_moment"] = self._elements[own, at.LARGEST].max(), unit
        found["largest_moment"] = self.largest_moment, unit
        found["yielded"] = np.count_nonzero(self.plastic.any(axis=2)), "1"
        found["broken"] = np.count_nonzero(self.broken), "1"
        return {name: (float(value), unit) for name, (value, unit) in found.items()}

    def state(self):
        """All that a continuation needs, by name."""
        return {name: vars(self)[f"_{name}"].copy() for name in STATE}

    def restore(self, state):
        """Take over what `state()` gave."""
        for name in STATE:
            vars(self)[f"_{name}"][:] = state[name]


BEYOND = 1e-3
"""Share of the strength by which an end may be stressed beyond it when it breaks."""

STATE = ("places", "turns", "elements", "links", "numbers")
"""Tables of a `Framework` that change."""


def _vector(name, value, dim, unit):
    """Moments about the axes of space; in 2-D one, positive from +x to +z."""
    if dim == 2:
        return {name: (-value[1], unit)}
    return {f"{name}_{axis}": (value[a], unit) for a, axis in enumerate("xyz")}
