"""Implicit return to a Cam-Clay ellipse whose size p₀ hardens or softens with plastic volume change.

    y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0        p₀ = p_fixed + S v(ξ ζ), see `hardening.py`

Associated flow and backward Euler (the flow direction and p₀ both at the end of the step):

    p = p_tr − K Δz,   Δz = γ M² (2p − (1 − β) p₀),   q = q_tr / (1 + 6 G γ (1 + 2β)),   ζ = ζ₀ + r_ζ Δz

Δz is the plastic volume loss (compaction positive). With centre c = (1 − β) p₀/2 and half-axis r = (1 + β) p₀/2, a
point of the ellipse is p = c + r cos θ, q = M r sin θ / √(1 + 2β). Dividing the two flow equations removes γ:

    tan θ = e / d,    e = √(1 + 2β) q_tr / M,    d = (p − c) + (3 G (1 + 2β) / M²) Δz

which leaves one equation in one unknown:

    Q(Δz) = c + r cos θ − p = 0

Every term is explicit in Δz and smooth everywhere: at both tips (e = 0), at the vertex (p = c, where schemes that
divide by ∂y/∂p fail), for trial states however far away, and as p₀ → 0. Q changes sign between Δz = 0 and the point
where the normal becomes purely deviatoric (p = c), so there is always a bracket; Newton runs inside it.
"""

from snowmpm.compiler import ti

from .hardening import hardening_moved, hardening_slope, hardening_value
from .precision import by_precision, larger, smaller

MAX_ITERATIONS = 50
PATIENCE = 20  # iterations: from there on every other step bisects
STEP_TOLERANCE = (0.1, 5e-4)  # of p₀; the step is of fourth order: about 0.02 of its fourth power is left
STRAIGHT_TOLERANCE = (0.1, 0.02)  # of steps in a straight line, which in float64 one of Newton's follows
LEAST_SQUARE = (1e-30, 1e-200)  # what keeps 1/√(d² + e²) finite
YIELD_TOLERANCE = (2e-6, 1e-11)  # of M² r²: below it a trial state counts as elastic


@ti.func
def return_to_ellipse(p_trial, e2, bulk, kappa, xi, beta, p_fixed, scale, offset, zeta, rate, value, side, start, end):
    """Solve Q(Δz) = 0 between `start` (flow not yet finished) and `end` (p = c reached or passed).

    e2: e² [Pa²]; kappa: 3 G (1 + 2β) / M² [Pa]; zeta, rate: ζ₀ and dζ/dΔz; value: v at the start;
    side: +1 compacting (p > c), −1 dilating.
    Returns p, the factor q/q_tr = r/√(d² + e²), and the number of iterations, −1 if not converged.
    """
    growth = xi * rate
    near, far = start, end
    x = start
    p0, d = 0.0, 0.0
    reach = 0.0 + ti.static(by_precision(1e30, 1e200))
    iterations = 0
    converged = 0
    while converged == 0 and iterations < MAX_ITERATIONS:
        if iterations > 0:
            value = hardening_value(xi * (zeta + rate * x), offset, "")
        iterations += 1
        p0, d, root, w, residual, newton, bend, change, slopes = newton_step(
            p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, value, hardening_slope(value, offset), x
        )
        step = newton - newton * bend
        small = is_small(change, growth * newton, p0, reach, ti.static(by_precision(*STEP_TOLERANCE)))
        if small and side * w >= 0.0 and side * (x + step - near) >= 0.0:
            converged = 1
        else:
            step = damped(newton, bend)
            reach = ti.select(iterations == 1, root, reach)
            rounding = ti.static(by_precision(5e-7, 1e-15)) * (ti.abs(p_trial) + bulk * ti.abs(x))
            beyond = side * w < -rounding
            before = not beyond and side * residual < 0.0
            near, far = ti.select(before, x, near), ti.select(before, far, x)
            # Beyond p = c the sign of Q says nothing: bisect, as for a step out of the bracket or a NaN. Along the
            # exponential of p₀ Newton's steps are 1/ξ at most: at trial pressures of tens of K it would take hundreds
            lower, upper = ti.min(near, far), ti.max(near, far)
            inside = not beyond and x + step >= lower and x + step <= upper
            inside = inside and (iterations < PATIENCE or iterations % 2 == 0)
            step = ti.select(inside, step, 0.5 * (near + far) - x)
            converged = ti.select((inside and small) or bulk * ti.abs(step) <= rounding, 1, 0)
        x += step
        p0, d = followed(p0, d, slopes, step)
    p, ratio = point_of(p0, d, e2, beta)
    return p, ratio, ti.select(converged == 1, iterations, -1)


@ti.func
def straight_step(p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, side, start, end, iterate):
    """One step of `return_to_ellipse` in a straight line, without a bracket. growth: d(ξ ζ)/dΔz.

    iterate: 1 while steps must follow, Δz, v and dv/dt there, what the first step measured, and iterations, −1 where it
    fails; `first_iterate` begins it. What has converged stays as it is; `straight_point` is the answer.
    """
    going, reach = iterate[0] > 0.0, iterate[4]
    p0, _, root, w, _, newton, bend, change, _slopes = newton_step(
        p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, iterate[2], iterate[3], iterate[1]
    )
    done = is_small(change, growth * newton, p0, reach, ti.static(by_precision(*STRAIGHT_TOLERANCE)))
    done = done and side * w >= 0.0
    step = ti.select(done, newton - newton * bend, damped(newton, bend))
    value, dvalue, right = hardening_moved(iterate[2], iterate[3], growth * step)
    x = iterate[1] + step
    sound = side * x >= side * start and (done or (right and side * x <= side * end))
    following = ti.Vector(
        [
            ti.select(sound and not done, 1.0, 0.0), x, value, dvalue, ti.select(iterate[5] > 0.0, reach, root),
            ti.select(sound, iterate[5] + 1.0, -1.0),
        ]
    )  # fmt: skip
    return ti.select(going, following, iterate)


