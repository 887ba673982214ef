"""Finite-strain kinematics of an isotropic law: from the stored tensor to the Hencky strain and back.

    b = Fe Feᵀ,   h = b − I (stored),   ε = ½ ln b (Hencky strain)

h, not b, is stored and updated, so that 1 + small is never formed and float32 keeps strains of 1e-6.
Near the identity, ln and exp of a traceless tensor X are polynomials in X; by Cayley-Hamilton
X³ = j₂ X + j₃ I (j₂ = ½ tr X², j₃ = det X), so they reduce to two coefficients, with no eigenvectors and no divisions.
In plane strain the block of the plane has them in closed form: with mean m, and half-difference r of its eigenvalues,

    ½ (ln(1 + m + r) + ln(1 + m − r)) = ln(1 + m) + ½ ln(1 − u²),   ½ (ln(1 + m + r) − ln(1 + m − r)) = artanh u

with u = r / (1 + m), and e^(m ± r) = e^m (cosh r ± sinh r): even functions of r, or odd ones that multiply the deviator
over r, so that r² is enough. Far from the identity ln takes the spectral path of `spectral.py`, exp is scaled and
squared. The choice is made per particle.
"""

from math import factorial

from snowmpm.compiler import ti

from .precision import by_precision, is_within
from .series import (
    SMALL_ARTANH,
    SMALL_LOG,
    artanh_ratio,
    coshm1_of_square,
    expm1_series,
    log1p_of_square,
    log1p_series,
    sinh_ratio,
)
from .spectral import compose, eigen
from .symmetric import (
    add_symmetric_part,
    contract,
    determinant,
    plus_isotropic,
    product_in_space,
    squared,
    trace,
)

# Order of the series and the Frobenius norm up to which it is right to round-off:
# the first term left out, norm^order / (order + 1) relative to X for ln, norm^order / (order + 1)! for exp.
LOG_ORDER = (6, 12)  # float32, float64
LOG_RADIUS = (0.1, 0.06)
EXP_ORDER = (4, 8)
EXP_RADIUS = (0.06, 0.05)
MAX_HALVINGS = 12
KNOWN = 32.0  # round-offs that a number must be to count as known: to 3 %, a strain of that much
WIDE_EXP_ORDER = (5, 9)  # of a series without halvings
WIDE_EXP_RADIUS = (0.12, 0.1)


@ti.func
def trial_deviation(h, A):
    """h of the trial state f b fᵀ with f = I + A:  h + A + Aᵀ + A Aᵀ + A h + h Aᵀ + A h Aᵀ.

    A: dim × dim, out-of-plane stretch 1 in plane strain.
    """
    return add_symmetric_part(h, A + product_in_space(A, h), A)


@ti.func
def round_off_of(w):
    """Round-off of the eigenvalues 1 + w of b: the entries of b carry that of the largest one."""
    return ti.static(by_precision(6e-8, 1e-16)) * (1.0 + ti.abs(w).max())


@ti.func
def _log_spectral(h):
    """(deviator of ½ ln(I + h), trace) by eigen-decomposition, and 1 where every eigenvalue is more than round-off.

    One that is not is noise, maybe negative: it is lifted to that round-off.
    Here ln(1 + w) is good enough for a small w too: it stands beside a strain that is not small.
    """
    w, V = eigen(h)
    e = 0.5 * ti.log(ti.max(1.0 + w, round_off_of(w)))
    volume = e.sum()
    e -= volume / 3.0
    return compose(e, V, h), volume, ti.select(1.0 + w.min() > KNOWN * round_off_of(w), 1, 0)


