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

SHARE = 0.5
"""Substep over the largest stable one."""


class Rod:
    """State of a rod.

    x, v (n + 1, 3): nodes; plastic (n, 3): phi^p in space; broken (n,); moments (n, 3) [N m] of the hinges, from the
    foot; held (3,) [N s]: impulse that clamp and damping gave; largest_moment [N m] at the foot so far.
    """

    def __init__(self, foot, top, segments, section, damping=0.0):
        """foot, top (3,) [m]: from the clamp to the free end; section: `section.Section`; damping: share of the
        critical one in the first mode of the straight rod."""
        foot, top = np.asarray(foot, float), np.asarray(top, float)
        self.section, self.n = section, segments
        self.length = float(np.linalg.norm(top - foot)) / segments
        self.clamp = (top - foot) / (segments * self.length)
        self.x = foot + np.linspace(0.0, 1.0, segments + 1)[:, None] * (top - foot)
        self.masses = np.full(segments + 1, section.line_mass * self.length)
        self.masses[[0, -1]] *= 0.5
        whole = segments * self.length
        first = 1.8751040687**2 * np.sqrt(section.bending / section.line_mass) / whole**2
        self._drag = 2.0 * damping * first
        stiff = np.full(segments, section.bending / self.length)
        stiff[0] *= 2.0
        self._stiffness = stiff
        # Of the axial mode with opposite ends, and of bending in a zigzag
        fastest = np.sqrt(2.0) * np.hypot(2.0 * np.sqrt(section.axial / section.line_mass) / self.length,
                                          4.0 * np.sqrt(section.bending / section.line_mass) / self.length**2)
        self.substep = SHARE * 2.0 / fastest
        self.begin()

    def begin(self):
        """Straight, at rest."""
        whole = self.n * self.length * self.clamp
        self.x = self.x[0] + np.linspace(0.0, 1.0, self.n + 1)[:, None] * whole
        self.v, self.plastic = np.zeros_like(self.x), np.zeros((self.n, 3))
        self.broken, self.plastic_work = np.zeros(self.n, bool), 0.0
        self._directions = np.repeat(self.clamp[None], self.n + 1, axis=0)
        self.held, self.largest_moment = np.zeros(3), 0.0
        self.moments, self._inner = np.zeros((self.n, 3)), np.zeros_like(self.x)

    # ---- motion -----------------------------------------------------------------------------------------------

    def advance(self, dt, forces):
        """Move for dt [s] under forces (n + 1, 3) [N] on the nodes."""
        count = max(1, int(np.ceil(dt / self.substep)))
        h = dt / count
        self._deform()
        for _ in range(count):
            slowed = self._drag * self.masses[:, None] * self.v
            total = forces + self._inner - slowed
            # The clamp takes what acts on the lowest node; damping takes momentum too
            self.held -= h * (total[0] + slowed.sum(axis=0))
            self.v[1:] += h * total[1:] / self.masses[1:, None]
            self.x[1:] += h * self.v[1:]
            self._deform()
            self.largest_moment = max(self.largest_moment, float(np.linalg.norm(self.moments[0])))

    def _deform(self):
        """Moments of the hinges and forces on the nodes where they are now."""
        edges = np.diff(self.x, axis=0)
        lengths = np.linalg.norm(edges, axis=1)
        d = edges / lengths[:, None]
        before = np.concatenate([self.clamp[None], d])[:-1]
        self._carry(before)
        axis = _cross(before, d)
        sine, cosine = np.linalg.norm(axis, axis=1), np.einsum("ij,ij->i", before, d)
        angle = np.arctan2(sine, cosine)
        turn = axis * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1.0)[:, None]
        self._give_way(turn)
        tension = self.section.axial * (lengths / self.length - 1.0)
        inner = np.zeros_like(self.x)
        pull = tension[:, None] * d
        torque = -self.moments
        torque[:-1] += self.moments[1:]
        couple = _cross(torque, d) / lengths[:, None]
        inner[:-1] += pull - couple
        inner[1:] += couple - pull
        self._inner = inner

    def _carry(self, before):
        """Turn the plastic rotations with the segments below their hinges."""
        last = self._directions[:-1]
        if self.plastic.any():
            small = _cross(last, before)  # of a substep
            self.plastic = self.plastic + _cross(small, self.plastic)
        self._directions = np.concatenate([before, before[-1:]])

    def _give_way(self, turn):
        """Moments of the hinges at turns (n, 3); those that yield and break."""
        section, stiff = self.section, np.where(self.broken, 0.0, self._stiffness)[:, None]
        moments = stiff * (turn - self.plastic)
        size = np.linalg.norm(moments, axis=1)
        if np.isfinite(section.yield_moment):
            k = self._stiffness
            # Linear hardening with the plastic rotation so far
            limit = section.yield_moment + section.hardening * k * np.linalg.norm(self.plastic, axis=1)
            over = np.where(self.broken, 0.0, np.maximum(0.0, size - limit))
            if over.any():
                slip = over / (k * (1.0 + section.hardening))
                flow = moments / np.maximum(size, 1e-300)[:, None] * slip[:, None]
                self.plastic = self.plastic + flow
                moments = stiff * (turn - self.plastic)
                size = np.linalg.norm(moments, axis=1)
                self.plastic_work += float(size @ slip)
        snapped = (size >= section.breaking_moment) & ~self.broken
        if snapped.any():
            self.broken = self.broken | snapped
            moments[snapped] = 0.0
        self.moments = moments

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def energy(self):
        """Kinetic and elastic energy [J]."""
        lengths = np.linalg.norm(np.diff(self.x, axis=0), axis=1)
        stretch = lengths / self.length - 1.0
        bent = (self.moments**2).sum(axis=1) / self._stiffness
        pulled = self.section.axial * self.length * (stretch @ stretch)
        return 0.5 * float(self.masses @ (self.v**2).sum(axis=1) + pulled + bent.sum())

    def state(self):
        """All that a continuation needs, by name."""
        return {"x": self.x.copy(), "v": self.v.copy(), "plastic": self.plastic.copy(), "broken": self.broken.copy(),
                "directions": self._directions.copy(), "plastic_work": self.plastic_work, "held": self.held.copy(),
                "largest_moment": self.largest_moment}

    def restore(self, state):
        """Take over what `state()` gave."""
        self.x, self.v, self.plastic, self.held = (np.array(state[name], float)
                                                   for name in ("x", "v", "plastic", "held"))
        self.broken, self._directions = np.array(state["broken"], bool), np.array(state["directions"], float)
        self.plastic_work, self.largest_moment = float(state["plastic_work"]), float(state["largest_moment"])


def _cross(a, b):
    """a x b of rows (k, 3), several times as fast as `np.cross`."""
    return np.stack([a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1], a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
                     a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]], axis=1)
