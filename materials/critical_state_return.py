"""Return map of the Cam-Clay family in (p, q): which surface, which way ζ goes, and the corners of both."""

from snowmpm.compiler import ti

from .ellipse import YIELD_TOLERANCE, return_to_ellipse
from .hardening import hardening_value
from .precision import by_precision, larger


@ti.func
def ellipse_at(prm: ti.template(), p, deviator2, zeta, collapsed, straight: ti.template()):
    """Ellipse w² + (1 + 2β) 6G²/M² e:e = r² of a state.

    Returns w = p − c [Pa], the half-axis r [Pa], 6G²/M² e:e [Pa²], β, p₀ [Pa] and v.
    p: pressure [Pa], compression positive; deviator2: e : e; straight: see `hardening_value`.
    """
    beta = ti.select(collapsed == 0.0, prm.beta, 0.0)
    value = hardening_value(prm.xi * zeta, prm.offset, straight)
    p0 = prm.p_fixed + prm.scale * value
    return p - 0.5 * (1.0 - beta) * p0, 0.5 * (1.0 + beta) * p0, prm.shear_square * deviator2, beta, p0, value


@ti.func
def is_outside(w, radius, shear2, beta):
    """Whether a state yields: it lies outside its ellipse by more than round-off. Arguments: from `ellipse_at`."""
    return w * w + (1.0 + 2.0 * beta) * shear2 > radius * radius * ti.static(1.0 + by_precision(*YIELD_TOLERANCE))


@ti.func
def return_problem(prm: ti.template(), p_trial, deviator2, zeta, collapsed, frozen: ti.template(),
                   straight: ti.template(), weak: ti.template()):  # fmt: skip
    """Whether a trial state yields, and the scalar problem in Δz that `return_to_ellipse` then has to solve.

    Δz is the plastic volume loss of the step, compaction positive. It changes ζ by Δz (hardening), or by −α |Δz| while
    the bonds of a weak layer last (α > 0, collapsed = 0).
    p_trial: trial pressure [Pa], compression positive; deviator2: e : e of the trial Hencky strain; zeta, collapsed (0
    or 1): state before the step. frozen: p₀ of the start of the step serves all of it. straight: see `hardening_value`.
    weak: whether α may exceed 0; if not, what belongs to it is not compiled.

    Returns eleven numbers:

        yielded, separated   1 or 0: the state yields; if it does, it is separated and free of stress
        zeta0, rate          of ζ = ζ₀ + rate Δz
        collapsed            1 or 0, after the step
        beta                 β of the ellipse, 0 once the bonds are gone
        p_fixed              part of p₀ that stays in the step [Pa]; all of it if frozen
        value                v of p₀ = p_fixed + S v at `start`
        side                 +1 compacting, −1 dilating
        start, end           Δz between which the answer lies
    """
    K, alpha, per_K = prm.K, prm.alpha if ti.static(weak) else 0.0, prm.per_K
    w, radius, shear2, beta, p0, value = ellipse_at(prm, p_trial, deviator2, zeta, collapsed, straight)
    yielded = ti.select(is_outside(w, radius, shear2, beta), 1, 0)
    softens = alpha > 0.0 and collapsed == 0.0
    side = ti.select(w > 0.0, 1.0, -1.0)
    collapse = zeta * prm.per_alpha  # |Δz| of complete softening
    # `gap` is the Δz at which a dilating ellipse has shrunk to a point: beyond it p₀ = 0, and no stress is left
    gap = ti.select(softens, -collapse, prm.end - zeta)
    separated = p_trial <= K * gap
    # A compacting weak layer may use up its bonds within the step: it is then solved as collapsed, without cohesion.
    # Separated snow that is compacted first closes its gap, without stress.
    through = softens and w > 0.0 and p_trial >= K * collapse and ti.static(not frozen)
    start = ti.select(through, collapse, larger(gap, 0.0))
    end = ti.select(w > 0.0, ti.select(softens, p_trial, w) * per_K, larger(w * per_K, gap))
    zeta0, rate = ti.select(through, -collapse, zeta), ti.select(softens and not through, -alpha * side, 1.0)
    collapsed_new = ti.select(through, 1.0, collapsed)
    if separated:
        zeta0, rate = ti.select(softens, collapse, zeta), 1.0
        collapsed_new = ti.select(softens, 1.0, collapsed)
    value, beta = ti.select(through, 0.0, value), ti.select(through, 0.0, beta)
    p_fixed = prm.p_fixed
    if ti.static(frozen):
        p_fixed = p0
        end = w * per_K  # p₀ does not change: p = c is reached there, wherever the bonds end
    return (
        yielded, ti.select(separated, 1, 0), zeta0, rate, collapsed_new, beta, p_fixed, value, side, start, end
    )  # fmt: skip


@ti.func
def internal_variables(prm: ti.template(), p_trial, p, zeta0, rate, collapsed, collapsed_new, frozen: ti.template()):
    """ζ and `collapsed` (0 or 1) after a step that yields and ends at the pressure p [Pa].

    collapsed, collapsed_new: before the step, and as `return_problem` returns it.
    """
    zeta = zeta0 + rate * ((p_trial - p) * prm.per_K)
    if ti.static(frozen):  # noqa: SIM102 (one is compile time)
        # ζ may have gone past the end of the bonds, which the surface of the start did not know
        if prm.alpha > 0.0 and collapsed == 0.0 and collapsed_new == 0.0 and zeta <= 0.0:
            zeta, collapsed_new = 0.0, 1.0
    return zeta, collapsed_new


@ti.func
def critical_state_return(prm: ti.template(), p_trial, deviator2, zeta, collapsed, frozen: ti.template()):
    """Return map in (p, q) of a trial state. Arguments: see `return_problem`.

    Returns p [Pa], the factor on the trial deviator, ζ, collapsed, Newton iterations (−1 if they did not converge), and
    1 if the state yields, else 0.
    """
    yielded, separated, zeta0, rate, collapsed_new, beta, p_fixed, value, side, start, end = return_problem(
        prm, p_trial, deviator2, zeta, collapsed, frozen, "", True
    )
    p, ratio, iterations = p_trial, 1.0, 0
    zeta_new, collapsed_end = zeta, collapsed
    if yielded == 1:
        if separated == 1:
            p, ratio = 0.0, 0.0
        else:
            shape, xi, scale = 1.0 + 2.0 * beta, prm.xi, prm.scale
            if ti.static(frozen):
                xi, scale = 0.0, 0.0
            p, ratio, iterations = return_to_ellipse(
                p_trial, shape * prm.shear_square * deviator2, prm.K, shape * prm.shear_stiffness, xi, beta, p_fixed,
                scale, prm.offset, zeta0, rate, value, side, start, end
            )  # fmt: skip
        zeta_new, collapsed_end = internal_variables(
            prm, p_trial, p, zeta0, rate, collapsed, collapsed_new, frozen
        )
    return p, ratio, zeta_new, collapsed_end, iterations, yielded
