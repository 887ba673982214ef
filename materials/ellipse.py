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

import taichi as ti

from .hardening import hardening_value
from .precision import by_precision

MAX_ITERATIONS = 50
STEP_TOLERANCE = (0.1, 2e-3)  # of p₀; the step is of fourth order: about 0.02 of its fourth power is left
YIELD_TOLERANCE = (2e-6, 1e-11)  # of M² r²: below it a trial state counts as elastic


@ti.func
def return_to_ellipse(
    p_trial, e2, bulk, kappa, xi, beta, p_fixed, scale, offset, zeta, rate, value, side, start, end, steps: ti.template()
):
    """Solve Q(Δz) = 0 between `start` (flow not yet finished) and `end` (p = c reached or passed).

    e2: e² [Pa²]; kappa: 3 G (1 + 2β) / M² [Pa]; zeta, rate: ζ₀ and dζ/dΔz; value: v at the start;
    side: +1 compacting (p > c), −1 dilating; steps: 0, or after how many to give up, written out in a straight line.
    Returns p, the factor q/q_tr = r/√(d² + e²), and the number of iterations, −1 if not converged.
    """
    near, far = start, end
    x = start
    p, ratio = 0.0, 0.0
    reach = 0.0 + ti.static(by_precision(1e30, 1e200))
    iterations = 0
    converged = 0
    if ti.static(steps == 0):
        while converged == 0 and iterations < MAX_ITERATIONS:
            iterations += 1
            x, near, far, reach, p, ratio, converged = ellipse_step(
                p_trial, e2, bulk, kappa, xi * rate, beta, p_fixed, scale, offset, value, side, x, near, far, reach,
                iterations == 1, iterations == MAX_ITERATIONS
            )  # fmt: skip
            if converged == 0:
                value = hardening_value(xi * (zeta + rate * x), offset, False)
    else:
        for k in ti.static(range(steps)):
            if converged == 0:
                if ti.static(k > 0):
                    value = hardening_value(xi * (zeta + rate * x), offset, True)
                iterations = k + 1
                x, near, far, reach, p, ratio, converged = ellipse_step(
                    p_trial, e2, bulk, kappa, xi * rate, beta, p_fixed, scale, offset, value, side, x, near, far,
                    reach, k == 0, False
                )  # fmt: skip
    return p, ratio, ti.select(converged == 1, iterations, -1)


@ti.func
def ellipse_step(
    p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, offset, value, side, x, near, far, reach, first, last
):
    """One step of the bracketed Newton iteration from Δz = x, where v is `value`; growth: dt/dΔz.

    Returns the new x, its bracket, the size of the trial state (that of the first step), p and the factor on the
    deviator (where converged, or at the last step), and 1 if converged.
    """
    half_sum, half_gap = 0.5 * (1.0 + beta), 0.5 * (1.0 - beta)
    p0, dp0 = p_fixed + scale * value, scale * growth * ti.sqrt(offset + value * value)
    ddp0 = scale * growth * growth * value
    w, dw, ddw = p_trial - bulk * x - half_gap * p0, -bulk - half_gap * dp0, -half_gap * ddp0
    d, dd = w + kappa * x, dw + kappa
    square = d * d + e2 + ti.static(by_precision(1e-30, 1e-200))
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
    step = newton - newton * bend
    # Newton's step is what must be small: the corrected one may vanish where the corrections are not small
    change = ti.abs(newton) * (bulk + ti.abs(dd) + ti.abs(dp0)) * ti.max(1.0, bulk * per_slope)
    tolerance = ti.static(by_precision(*STEP_TOLERANCE))
    small = change <= tolerance * ti.min(p0, reach) and ti.abs(growth * newton) <= 0.03 * tolerance
    converged = 0
    if small and side * w >= 0.0 and side * (x + step - near) >= 0.0:
        converged = 1
    else:
        step = newton * (1.0 - ti.max(-0.3, ti.min(0.3, bend)))
        reach = ti.select(first, root, reach)
        rounding = ti.static(by_precision(5e-7, 1e-15)) * (ti.abs(p_trial) + bulk * ti.abs(x))
        beyond = side * w < -rounding
        before = not beyond and side * residual < 0.0
        near, far = ti.select(before, x, near), ti.select(before, far, x)
        # Beyond p = c the sign of Q says nothing: bisect, as for a step out of the bracket or a NaN
        lower, upper = ti.min(near, far), ti.max(near, far)
        inside = not beyond and x + step >= lower and x + step <= upper
        step = ti.select(inside, step, 0.5 * (near + far) - x)
        converged = ti.select((inside and small) or bulk * ti.abs(step) <= rounding, 1, 0)
    p, ratio = 0.0, 0.0
    if converged == 1 or last:
        # p₀ and d followed along the last, small step are as good as another evaluation
        p0 += step * (dp0 + 0.5 * step * ddp0)
        d += step * (dd + 0.5 * step * ddw)
        square = d * d + e2 + ti.static(by_precision(1e-30, 1e-200))
        ratio = half_sum * p0 / square * ti.sqrt(square)
        p = half_gap * p0 + ratio * d
    return x + step, near, far, reach, p, ratio, converged
