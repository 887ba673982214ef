"""SPH of water that seeps through a rigid skeleton: two layers of particles, in a profile (x, z) over a level floor.

Grains at rest, each with the volume V_s of its solid, give the share of the water around it, n = 1 - sum V_s W, and 1
where there are none. Particles of water keep their volume V; V / n is the part of space that they fill. With the
discharge U = n w per area,

    n rho dw/dt = -n grad p + n rho g - C(n, |w|) w,    div U = 0

C is that of a law of `water.drag` at the |w| of the start, times the speed of the end of the step, so that drag sets no
step. Projection, in two layers (Bui & Nguyen 2017, Int. J. Solids Struct. 125, 244-264; Cummins & Rudman 1999,
doi:10.1006/jcph.1999.6246, for the pressure):

    U* = n b (w + dt g),  b = 1 / (1 + dt C / (n rho)),    div (k grad p) = div U* - (f - 1) / tau,  k = n b dt / rho

f = sum (V / n) W is how full space is: what deviates goes within tau. Particles at the free surface, where the
divergence of position falls short, have p = 0. The equations are symmetric and positive: SciPy's conjugate gradients.
The floor z = 0 and the wall are mirrors; grad p is corrected to first order; particles are shifted towards where space
is emptier by a part of their spacing, away from the surface.
"""

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import cg
from scipy.spatial import cKDTree

SURFACE = 1.5
"""Divergence of position, 2 inside, below which a particle is at the surface."""

SETTLING = 10.0
"""tau over dt."""

SHIFT = 0.02
"""Shift of a step over the gradient of f and the square of the spacing."""

LEAST_DRAIN = 0.05
"""Least share of the water."""


def wendland(r, reach):
    """W(r) [1/m2] and -W'(r) / r [1/m4] of the kernel C2 in the plane, which ends at `reach` [m]."""
    q = np.minimum(r / reach, 1.0)
    peak = 7.0 / (np.pi * reach**2)
    return peak * (1.0 - q) ** 4 * (1.0 + 4.0 * q), 20.0 * peak / reach**2 * (1.0 - q) ** 3