@ti.func
def first_iterate(going, start, value, offset):
    """Where `straight_step` begins: at Δz = start, where v is `value`, if `going` is 1."""
    reach = ti.static(by_precision(1e30, 1e200))
    return ti.Vector([going, start, value, hardening_slope(value, offset), 0.0 + reach, 0.0])


@ti.func
def straight_point(p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, iterate):
    """p and q/q_tr where the steps ended; in float64 after a last one, Newton's own.

    It doubles the digits of what the fourth-order step left, which may be the longer for it.
    """
    half_gap = 0.5 * (1.0 - beta)
    p0 = p_fixed + scale * iterate[2]
    p_flow = p_trial - bulk * iterate[1]
    d = p_flow - half_gap * p0 + kappa * iterate[1]
    square = d * d + e2 + ti.static(by_precision(*LEAST_SQUARE))
    inverse2 = 1.0 / square
    inverse = ti.sqrt(square) * inverse2
    ratio = 0.5 * (1.0 + beta) * p0 * inverse
    p = half_gap * p0 + ratio * d
    if ti.static(by_precision(False, True)):
        dp0, cosine = scale * growth * iterate[3], d * inverse
        dd, dradius = kappa - bulk - half_gap * dp0, 0.5 * (1.0 + beta) * dp0
        slope = half_gap * dp0 + dradius * cosine + ratio * e2 * inverse2 * dd
        step = (p_flow - p) / (bulk + slope)
        p += slope * step
        ratio += (dradius - ratio * cosine * dd) * inverse * step
    return p, ratio


@ti.func
def newton_step(p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, value, dvalue, x):
    """Newton's step from Δz = x, where v is `value` and dv/dt is `dvalue`; growth: dt/dΔz.

    Returns p₀, d, √(d² + e²), w = p − c, Q, the step, the share of it that the next two orders take away, the change of
    stress in the step, and the first two derivatives of p₀ and of d.
    """
    half_sum, half_gap = 0.5 * (1.0 + beta), 0.5 * (1.0 - beta)
    p0, dp0 = p_fixed + scale * value, scale * growth * dvalue
    ddp0 = scale * growth * growth * value
    w, dw, ddw = p_trial - bulk * x - half_gap * p0, -bulk - half_gap * dp0, -half_gap * ddp0
    d, dd = w + kappa * x, dw + kappa
    square = d * d + e2 + ti.static(by_precision(*LEAST_SQUARE))
    root = ti.sqrt(square)
    inverse2 = 1.0 / square
    inverse = root * inverse2  # the division does not wait for the root
    cosine = d * inverse
    radius, dradius, ddradius = half_sum * p0, half_sum * dp0, half_sum * ddp0
    # g = cos θ as a function of d, and the derivatives of Q; in the third one p₀'' is left out
    dg = e2 * inverse2 * inverse
    ddg, dddg = -3.0 * d * inverse2 * dg, (15.0 * cosine * cosine - 3.0) * inverse2 * dg
    residual = radius * cosine - w
    slope = dradius * cosine + radius * dg * dd - dw
    second = ddradius * cosine + 2.0 * dradius * dg * dd + radius * (ddg * dd * dd + dg * ddw) - ddw
    third = dd * dd * (radius * dddg * dd + 3.0 * dradius * ddg)
    # Newton's step and two more terms of the reversed Taylor series (fourth order), as long as they are corrections
    per_slope = 1.0 / slope
    newton = -residual * per_slope
    bend = 0.5 * newton * (second * per_slope)
    bend += newton * newton * (third * per_slope) * ti.static(1.0 / 6.0) - 2.0 * bend * bend
    change = ti.abs(newton) * (bulk + ti.abs(dd) + ti.abs(dp0)) * larger(bulk * per_slope, 1.0)
    return p0, d, root, w, residual, newton, bend, change, ti.Vector([dp0, ddp0, dd, ddw])


@ti.func
def is_small(change, argument, p0, reach, tolerance: ti.template()):
    """Whether the fourth-order step is the last one: of its change of stress, and of the argument of v.

    Newton's step is what must be small: the corrected one may vanish where the corrections are not small.
    """
    return change <= tolerance * smaller(p0, reach) and ti.abs(argument) <= ti.static(0.03 * tolerance)


@ti.func
def damped(newton, bend):
    """Newton's step, corrected by no more than 0.3 of it."""
    return newton * (1.0 - larger(smaller(bend, 0.3), -0.3))


@ti.func
def followed(p0, d, slopes, step):
    """p₀ and d after a step, from their derivatives: along a small one as good as another evaluation."""
    dp0, ddp0, dd, ddw = slopes[0], slopes[1], slopes[2], slopes[3]
    return p0 + step * (dp0 + 0.5 * step * ddp0), d + step * (dd + 0.5 * step * ddw)


@ti.func
def point_of(p0, d, e2, beta):
    """p and q/q_tr of the point of the ellipse where tan θ = e/d."""
    square = d * d + e2 + ti.static(by_precision(*LEAST_SQUARE))
    ratio = 0.5 * (1.0 + beta) * p0 / square * ti.sqrt(square)
    return 0.5 * (1.0 - beta) * p0 + ratio * d, ratio
