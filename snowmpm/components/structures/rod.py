"""A slender rod, clamped at its foot: straight segments, finite rotations, hinges that yield and break.

A chain of n segments of length l between nodes with lumped masses. With e_s the segments, d_s their directions and
phi_k the rotation vector that carries d_k-1 to d_k (d_-1: the direction of the clamp),

    N_s = E A (|e_s| / l - 1),    M_k = K_k (phi_k - phi^p_k),    K_0 = 2 E I / l,  K_k = E I / l

    forces on the nodes of s:  -+ N_s d_s,  and the couple +-(tau x d_s) / |e_s| of  tau_s = M_s+1 - M_s

This is Hencky's bar chain (H. Hencky (1920), doi:10.1007/BF02083226) with elastic bars; it converges with l^2 to the
elastica, for any rotation (without twist: M. Bergou et al. (2008), doi:10.1145/1360612.1360662). No shear, no torsion.
A hinge yields where |M| exceeds the yield moment, by the return of M to it along itself, and breaks for good where |M|
reaches the breaking moment: then it carries no moment any more, but holds together.

Velocity Verlet in substeps that its fastest wave allows. In 2-D the rod lies in the plane y = 0 of space.
"""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.components.structures import rod_motion as at

SHARE = 0.5
"""Substep over the largest stable one."""


