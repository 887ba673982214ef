"""Eigenvalues and eigenvectors of a symmetric 3×3 tensor by cyclic Jacobi rotations.

Jacobi is the robust choice: it needs no case distinction for repeated or nearly repeated eigenvalues, its vectors are
orthogonal to round-off, and its eigenvalues are as good as the stored entries allow. It is the slow path (a few
hundred ns); kinematics near the identity never gets here. (`ti.sym_eig` is wrong by O(strain) and is not used.)
Laws in principal space decompose a deviator, where one eigenvalue always lies apart: that needs no sweeps.
"""

from snowmpm.compiler import ti

from .precision import by_precision
from .symmetric import PAIRS, determinant, plus_isotropic, trace

SWEEPS = 10  # Cyclic Jacobi converges quadratically: 5 sweeps reach round-off in practice, the rest is margin.


@ti.func
def _rotation(app, aqq, apq):
    """Cosine, sine and tangent of the rotation that makes entry (p, q) zero; stable for apq -> 0."""
    gap = aqq - app
    sign = ti.select(gap >= 0.0, 1.0, -1.0)
    t = 2.0 * apq * sign / (ti.abs(gap) + ti.sqrt(gap * gap + 4.0 * apq * apq) + ti.static(by_precision(1e-37, 1e-300)))
    t = ti.max(-1.0, ti.min(1.0, t))  # its bound, which squares that underflow would break
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
def eigen_of_deviator(a, square):
    """Eigenvalues, largest first, and eigenvectors of a tensor whose trace is round-off; no sweeps of rotations.

    square: a : a. Errors are round-off of the largest entry, also for repeated values: of three numbers that add to
    zero, one lies apart from the other two by at least 1.7 times the norm over √2. It is the root of largest modulus of
    λ³ − j₂ λ − det a = 0, found by Newton's method from above; its vector is the largest cross product of two rows of
    a − λ I; one Jacobi rotation in the plane normal to it gives the other two.
    """
    w, V = ti.Vector.zero(float, 3), ti.Matrix.identity(float, 3)
    if ti.static(a.n == 4):
        w, V = eigen(a)
    elif square > ti.static(by_precision(1e-30, 1e-200)):
        size = ti.sqrt(0.5 * square)
        n = plus_isotropic(a, -trace(a) / 3.0) * (1.0 / size)
        det = determinant(n)
        side = ti.select(det >= 0.0, 1.0, -1.0)
        c = ti.min(ti.abs(det), ti.static(2.0 / 27.0**0.5))  # y³ − y = c, 1 <= y <= 2/√3; the start is within 2e-3
        y = 1.0 + c * (0.5 - 0.2548 * c)
        for _ in ti.static(range(by_precision(2, 3))):
            y -= ((y * y - 1.0) * y - c) / (3.0 * y * y - 1.0)
        x = side * y
        rows = (
            ti.Vector([n[0] - x, n[3], n[5]]),
            ti.Vector([n[3], n[1] - x, n[4]]),
            ti.Vector([n[5], n[4], n[2] - x]),
        )
        apart = rows[0].cross(rows[1])
        for pair in ti.static(((0, 2), (1, 2))):
            other = rows[pair[0]].cross(rows[pair[1]])
            if other.norm_sqr() > apart.norm_sqr():
                apart = other
        apart /= apart.norm()
        # An orthonormal basis with `apart` as third axis, Duff et al. (2017), J. Comput. Graph. Tech. 6(1)
        sign = ti.select(apart[2] >= 0.0, 1.0, -1.0)
        k = -1.0 / (sign + apart[2])
        m = apart[0] * apart[1] * k
        u = ti.Vector([1.0 + sign * apart[0] * apart[0] * k, sign * m, -sign * apart[0]])
        v = ti.Vector([m, sign + apart[1] * apart[1] * k, -apart[1]])
        nu, nv = _times(a, u), _times(a, v)
        uv = u.dot(nv)
        cosine, sine, t = _rotation(u.dot(nu), v.dot(nv), uv)
        w = ti.Vector([u.dot(nu) - t * uv, v.dot(nv) + t * uv, apart.dot(_times(a, apart))])
        V = ti.Matrix.cols([cosine * u - sine * v, sine * u + cosine * v, apart])
    for i, j in ti.static(((0, 1), (1, 2), (0, 1))):
        if w[i] < w[j]:
            w[i], w[j] = w[j], w[i]
            for k in ti.static(range(3)):
                V[k, i], V[k, j] = V[k, j], V[k, i]
    return w, V


@ti.func
def _times(a, x):
    """a x for a tensor of six entries."""
    return ti.Vector(
        [
            a[0] * x[0] + a[3] * x[1] + a[5] * x[2],
            a[3] * x[0] + a[1] * x[1] + a[4] * x[2],
            a[5] * x[0] + a[4] * x[1] + a[2] * x[2],
        ]
    )


@ti.func
def compose(w, V, like):
    """Symmetric tensor of eigenvalues w and eigenvectors V, with as many entries as `like`."""
    result = like
    for k in ti.static(range(like.n)):
        i, j = ti.static(PAIRS[k])
        result[k] = V[i, 0] * V[j, 0] * w[0] + V[i, 1] * V[j, 1] * w[1] + V[i, 2] * V[j, 2] * w[2]
    return result
