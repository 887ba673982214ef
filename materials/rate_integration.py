"""Large steps of a rate law: exact rotation, then sub-steps of the rate equation along a constant stretching.

A hypoplastic law gives the stress rate from stress and stretching. With η the (translated) Cauchy stress, tension
positive, and a law that is homogeneous of degree one in the stretching D,

    η° = tr(η) |D| G(r, ln p, e; D/|D|),     r = η / tr η,   p = −tr(η)/3

A step f = V R turns η with R (R η Rᵀ = V⁻¹ f η fᵀ V⁻¹, no eigenvectors needed) and then follows the constant
stretching ln V: the rate of a body that does not turn is the plain one. A rotation of any size, alone or on top of a
stretch, is exact; where the directions of stretching turn within a step the result differs from Jaumann's rate, the
published one, by an error of second order in the step.

    d ln p / ds = |ln V| tr G,     dr / ds = |ln V| (G − tr(G) r),     0 <= s <= 1

The logarithm of p, not p, because the stress of a confined step grows like exp(345 ε): r soon stands still and the
sub-steps may be long. Bogacki and Shampine's pair of Runge-Kutta formulas, third order with a second-order estimate of
the error (Appl. Math. Lett. 2 (1989) 321, doi:10.1016/0893-9659(89)90079-7); the third-order result is kept.
"""

from snowmpm.compiler import ti

from .elastic import elastic_trial
from .hencky import deviation_of_strain
from .precision import by_precision
from .series import expm1_series
from .symmetric import PAIRS, add_symmetric_part, contract, plus_isotropic, product_in_space, trace

ORDER = 3
MAX_ATTEMPTS = 400  # sub-steps, accepted or not; a step that needs more is reported
HIGHEST_LOG_PRESSURE = 60.0  # exp(60) Pa: nothing physical, and its square is within float32's range
GROWTH_LIMITS = (1e-3, 1e4)  # of 1 + e over its initial value: beyond, the volume of a loose grain means nothing


@ti.func
def turning(A, deviator, volume, deviator2):
    """R − I of f = I + A = V R, with the deviator, trace and square e : e of ln V."""
    w = deviation_of_strain(deviator, -0.5 * volume, deviator2, -0.5)  # V⁻¹ − I
    # R − I = A + w + w A, and w A is the transpose of Aᵀ w
    B = A + product_in_space(A.transpose(), w).transpose()
    for k in ti.static(range(w.n)):
        i, j = ti.static(PAIRS[k])
        if ti.static(j < A.n):
            B[i, j] += w[k]
            if ti.static(i != j):
                B[j, i] += w[k]
    return B


@ti.func
def turned(tensor, B):
    """R X Rᵀ of a symmetric tensor X; B = R − I."""
    return add_symmetric_part(tensor, product_in_space(B, tensor), B)


@ti.func
def slopes(rate: ti.template(), prm: ti.template(), r, log_p, void_ratio, direction):
    """dr and d ln p per unit of |ln V| s."""
    G = rate(prm, r, log_p, void_ratio, direction)
    growth = trace(G)
    return G - growth * r, growth