class Seepage:
    """places, speeds (n, 2) [m], [m/s] and volume [m2] of each particle of water; grains (k, 2) [m], each of `solid`
    [m2]; drag: law of `water.drag`; spacing: of water in the pores [m]; wall: x of a wall to the left [m]; density
    [kg/m3]. left: volume that went beyond `end`, x [m]; passes: of the last solution."""

    def __init__(self, places, volume, grains, solid, drag, *, spacing, wall, end, density=1000.0, gravity=9.81):
        self.x, self.w, self.volume = np.array(places, float), np.zeros((len(places), 2)), volume
        self.drag, self.reach, self.spacing = drag, 2.6 * spacing, spacing
        self.wall, self.end, self.density, self.gravity = wall, end, density, gravity
        mirrored = grains * np.array([1.0, -1.0])
        self._grains, self._solid = cKDTree(np.vstack([grains, mirrored[grains[:, 1] < self.reach]])), solid
        self.p = np.zeros(len(places))
        self.time, self.left, self.added, self.passes = 0.0, 0.0, 0.0, 0

    def shares(self, x):
        """n (k,) at places (k, 2)."""
        tree = cKDTree(x)
        near = tree.sparse_distance_matrix(self._grains, self.reach, output_type="coo_matrix")
        return np.maximum(1.0 - self._solid * np.bincount(near.row, wendland(near.data, self.reach)[0], len(x)),
                          LEAST_DRAIN)

    def _pairs(self):
        """Of all pairs of a particle and another one or a mirror image: numbers i and j, the difference of places, the
        signs of the image's components, and how much deeper than particle j the image lies [m]."""
        x = self.x
        low, beside = np.flatnonzero(x[:, 1] < self.reach), np.flatnonzero(x[:, 0] - self.wall < self.reach)
        both = np.intersect1d(low, beside)
        every = np.arange(len(x))
        owner = np.concatenate([every, low, beside, both])
        sign = np.repeat([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]],
                         [len(every), len(low), len(beside), len(both)], axis=0)
        origin = np.array([self.wall, 0.0])
        places = origin + sign * (x[owner] - origin)
        near = cKDTree(x).sparse_distance_matrix(cKDTree(places), self.reach, output_type="coo_matrix")
        i, j = near.row, near.col
        keep = i != j
        i, j = i[keep], j[keep]
        return i, owner[j], x[i] - places[j], sign[j], x[owner[j], 1] - places[j, 1]

    def step(self, dt):
        """Advance by dt [s]."""
        x, n_all = self.x, len(self.x)
        share = self.shares(x)
        room = self.volume / share
        i, j, apart, sign, deeper = self._pairs()
        r = np.linalg.norm(apart, axis=1)
        value, slope = wendland(r, self.reach)
        full = room * wendland(0.0, self.reach)[0] + np.bincount(i, room[j] * value, n_all)
        gradient = -slope[:, None] * apart  # of W at i
        divergence = -np.bincount(i, room[j] * (apart * gradient).sum(axis=1), n_all)
        surface = divergence < SURFACE

        speed = np.linalg.norm(self.w, axis=1)
        held = 1.0 / (1.0 + dt * np.where(share < 0.999, self.drag.coefficient(share, speed), 0.0)
                      / (share * self.density))
        after = held[:, None] * (self.w + dt * np.array([0.0, -self.gravity]))
        flow, ease = share[:, None] * after, share * held * dt / self.density
        spread = np.bincount(i, room[j] * ((sign * flow[j] - flow[i]) * gradient).sum(axis=1), n_all)
        source = -room * (spread - (full - 1.0) / (SETTLING * dt))
        link = room[i] * room[j] * (ease[i] + ease[j]) * slope
        source += np.bincount(i, link * self.density * self.gravity * deeper, n_all)
        matrix = diags(np.bincount(i, link, n_all)) - csr_matrix((link, (i, j)), (n_all, n_all))
        inner = np.flatnonzero(~surface)
        pressure = np.zeros(n_all)
        if len(inner):
            block = matrix.tocsr()[inner][:, inner]
            scale = diags(1.0 / block.diagonal())
            self.passes = 0
            pressure[inner], failed = cg(block, source[inner], self.p[inner], rtol=1e-6, maxiter=500, M=scale,
                                         callback=self._count)
            if failed:
                raise ArithmeticError(f"the pressure is not found in {self.passes} passes at t = {self.time:.6g} s")
        rise = pressure[j] + self.density * self.gravity * deeper - pressure[i]
        slopes = self._corrected(i, room[j, None] * rise[:, None] * gradient, room[j], apart, gradient)
        emptier = np.stack([np.bincount(i, room[j] * gradient[:, a], n_all) for a in (0, 1)], axis=1)
        self.w = after - (ease / share)[:, None] * slopes
        shift = np.where(surface[:, None], 0.0, -SHIFT * self.spacing**2 * emptier)
        self.x = x + dt * self.w + shift
        self.x[:, 1] = np.abs(self.x[:, 1])
        self.x[:, 0] = self.wall + np.abs(self.x[:, 0] - self.wall)
        self.p, self.share, self.surface, self.full = pressure, share, surface, full
        self.time += dt
        gone = self.x[:, 0] > self.end
        if gone.any():
            self.left += self.volume * gone.sum()
            self.x, self.w, self.p = self.x[~gone], self.w[~gone], self.p[~gone]

    def _count(self, _):
        self.passes += 1

    def _corrected(self, i, parts, room, apart, gradient):
        """Sums of `parts` over the pairs of each particle (n, 2), so corrected that linear fields have theirs."""
        n = len(self.x)
        sums = np.stack([np.bincount(i, parts[:, a], n) for a in (0, 1)], axis=1)
        moments = np.array([[np.bincount(i, -room * apart[:, a] * gradient[:, b], n) for b in (0, 1)] for a in (0, 1)])
        moments = moments.transpose(2, 1, 0)
        fair = np.abs(np.linalg.det(moments)) > 0.1
        moments[~fair] = np.eye(2)
        return np.linalg.solve(moments, sums[:, :, None])[:, :, 0]

    def add(self, place):
        """One more particle of water, at rest."""
        self.x, self.w = np.vstack([self.x, place]), np.vstack([self.w, np.zeros(2)])
        self.p = np.append(self.p, 0.0)
        self.added += self.volume