class Rod:
    """State of a rod.

    x, v (n + 1, 3): nodes; plastic (n, 3): phi^p in space; broken (n,); moments (n, 3) [N m] of the hinges, from the
    foot; held (3,) [N s]: impulse that clamp, damping and ground gave; largest_moment [N m] at the foot so far.
    ends (n, 2): nodes of each segment; along (n, 3), lengths (n,) [m]: of the segments at the start; free: numbers of
    the nodes that are not clamped. met (n + 1, 3) [m/s]: velocities with which the snow meets the nodes while it is
    sought which they will have; None: theirs.
    """

    met = None

    def __init__(self, foot, top, segments, section, damping=0.0):
        """foot, top (3,) [m]: from the clamp to the free end; section: `section.Section`; damping: share of the
        critical one in the first mode of the straight rod."""
        foot, top = np.asarray(foot, float), np.asarray(top, float)
        self.section, self.n = section, segments
        self.length = float(np.linalg.norm(top - foot)) / segments
        self.clamp = (top - foot) / (segments * self.length)
        self.ends = np.column_stack([np.arange(segments), np.arange(1, segments + 1)])
        self.along, self.lengths = np.tile(self.clamp, (segments, 1)), np.full(segments, self.length)
        self.free = np.arange(1, segments + 1)
        self.wave_speed = float(np.sqrt(section.axial / section.line_mass))
        self._nodes, self._hinges, self._numbers = np.zeros((segments + 1, 13)), np.zeros((segments, 15)), np.zeros(15)
        self.masses = self._nodes[:, at.MASS]
        self.masses[:] = section.line_mass * self.length
        self.masses[[0, -1]] *= 0.5
        whole = segments * self.length
        first = 1.8751040687**2 * np.sqrt(section.bending / section.line_mass) / whole**2
        self._drag = 2.0 * damping * first
        self._stiffness = self._hinges[:, at.STIFF]
        self._stiffness[:] = section.bending / self.length
        self._stiffness[0] *= 2.0
        limits = (section.yield_moment, section.hardening, section.breaking_moment)
        self._numbers[at.AXIAL : at.HELD] = [section.axial, self.length, *np.minimum(limits, at.NEVER), *self.clamp]
        # Of the axial mode with opposite ends, and of bending in a zigzag
        fastest = np.sqrt(2.0) * np.hypot(2.0 * np.sqrt(section.axial / section.line_mass) / self.length,
                                          4.0 * np.sqrt(section.bending / section.line_mass) / self.length**2)
        self.substep = SHARE * 2.0 / fastest
        self._foot = foot
        self._ground = np.array([0.0, 0.0, 0.0, -1.0])
        self.begin()

    def begin(self):
        """Straight, at rest."""
        whole = self.n * self.length * self.clamp
        self._nodes[:, : at.MASS] = 0.0
        self._hinges[:, : at.LENGTH], self._hinges[:, at.BROKEN], self._numbers[at.HELD :] = 0.0, 0.0, 0.0
        self.x[:] = self._foot + np.linspace(0.0, 1.0, self.n + 1)[:, None] * whole
        self._hinges[:, at.BELOW : at.OWN] = self.clamp
        self.met = None

    def stand_on(self, normal, level):
        """Let no node but the foot sink below a plane, without friction or rebound: normal (3,), level along it [m]; no
        higher than the rod begins."""
        normal = np.asarray(normal, float)
        self._ground[:] = *normal, min(level, float((self.x[1:] @ normal).min()))

    x = property(lambda self: self._nodes[:, at.X : at.V])
    v = property(lambda self: self._nodes[:, at.V : at.F])
    plastic = property(lambda self: self._hinges[:, at.PLASTIC : at.MOMENT])
    moments = property(lambda self: self._hinges[:, at.MOMENT : at.BELOW])
    broken = property(lambda self: self._hinges[:, at.BROKEN] > 0.0)
    held = property(lambda self: self._numbers[at.HELD : at.WORK])
    plastic_work = property(lambda self: float(self._numbers[at.WORK]))
    largest_moment = property(lambda self: float(self._numbers[at.LARGEST]))

    def advance(self, dt, forces):
        """Move for dt [s] under forces (n + 1, 3) [N] on the nodes."""
        count = max(1, int(np.ceil(dt / self.substep)))
        self._nodes[:, at.F : at.INNER] = forces
        self._numbers[[at.SUBSTEP, at.DRAG]] = dt / count, self._drag
        runtime.start()
        with runtime.precision("f64"):
            at.rod_kernel()(self._nodes, self._hinges, self._numbers, self._ground, count)

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def energy(self):
        """Kinetic and elastic energy [J]."""
        lengths = np.linalg.norm(np.diff(self.x, axis=0), axis=1)
        stretch = lengths / self.length - 1.0
        bent = (self.moments**2).sum(axis=1) / self._stiffness
        pulled = self.section.axial * self.length * (stretch @ stretch)
        return 0.5 * float(self.masses @ (self.v**2).sum(axis=1) + pulled + bent.sum())

    def numbers(self, dim):
        """Numbers of the history, by what follows its name: (value, unit). Displacement of the top, bending moment in
        the hinge at the foot, its largest size so far, hinges that yielded and broke."""
        axes, where = ("xz", [0, 2]) if dim == 2 else ("xyz", [0, 1, 2])
        top = (self.x[-1] - self.x[0] - self.n * self.length * self.clamp)[where]
        found = {f"top_{axis}": (value, "m") for axis, value in zip(axes, top, strict=True)}
        unit = "N m/m" if dim == 2 else "N m"
        if dim == 2:
            found["foot_moment"] = -self.moments[0][1], unit
        else:
            found.update({f"foot_moment_{axis}": (value, unit)
                          for axis, value in zip(axes, self.moments[0], strict=True)})
        found.update(largest_moment=(self.largest_moment, unit),
                     yielded=(np.count_nonzero(self.plastic.any(axis=1)), "1"),
                     broken=(np.count_nonzero(self.broken), "1"))
        return {name: (float(value), unit) for name, (value, unit) in found.items()}

    def state(self):
        """All that a continuation needs, by name."""
        return {"nodes": self._nodes.copy(), "hinges": self._hinges.copy(), "numbers": self._numbers.copy()}

    def restore(self, state):
        """Take over what `state()` gave."""
        for name in ("nodes", "hinges", "numbers"):
            vars(self)[f"_{name}"][:] = state[name]