@ti.func
def integrate(rate: ti.template(), prm: ti.template(), r, log_p, start, solid, direction, size, volume):
    """Follow the stretching from s = `start` to 1, or until p falls to its floor.

    solid: 1 + e at s = 0. Returns r, ln p, s at the end, ∫ J σ : ln V ds with J = 1 at s = 0, and the number of
    sub-steps, −1 if too many would be needed.
    """
    s, attempts, steps, work = start, 0, 0, 0.0
    k1, g1 = slopes(rate, prm, r, log_p, solid * ti.exp(volume * s) - 1.0, direction)
    tolerance = prm.tolerance
    # First guess: r relaxes about as fast as ln p grows, and the error is a cube of that times the way r has to go
    turning = ti.sqrt(contract(k1, k1))
    pace = ti.abs(g1) + turning + ti.static(by_precision(1e-30, 1e-100))
    step = ti.pow(10.0 * tolerance / (turning / pace + tolerance), 1.0 / 3.0) / (size * pace)
    along = contract(r, direction)
    power = ti.exp(volume * s) * (prm.apex * volume - 3.0 * size * ti.exp(log_p) * along)
    running = 1
    while running == 1 and attempts < MAX_ATTEMPTS:
        attempts += 1
        left = 1.0 - s
        last = not (step < left)
        step = ti.select(last, left, step)
        d = size * step
        half, most = s + 0.5 * step, s + 0.75 * step
        k2, g2 = slopes(
            rate, prm, r + 0.5 * d * k1, log_p + 0.5 * d * g1, solid * ti.exp(volume * half) - 1.0, direction
        )
        k3, g3 = slopes(
            rate, prm, r + 0.75 * d * k2, log_p + 0.75 * d * g2, solid * ti.exp(volume * most) - 1.0, direction
        )
        r_new = r + (d / 9.0) * (2.0 * k1 + 3.0 * k2 + 4.0 * k3)
        log_new = log_p + (d / 9.0) * (2.0 * g1 + 3.0 * g2 + 4.0 * g3)
        grown = ti.exp(volume * (s + step))
        k4, g4 = slopes(rate, prm, r_new, log_new, solid * grown - 1.0, direction)
        miss = (d / 72.0) * (6.0 * k2 + 8.0 * k3 - 5.0 * k1 - 9.0 * k4)
        error = ti.sqrt(contract(miss, miss)) + (d / 72.0) * ti.abs(6.0 * g2 + 8.0 * g3 - 5.0 * g1 - 9.0 * g4)
        # Ordered comparisons, because a NaN fails them
        if error <= tolerance and log_new < HIGHEST_LOG_PRESSURE:
            steps += 1
            if log_new < prm.log_floor:
                step *= (log_p - prm.log_floor) / (log_p - log_new)
                running = 0
            along = contract(r_new, direction)
            power_new = grown * (prm.apex * volume - 3.0 * size * ti.exp(log_new) * along)
            work += 0.5 * step * (power + power_new)
            s, r, log_p, k1, g1, power = s + step, r_new, log_new, k4, g4, power_new
            if last:
                running = 0
        step *= ti.max(0.2, ti.min(0.9 * ti.pow(tolerance / (error + 1e-30), 1.0 / 3.0), 5.0))
    return r, log_p, s, work, ti.select(running == 0, steps, -1)


@ti.func
def stretching_of(A):
    """Of f = I + A = V R: deviator, trace and square e : e of ln V, 1 if the step can be made, and R − I."""
    _, deviator, volume, deviator2, valid = elastic_trial(ti.Vector.zero(float, ti.static(6 if A.n == 3 else 4)), A)
    return deviator, volume, deviator2, valid, turning(A, deviator, volume, deviator2)