@ti.func
def log_volume(h, A):
    """½ ln det(f b fᵀ) of b = I + h and f = I + A from their own determinants, and its error (of round-off).

    b and f are tame where their product is not: sheared by γ, it has eigenvalues of about γ² and γ⁻².
    """
    f = A + ti.Matrix.identity(float, A.n)
    sides, largest = 1.0, 1.0
    for i in ti.static(range(A.n)):
        side = 0.0
        for j in ti.static(range(A.n)):
            side += f[i, j] * f[i, j]
        sides *= side
    b = plus_isotropic(h, 1.0)
    for i in ti.static(range(3)):
        largest *= b[i]
    tiny = ti.static(by_precision(1e-37, 1e-300))
    step, start = ti.max(f.determinant(), tiny), ti.max(determinant(b), tiny)
    error = ti.static(by_precision(6e-8, 1e-16)) * (ti.sqrt(sides) / step + largest / start)
    # An ordered comparison, because a NaN fails it
    sound = error < 1.0 and step < ti.static(by_precision(1e30, 1e100))
    return 0.5 * ti.log(start) + ti.log(step), ti.select(sound, error, 1.0)


@ti.func
def smallest_of(w):
    """Which of the three eigenvalues is to follow from the volume: the smallest; in plane strain of the plane's two,
    since the third is not mixed with them. And whether the others are more than round-off."""
    chosen = ti.select(w[0] <= w[1], 0, 1)
    known = True
    if ti.static(w.n == 3):
        chosen = ti.select(w[2] < ti.min(w[0], w[1]), 2, chosen)
        middle = ti.max(ti.min(w[0], w[1]), ti.min(ti.max(w[0], w[1]), w[2]))
        known = 1.0 + middle > KNOWN * round_off_of(w)
    return chosen, known


@ti.func
def strain_of_volume(h, volume, error):
    """Deviator e and trace of ½ ln(I + h), e : e, and 1 if they are more than round-off, else 0; `volume`, known from
    elsewhere to `error`, takes the place of the trace where it is known better.

    The smallest eigenvalue, which beside a large one is nothing but round-off, then follows from the other two: so a
    step that shears by γ = 1e4 keeps its volume in float32, and a law does not take it for torn apart.
    """
    w, V = eigen(h)
    noise = round_off_of(w)
    floor, tiny = ti.Vector([noise, noise, noise]), ti.static(by_precision(1e-37, 1e-300))
    chosen, known = 0, True
    if ti.static(h.n == 4):
        # That across the plane is not mixed with the others, and has none of their round-off
        floor[2] = tiny
        chosen, known = smallest_of(ti.Vector([w[0], w[1]]))
    else:
        chosen, known = smallest_of(w)
    e = 0.5 * ti.log(ti.max(1.0 + w, floor))
    total, smallest = e.sum(), 0.0
    for i in ti.static(range(3)):
        smallest += ti.select(i == chosen, 1.0 + w[i], 0.0)
    if noise < error * smallest:
        error = noise / smallest
    else:
        for i in ti.static(range(3)):
            e[i] = ti.select(i == chosen, volume - (total - e[i]), e[i])
        total = volume
    e -= total / 3.0
    deviator2 = e.norm_sqr()
    # Ordered comparisons, because a NaN fails them
    sound = known and error < 1.0 / KNOWN and deviator2 + total * total < ti.static(by_precision(1e30, 1e100))
    return compose(e, V, h), total, deviator2, ti.select(sound, 1, 0)


@ti.func
def log_series(h):
    """Deviator e and trace of ε = ½ ln(I + h), e : e, and whether h is near enough to zero for them to be right."""
    deviator, volume, deviator2, near = h, h[0], h[0], True
    if ti.static(h.n == 4):
        deviator, volume, deviator2, near = _log_in_plane(h)
    else:
        deviator, volume, deviator2, near = _log_in_space(h)
    return deviator, volume, deviator2, near


