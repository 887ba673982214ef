"""The inverse of the moment K_i = sum_j V_j (x_j - x_i) (x) grad_i W_ij of a neighbourhood.

Particles with too few neighbours have none: its determinant is kept from falling below LEAST_DETERMINANT, which lets
what is made of it fade out.
"""

import functools

from snowmpm.compiler import ti

LEAST_DETERMINANT = {2: 0.02, 3: 0.005}
"""Of K; a corner of a body has about 0.2 and 0.1."""


@functools.cache
def inverse_function(dim, real):
    """inverse(K) for symmetric K (dim, dim)."""

    @ti.func
    def inverse(K):
        """K^-1 in a straight line, which fades out where K has none."""
        adjugate, least = ti.Matrix.zero(real, dim, dim), ti.static(LEAST_DETERMINANT[dim])
        if ti.static(dim == 2):
            adjugate = ti.Matrix([[K[1, 1], -K[0, 1]], [-K[0, 1], K[0, 0]]])
        else:
            for a in ti.static(range(3)):
                for b in ti.static(range(3)):
                    p, q, r, s = ti.static((b + 1) % 3, (b + 2) % 3, (a + 1) % 3, (a + 2) % 3)
                    adjugate[a, b] = K[p, r] * K[q, s] - K[p, s] * K[q, r]
        determinant = K[0, 0] * adjugate[0, 0]
        for b in ti.static(range(1, dim)):
            determinant += K[0, b] * adjugate[b, 0]
        return adjugate / ti.select(determinant > least, determinant, least)

    return inverse