@ti.func
def advance(rate: ti.template(), prm: ti.template(), h, state, deviator, volume, deviator2, B):
    """Cauchy stress, state, work of the step per reference volume, sub-steps (−1: too many) from the stress h; the rest
    as `stretching_of` has it."""
    size = ti.sqrt(deviator2 + volume * volume * ti.static(1.0 / 3.0))
    isotropic = plus_isotropic(ti.Vector.zero(float, h.n), ti.static(1.0 / 3.0))
    solid = 1.0 + state[0]
    eta = plus_isotropic(h, -prm.apex)
    gap, start = state[1] + volume, 0.0
    if state[1] > 0.0:
        # A gap that is still open lets the whole step pass; one that closes, the share of the step before
        start = ti.select(gap > 0.0, 1.0, -state[1] / ti.min(volume, ti.static(by_precision(-1e-30, -1e-100))))
    else:
        gap = 0.0
    steps, dissipation = 0, 0.0
    if start < 1.0:
        eta = turned(eta, B)
    if start < 1.0 and size > 0.0:
        direction = plus_isotropic(deviator, volume * ti.static(1.0 / 3.0)) / size
        total = trace(eta)
        p = -total / 3.0
        floor = ti.exp(prm.log_floor)
        # Contact begins at the floor, isotropic. (A NaN goes on to the integrator and is found out there)
        at_floor = p < floor
        r = ti.select(at_floor, isotropic, eta / ti.select(at_floor, 1.0, total))
        log_p = ti.select(at_floor, prm.log_floor, ti.log(ti.select(at_floor, floor, p)))
        r, log_p, s, work, steps = integrate(rate, prm, r, log_p, start, solid, direction, size, volume)
        eta = (-3.0 * ti.exp(log_p)) * r
        gap = 0.0
        if log_p < prm.log_floor:
            eta = (-3.0 * floor) * isotropic
            if prm.apex == 0.0:  # without cohesion: separated
                eta.fill(0.0)
                gap = ti.max((1.0 - s) * volume, 0.0)
        dissipation = work * solid / (1.0 + prm.void_ratio)
    state_new = state
    largest = (1.0 + prm.void_ratio) * ti.static(GROWTH_LIMITS[1])
    smallest = (1.0 + prm.void_ratio) * ti.static(GROWTH_LIMITS[0])
    # e + (1 + e)(det f − 1), so that float32 keeps small changes
    near = ti.max(-0.04, ti.min(volume, 0.04))
    grown = ti.select(near == volume, expm1_series(near), ti.exp(volume) - 1.0)
    state_new[0] = ti.max(smallest - 1.0, ti.min(state[0] + solid * grown, largest - 1.0))
    state_new[1] = ti.max(gap, 0.0)
    state_new[2] = state[2] + ti.sqrt(ti.static(2.0 / 3.0) * deviator2)
    return plus_isotropic(eta, prm.apex), state_new, dissipation, steps


@ti.func
def outcome(prm: ti.template(), h, state, h_new, state_new, dissipation, steps, valid):
    """What an update returns (see `Law`): the step, or, where it could not be made, what was before it."""
    sound = h_new.norm_sqr() < ti.static(by_precision(3e38, 1e60))
    made = sound and steps >= 0 and valid == 1
    kept, kept_state = h, state
    if made:
        kept, kept_state = h_new, state_new
    tau = ((1.0 + kept_state[0]) / (1.0 + prm.void_ratio)) * kept
    return kept, tau, kept_state, ti.select(made, dissipation, 0.0), ti.select(made, steps, -1)


def rate_update(rate):
    """The stress update (see `Law`) of the law whose G is the Taichi function rate(prm, r, ln p, e, direction).

    The tensor that the solver carries, h, is the Cauchy stress σ [Pa].
    prm: apex, log_floor, void_ratio and tolerance are read here, see `RateParameters`; the rest is that of `rate`.
    State: void ratio e, the gap of separated material (see tension_gap.py), accumulated strain.
    """

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        deviator, volume, deviator2, valid, B = stretching_of(A)
        h_new, state_new, dissipation, steps = advance(rate, prm, h, state, deviator, volume, deviator2, B)
        return outcome(prm, h, state, h_new, state_new, dissipation, steps, valid)

    return update


def rate_stiffness(modulus):
    """The `stiffness` of a rate law: modulus(prm, r1, ln p, e) is that of unloading along a principal axis, over 3p.

    r1: the share of the principal stress in tr η, here of the largest, bounded by (p + 2q/3) / 3p.
    """

    @ti.func
    def stiffness(prm: ti.template(), tau, state):
        J = (1.0 + state[0]) / (1.0 + prm.void_ratio)
        eta = plus_isotropic(tau / J, -prm.apex)
        p = ti.max(-trace(eta) / 3.0, ti.exp(prm.log_floor))
        deviator = plus_isotropic(eta, p)
        share = (1.0 + ti.sqrt(ti.static(2.0 / 3.0) * contract(deviator, deviator)) / p) / 3.0
        return 3.0 * p * J * modulus(prm, share, ti.log(p), state[0])

    return stiffness
