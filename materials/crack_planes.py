"""The planes of cracks within a particle: what is kept of one, its normal, how it moves, the traction on it."""

from snowmpm.compiler import ti

from .precision import by_precision
from .symmetric import PAIRS, plus_isotropic, trace

DAMAGE, OPENING, NORMAL, PER_CRACK = 0, 1, 2, 8
"""Where the numbers of a crack are in the state, and how many there are."""


@ti.func
def traction(tau, n):
    """τ n of a tensor of 4 or 6 entries."""
    t = ti.Vector([tau[0] * n[0] + tau[3] * n[1], tau[3] * n[0] + tau[1] * n[1], tau[2] * n[2]])
    if ti.static(tau.n == 6):
        t += ti.Vector([tau[5] * n[2], tau[4] * n[2], tau[5] * n[0] + tau[4] * n[1]])
    return t


@ti.func
def normal_of(state, first: ti.template()):
    """Unit normal of the crack whose n ⊗ n begins there in the state, its sign left open; zero where there is none."""
    N = ti.Vector([state[first + k] for k in ti.static(range(6))])
    n = ti.Vector([N[0], N[3], N[5]])
    if N[1] > N[0] and N[1] >= N[2]:
        n = ti.Vector([N[3], N[1], N[4]])
    elif N[2] > N[0] and N[2] > N[1]:
        n = ti.Vector([N[5], N[4], N[2]])
    # Its largest column; rounding leaves a little of other directions, which two products square away
    n = traction(N, traction(N, n))
    return n / ti.max(n.norm(), ti.static(by_precision(1e-30, 1e-200)))


@ti.func
def carried_along(n, A):
    """Normal of a plane of the material after the step f = I + A: along f⁻ᵀ n, so along the cofactors of f."""
    f = A + ti.Matrix.identity(float, A.n)
    m = n
    if ti.static(A.n == 3):
        columns = [ti.Vector([f[0, j], f[1, j], f[2, j]]) for j in ti.static(range(3))]
        m = n[0] * columns[1].cross(columns[2]) + n[1] * columns[2].cross(columns[0])
        m += n[2] * columns[0].cross(columns[1])
    else:
        m = ti.Vector([f[1, 1] * n[0] - f[1, 0] * n[1], f[0, 0] * n[1] - f[0, 1] * n[0], f.determinant() * n[2]])
    return m / ti.max(m.norm(), ti.static(by_precision(1e-30, 1e-200)))


@ti.func
def jump_strain(like, n, jump):
    """sym(n ⊗ w) of a normal n and a jump over the length of the particle w = u/H, of as many entries as `like`."""
    strain = like
    for k in ti.static(range(like.n)):
        i, j = ti.static(PAIRS[k])
        strain[k] = 0.5 * (n[i] * jump[j] + jump[i] * n[j])
    return strain


@ti.func
def elastic_stress(prm: ti.template(), strain):
    """D : ε of an isotropic material [Pa]."""
    two_G = 2.0 * prm.shear_modulus
    return plus_isotropic(two_G * strain, (prm.K - ti.static(1.0 / 3.0) * two_G) * trace(strain))
