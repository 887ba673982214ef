"""Return map of the Cam-Clay family in (p, q): which surface, which way ζ goes, and the corners of both."""

import taichi as ti

from .ellipse import YIELD_TOLERANCE, return_to_ellipse, straight_return_to_ellipse
from .hardening import hardening_value
from .precision import by_precision, larger


@ti.func
def ellipse_at(prm, p, deviator2, zeta, collapsed, straight: ti.template()):
    """Ellipse of a state: w = p − c, half-axis r [Pa], 6G²/M² e:e, β, p₀ and v; it is w² + (1 + 2β) 6G²/M² e:e = r².

    straight: see `hardening_value`.
    """
    beta = ti.select(collapsed == 0.0, prm[3], 0.0)
    value = hardening_value(prm[2] * zeta, prm[10], straight)
    p0 = prm[4] + prm[9] * value
    return p - 0.5 * (1.0 - beta) * p0, 0.5 * (1.0 + beta) * p0, prm[6] * deviator2, beta, p0, value


@ti.func
def is_outside(w, radius, shear2, beta):
    """Whether a state yields: outside its ellipse by more than round-off."""
    return w * w + (1.0 + 2.0 * beta) * shear2 > radius * radius * ti.static(1.0 + by_precision(*YIELD_TOLERANCE))


@ti.func
def critical_state_return(prm, p_trial, deviator2, zeta, collapsed, frozen: ti.template(), steps: ti.template()):
    """Return map in (p, q): p, factor on the deviator, ζ, collapsed, Newton iterations, and 1 if the state yields.

    prm: `CriticalStateLaw.parameters`; deviator2: e : e of the trial Hencky strain. With Δz the plastic compaction of
    the step, ζ changes by Δz (hardening), or by −α |Δz| while the bonds of a weak layer last (α > 0, collapsed = 0).
    steps: 0, or how many at most, in a straight line (see `return_to_ellipse`).
    frozen: p₀ of the start of the step serves all of it.
    """
    K, xi, p_fixed, alpha, per_K = prm[0], prm[2], prm[4], prm[7], prm[8]
    scale, offset = prm[9], prm[10]
    w, radius, shear2, beta, p0, value = ellipse_at(prm, p_trial, deviator2, zeta, collapsed, ti.static(steps > 0))
    softens = alpha > 0.0 and collapsed == 0.0
    p, ratio, iterations, yielded = p_trial, 1.0, 0, 0
    zeta_new, collapsed_new = zeta, collapsed
    if is_outside(w, radius, shear2, beta):
        yielded = 1
        side = ti.select(w > 0.0, 1.0, -1.0)
        collapse = zeta * (1.0 / larger(alpha, ti.static(by_precision(1e-30, 1e-300))))  # |Δz| of complete softening
        # ζ = zeta0 + rate Δz; `gap` is the Δz at which a dilating ellipse has shrunk to a point
        zeta0, rate = zeta, ti.select(softens, -alpha * side, 1.0)
        gap = ti.select(softens, -collapse, prm[11] - zeta)
        if p_trial <= K * gap:
            # Dilates until p₀ = 0 and beyond: separated and stress-free
            p, ratio = 0.0, 0.0
            zeta0, rate = ti.select(softens, collapse, zeta), 1.0
            collapsed_new = ti.select(softens, 1.0, collapsed)
        else:
            # A compacting weak layer may use up its bonds within the step: it is then solved as collapsed, without
            # cohesion. Separated snow that is compacted first closes its gap, without stress.
            through = softens and w > 0.0 and p_trial >= K * collapse and ti.static(not frozen)
            start = ti.select(through, collapse, larger(gap, 0.0))
            end = ti.select(w > 0.0, ti.select(softens, p_trial, w) * per_K, larger(w * per_K, gap))
            zeta0, rate = ti.select(through, -collapse, zeta), ti.select(through, 1.0, rate)
            value = ti.select(through, 0.0, value)
            beta = ti.select(through, 0.0, beta)
            collapsed_new = ti.select(through, 1.0, collapsed)
            shape = 1.0 + 2.0 * beta
            if ti.static(frozen):
                p_fixed, scale, xi = p0, 0.0, 0.0
                end = w * per_K  # p₀ does not change: p = c is reached there, wherever the bonds end
            if ti.static(steps > 0):
                p, ratio, iterations = straight_return_to_ellipse(
                    p_trial, shape * shear2, K, shape * prm[5], xi * rate, beta, p_fixed, scale, offset, value, side,
                    start, end, steps
                )  # fmt: skip
            else:
                p, ratio, iterations = return_to_ellipse(
                    p_trial, shape * shear2, K, shape * prm[5], xi, beta, p_fixed, scale, offset, zeta0, rate, value,
                    side, start, end
                )  # fmt: skip
        zeta_new = zeta0 + rate * ((p_trial - p) * per_K)
        if ti.static(frozen):  # noqa: SIM102 (one is compile time)
            # ζ may have gone past the end of the bonds, which the surface of the start did not know
            if softens and collapsed_new == 0.0 and zeta_new <= 0.0:
                zeta_new, collapsed_new = 0.0, 1.0
    return p, ratio, zeta_new, collapsed_new, iterations, yielded
