"""Eigenvalues and eigenvectors of a symmetric 3×3 tensor by cyclic Jacobi rotations.

Jacobi is the robust choice: it needs no case distinction for repeated or nearly repeated eigenvalues, its vectors are
orthogonal to round-off, and its eigenvalues are as good as the stored entries allow. It is the slow path (a few
hundred ns); kinematics near the identity never gets here. (`ti.sym_eig` is wrong by O(strain) and is not used.)
"""

import taichi as ti

from .precision import by_precision
from .symmetric import PAIRS

SWEEPS = 10  # Cyclic Jacobi converges quadratically: 5 sweeps reach round-off in practice, the rest is margin.


@ti.func
def _rotation(app, aqq, apq):
    """Cosine, sine and tangent of the rotation that makes entry (p, q) zero; stable for apq -> 0."""
    gap = aqq - app
    sign = ti.select(gap >= 0.0, 1.0, -1.0)
    t = 2.0 * apq * sign / (ti.abs(gap) + ti.sqrt(gap * gap + 4.0 * apq * apq) + ti.static(by_precision(1e-37, 1e-300)))
    c = 1.0 / ti.sqrt(1.0 + t * t)
    return c, t * c, t


@ti.func
def eigen(a):
    """Eigenvalues (vector of 3, unordered) and eigenvectors (columns of a 3×3 matrix) of a 4- or 6-entry tensor."""
    V = ti.Matrix.identity(float, 3)
    w = ti.Vector([a[0], a[1], a[2]])
    if ti.static(a.n == 4):
        c, s, t = _rotation(a[0], a[1], a[3])
        w[0] -= t * a[3]
        w[1] += t * a[3]
        V[0, 0], V[0, 1], V[1, 0], V[1, 1] = c, s, -s, c
    else:
        off = ti.Vector([a[3], a[4], a[5]])  # xy, yz, xz
        sweep = 0
        scale = w.norm_sqr() + 2.0 * off.norm_sqr()
        while sweep < SWEEPS and off.norm_sqr() > ti.static(by_precision(1e-15, 1e-33)) * scale:
            # (p, q), entry of off that vanishes, and the two entries (r, p), (r, q) that are mixed
            for p, q, pq, rp, rq in ti.static(((0, 1, 0, 2, 1), (1, 2, 1, 0, 2), (0, 2, 2, 0, 1))):
                c, s, t = _rotation(w[p], w[q], off[pq])
                w[p] -= t * off[pq]
                w[q] += t * off[pq]
                off[pq] = 0.0
                x, y = off[rp], off[rq]
                off[rp], off[rq] = c * x - s * y, s * x + c * y
                for i in ti.static(range(3)):
                    x, y = V[i, p], V[i, q]
                    V[i, p], V[i, q] = c * x - s * y, s * x + c * y
            sweep += 1
    return w, V


@ti.func
def sorted_eigen(a):
    """`eigen` with the largest value first."""
    w, V = eigen(a)
    for i, j in ti.static(((0, 1), (1, 2), (0, 1))):
        if w[i] < w[j]:
            w[i], w[j] = w[j], w[i]
            for k in ti.static(range(3)):
                V[k, i], V[k, j] = V[k, j], V[k, i]
    return w, V


@ti.func
def compose(w, V, like):
    """Symmetric tensor of eigenvalues w and eigenvectors V, with as many entries as `like`."""
    result = like
    for k in ti.static(range(like.n)):
        i, j = ti.static(PAIRS[k])
        result[k] = V[i, 0] * V[j, 0] * w[0] + V[i, 1] * V[j, 1] * w[1] + V[i, 2] * V[j, 2] * w[2]
    return result
