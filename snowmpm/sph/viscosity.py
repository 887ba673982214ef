"""Viscosities of a pair of particles: pressures Pi_ij over squared densities, against what should not be.

Artificial viscosity (Monaghan 1992), of pairs that approach only:

    Pi_ij = (-alpha c mu + beta mu^2) / rho,   mu = h v_ij . x_ij / (r^2 + 0.01 h^2)

Damping of disorder: the same with gamma for alpha and, whether they approach or part, only for that part of the
velocity of a pair that is not the mean stretching of both,

    mu = h (v_ij - (D_i + D_j) x_ij / 2) . x_ij / (r^2 + 0.01 h^2)

which is zero in any homogeneous motion, and leaves smooth ones alone: it holds down the modes without strain that
tension makes grow.
"""

from types import SimpleNamespace

from snowmpm.compiler import ti

SOFTENING = 0.01
"""Share of h^2 that keeps the viscosity of a pair at rest on itself finite."""


def viscosity_functions(h, viscous):
    """artificial(...) and disorder(...): m_j Pi_ij, of a pair whose v_ij . x_ij is `closing`, at a squared distance r2.

    h [cells]: smoothing length; viscous: whether there is a quadratic part. V, ratio: volume of j, volume of i over its
    mass; m: mass of j; z: sum of the rho c of both; stray: (v_ij - (D_i + D_j) x_ij / 2) . x_ij.
    """
    soft = SOFTENING * h * h

    @ti.func
    def artificial(closing, r2, V, m, ratio, z, alpha, beta):
        mu = h * ti.select(closing < 0.0, closing, 0.0) / (r2 + soft)
        push = -0.5 * alpha * V * ratio * z * mu
        if ti.static(viscous):
            push += 0.5 * beta * (V + m * ratio) * mu * mu
        return push

    @ti.func
    def disorder(stray, r2, V, ratio, z, gamma):
        return -0.5 * gamma * V * ratio * z * h * stray / (r2 + soft)

    return SimpleNamespace(artificial=artificial, disorder=disorder)