@ti.func
def _log_in_plane(h):
    """`log_series` in plane strain (4 entries), in closed form."""
    mean, half, out, shear = 0.5 * (h[0] + h[1]), 0.5 * (h[0] - h[1]), h[2], h[3]
    a, b, c = 1.0 + mean, 2.0 + mean + out, 2.0 + out
    ab, bc = a * b, b * c
    inverse = 1.0 / (a * bc)  # one division for three
    per_a, t, w = bc * inverse, out * (ab * inverse), (mean - out) * (a * c * inverse)
    square = half * half + shear * shear
    u2, t2, w2 = per_a * per_a * square, t * t, w * w
    # Logarithms of 1 + zz, of (1 + mean) over that, and ½ ln(1 − u²)
    log_out, log_gap, bend = 2.0 * t * artanh_ratio(t2), 2.0 * w * artanh_ratio(w2), 0.5 * log1p_of_square(u2)
    gap = 0.5 * (log_gap + bend)  # mean strain in the plane less that out of it
    ratio = 0.5 * per_a * artanh_ratio(u2)
    third = ti.static(1.0 / 3.0) * gap
    deviator = ti.Vector([third + ratio * half, third - ratio * half, -2.0 * third, ratio * shear])
    near = is_within(u2, ti.static(SMALL_ARTANH**2)) and is_within(w2, ti.static(SMALL_ARTANH**2))
    near = near and is_within(mean, SMALL_LOG) and is_within(out, SMALL_LOG)
    return deviator, log_gap + 1.5 * log_out + bend, 2.0 * ratio * ratio * square + 2.0 * third * gap, near


@ti.func
def _log_in_space(h):
    """`log_series` in space (6 entries), by a polynomial in the traceless part of h."""
    mean = trace(h) / 3.0
    scale = 1.0 + mean
    # X = (h − mean I) / scale is traceless; its two invariants and the two coefficients carry the scale
    D = plus_isotropic(h, -mean)
    D2 = squared(D)
    inverse = 1.0 / scale
    inverse2 = inverse * inverse
    j2 = 0.5 * trace(D2) * inverse2
    j3 = determinant(D) * inverse2 * inverse
    # tr ε = ½ ln det b = (3/2) ln(1 + mean) + ½ ln(1 + j₃ − j₂); the last is a correction, below radius²/4
    y = j3 - j2
    poly = 0.0
    for k in ti.static(range(by_precision(3, 6), 0, -1)):
        poly = ti.static((-1) ** (k + 1) * 0.5 / k) + poly * y
    volume = 1.5 * log1p_series(mean) + poly * y
    # ln(I + X) = Σ (−1)^(k+1) X^k / k;  X^k = c0 I + c1 X + c2 X²
    a1, a2 = 0.5, -0.25
    c0, c1, c2 = 0.0, 0.0, 1.0
    for k in ti.static(range(3, by_precision(*LOG_ORDER) + 1)):
        c0, c1, c2 = c2 * j3, c0 + c2 * j2, c1
        a1 += ti.static((-1) ** (k + 1) * 0.5 / k) * c1
        a2 += ti.static((-1) ** (k + 1) * 0.5 / k) * c2
    deviator = plus_isotropic((a1 * inverse) * D + (a2 * inverse2) * D2, -a2 * j2 * ti.static(2.0 / 3.0))
    deviator2 = 2.0 * a1 * a1 * j2 + a2 * (6.0 * a1 * j3 + ti.static(2.0 / 3.0) * a2 * j2 * j2)
    near = is_within(j2, ti.static(0.5 * by_precision(*LOG_RADIUS) ** 2)) and is_within(mean, SMALL_LOG)
    return deviator, volume, deviator2, near


@ti.func
def hencky_strain(h):
    """Deviator e and trace of ε = ½ ln(I + h), e : e, and 1 if they are finite and more than round-off, else 0."""
    deviator, volume, deviator2, near = log_series(h)
    known = 1
    if not near:
        deviator, volume, known = _log_spectral(h)
        deviator2 = contract(deviator, deviator)
        # An ordered comparison, because a NaN fails it
        known *= ti.select(deviator2 + volume * volume < ti.static(by_precision(1e30, 1e100)), 1, 0)
    return deviator, volume, deviator2, known


