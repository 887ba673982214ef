"""A slab on a weak layer with a cut, by finite elements: what beam and particles of S1 are compared with.

Plane strain, small strains, elements of nine nodes (displacements of second order) on a regular grid; the ground holds
the weak layer, all else is free. Gravity is put on the unloaded body. Nothing of the program is used.

    u = 0 on z = 0,   sum over elements of  integral B^T D B dA u = integral N^T rho g dA,   Pi = -f.u / 2
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

GAUSS = tuple(zip((-np.sqrt(0.6), 0.0, np.sqrt(0.6)), (5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0), strict=True))


@dataclass(frozen=True)
class Elastic:
    """E [Pa], nu, rho [kg/m3] and height [m] of a layer."""

    youngs_modulus: float
    poisson_ratio: float
    density: float
    height: float

    @property
    def stiffness(self):
        """Plane-strain matrix (3, 3) [Pa] of (eps_xx, eps_zz, gamma_xz)."""
        E, nu = self.youngs_modulus, self.poisson_ratio
        lam, mu = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))
        return np.array([[lam + 2.0 * mu, lam, 0.0], [lam, lam + 2.0 * mu, 0.0], [0.0, 0.0, mu]])


def _shapes(s):
    """Quadratic shape functions of a side and their slopes at s in -1 .. 1."""
    return np.array([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)]), np.array([s - 0.5, -2.0 * s, s + 0.5])


def _element(layer, h, gravity, lean):
    """Stiffness (18, 18) [Pa] and weight (18,) [N/m] of an element of width and height h [m], whose sides lean."""
    K, f = np.zeros((18, 18)), np.zeros(18)
    for s, ws in GAUSS:
        for t, wt in GAUSS:
            (Na, da), (Nb, db) = _shapes(s), _shapes(t)
            N, along, across = (np.outer(a, b).ravel() for a, b in ((Na, Nb), (da, Nb), (Na, db)))
            across = across - lean * along
            B = np.zeros((3, 18))
            B[0, 0::2] = B[2, 1::2] = along * 2.0 / h
            B[1, 1::2] = B[2, 0::2] = across * 2.0 / h
            weight = 0.25 * ws * wt * h * h
            K += weight * B.T @ layer.stiffness @ B
            f += weight * layer.density * np.outer(N, gravity).ravel()
    return K, f


def cut_slab(slab, weak, length, cut, slope_angle, h, g=9.81, lean=0.0):
    """Potential energy Pi [J/m] and displacement (2,) [m] of the middle of the slab's end at x = 0, over the cut.

    slab, weak: `Elastic`; the weak layer is gone for x < cut; slope_angle: uphill towards +x [degrees]; h: side of the
    elements [m], of which length, cut and heights are multiples (the middle of the slab: of half of it); lean: dx/dz of
    the ends, tan(slope_angle) where they are vertical.
    """
    gravity = -g * np.array([np.sin(np.radians(slope_angle)), np.cos(np.radians(slope_angle))])
    weak_rows, columns, rows = round(weak.height / h), round(length / h), round((weak.height + slab.height) / h)
    column, row = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    below = row < weak_rows
    there = ~below | ((column + 0.5) * h > cut)
    column, row, below = column[there], row[there], below[there]
    per_column = 2 * rows + 1
    nodes = [(2 * column + a) * per_column + 2 * row + b for a in range(3) for b in range(3)]
    dofs = np.stack([2 * node + axis for node in nodes for axis in range(2)], axis=1).astype(np.int32)  # for SuperLU
    (K_weak, f_weak), (K_slab, f_slab) = (_element(layer, h, gravity, lean) for layer in (weak, slab))
    size = 2 * per_column * (2 * columns + 1)
    K = coo_array((np.where(below[:, None, None], K_weak, K_slab).ravel(),
                   (np.repeat(dofs, 18, axis=1).ravel(), np.tile(dofs, (1, 18)).ravel())), shape=(size, size)).tocsc()
    f = np.bincount(dofs.ravel(), np.where(below[:, None], f_weak, f_slab).ravel(), minlength=size)
    used = np.unique(dofs)
    free = used[used // 2 % per_column > 0]
    u = np.zeros(size)
    u[free] = splu(K[free][:, free].tocsc()).solve(f[free])
    middle = round(2.0 * (weak.height + 0.5 * slab.height) / h)
    return -0.5 * float(f @ u), u.reshape(-1, per_column, 2)[0, middle]


def resting_settlement(slab, weak, slope_angle, g=9.81):
    """Settlement [m] of the slab's middle line under its weight on an infinite slope: oedometric columns."""
    weight = g * np.cos(np.radians(slope_angle))
    in_weak = (slab.density * slab.height + 0.5 * weak.density * weak.height) * weak.height / weak.stiffness[1, 1]
    in_slab = slab.density * (0.5 - 0.125) * slab.height**2 / slab.stiffness[1, 1]
    return weight * (in_weak + in_slab)