@ti.func
def deviation_of_strain(deviator, volume, deviator2, factor):
    """h = exp(2 ε) − I of a Hencky strain ε = `factor` e + (`volume` / 3) I.

    deviator: e (4 or 6 entries, `symmetric`), traceless; volume: tr ε; deviator2: e : e. h has as many entries as e.
    The factor is apart because a return map knows it last: all products of e are formed while it is being found.
    """
    scale = 2.0 * factor
    share = ti.static(2.0 / 3.0) * volume
    norm2 = scale * scale * deviator2 + share * share
    halvings = 0
    while norm2 > ti.static(by_precision(*EXP_RADIUS) ** 2) and halvings < MAX_HALVINGS:
        norm2 *= 0.25
        scale *= 0.5
        share *= 0.5
        halvings += 1
    h = exp_series(deviator, deviator2, scale, share, ti.static(by_precision(*EXP_ORDER)))
    for _ in range(halvings):
        h = 2.0 * h + squared(h)
    return h


@ti.func
def deviation_of_small_strain(deviator, volume, deviator2, factor):
    """`deviation_of_strain` without a branch or a loop, and whether the strain is small enough for it to be right."""
    scale = 2.0 * factor
    share = ti.static(2.0 / 3.0) * volume
    h = exp_series(deviator, deviator2, scale, share, ti.static(by_precision(*WIDE_EXP_ORDER)))
    norm2 = scale * scale * deviator2 + share * share
    return h, is_within(norm2, ti.static(by_precision(*WIDE_EXP_RADIUS) ** 2))


@ti.func
def exp_series(deviator, deviator2, scale, share, order: ti.template()):
    """exp(scale e + share I) − I of a deviator e near zero; deviator2: e : e; order: of a series in space."""
    h = deviator
    if ti.static(deviator.n == 4):
        h = _exp_in_plane(deviator, scale, share)
    else:
        h = _exp_in_space(deviator, deviator2, scale, share, order)
    return h


@ti.func
def _exp_in_plane(deviator, scale, share):
    """`exp_series` in plane strain (4 entries), in closed form."""
    mean = (0.5 * scale) * (deviator[0] + deviator[1])
    half, shear = (0.5 * scale) * (deviator[0] - deviator[1]), scale * deviator[3]
    square = half * half + shear * shear
    in_plane, out = expm1_series(share + mean), expm1_series(share + scale * deviator[2])
    grown = 1.0 + in_plane
    middle, ratio = in_plane + grown * coshm1_of_square(square), grown * sinh_ratio(square)
    return ti.Vector([middle + ratio * half, middle - ratio * half, out, ratio * shear])


@ti.func
def _exp_in_space(deviator, deviator2, scale, share, order: ti.template()):
    """`exp_series` in space (6 entries), by a polynomial in e."""
    scale2 = scale * scale
    j2 = 0.5 * scale2 * deviator2
    j3 = scale2 * scale * determinant(deviator)
    # exp(X) − I = Σ X^k / k!,  X = scale e
    a0, a1, a2 = 0.0, 1.0, 0.5
    c0, c1, c2 = 0.0, 0.0, 1.0
    for k in ti.static(range(3, order + 1)):
        c0, c1, c2 = c2 * j3, c0 + c2 * j2, c1
        a0 += ti.static(1.0 / factorial(k)) * c0
        a1 += ti.static(1.0 / factorial(k)) * c1
        a2 += ti.static(1.0 / factorial(k)) * c2
    # exp(X + x I) − I = (1 + g)(exp(X) − I) + g I,  g = exp(x) − 1
    g = expm1_series(share)
    grown = 1.0 + g
    return plus_isotropic((grown * a1 * scale) * deviator + (grown * a2 * scale2) * squared(deviator), grown * a0 + g)
