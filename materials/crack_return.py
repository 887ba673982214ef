"""Tractions on a crack within a particle: cohesion that fades with the jump, and friction where its faces touch.

    t = (t_n, t_s) on the plane of normal n, t_n > 0 in tension; jump u = (u_n, u_s) per particle length H

    T(ω) = f_t (1 − ω),   ω = κ/w_c,   w_c = 2 G_f / f_t              linear softening
    opening, t_n > 0:   √(t_n² + t_s²/β²) <= T,  jump normal to it, dκ = √(du_n² + β² du_s²)
    pressed, t_n <= 0:  t_s + μ t_n <= β T,      jump in the plane, dκ = β du_s

Hillerborg, Modéer and Petersson (1976), doi:10.1016/0008-8846(76)90007-7. κ is the effective jump of Ortiz and
Pandolfi (1999), doi:10.1002/(SICI)1097-0207(19990330)44:9<1267::AID-NME486>3.0.CO;2-7: t · du = T dκ while it opens, so
the crack takes G_f in every mode; pressed, friction takes its work besides.
With ω = 1 the faces are free: an opening w must close before they press, and what presses slides with friction alone.

The bulk unloads with the jump. An isotropic one of moduli M = K + 4G/3 and G, eqs. 107 to 109 of `CohesiveCrack`:

    t_n = t_n,trial − (M/H) Δu_n,   t_s = t_s,trial − (G/H) Δu_s

Backward Euler. Both equations and the flow rule leave one equation for Δκ,

    (t_n,trial / (T + Δκ M/H))² + (t_s,trial / (β T + Δκ G/(Hβ)))² = 1,    T = T(κ + Δκ),

of which 1 over the root of the left side is concave: Newton's method from the root of the larger term alone comes up to
the solution without passing it. Both denominators grow with Δκ as long as no side snaps back: f_t/w_c < M/H, G/(Hβ²).
"""

from snowmpm.compiler import ti

from .precision import by_precision

MOST = 20
"""Newton iterations; three to six are usual."""


@ti.func
def cohesive_jump(prm: ti.template(), t_n, t_s, T):
    """Δκ/w_c of an opening crack of strength T > 0 [Pa] under a trial traction beyond it, iterations (−1: too many)."""
    # Denominators T + a x and T + b x for x = Δκ/w_c
    a, b = prm.normal - prm.strength, prm.shear * prm.per_weight - prm.strength
    s = t_s * prm.per_beta
    x = ti.max((t_n - T) / a, (s - T) / b, 0.0)
    iterations, running = 0, 1
    while running == 1 and iterations < MOST:
        iterations += 1
        along, across = t_n / (T + a * x), s / (T + b * x)
        norm2 = along * along + across * across
        fall = along * along * a / (T + a * x) + across * across * b / (T + b * x)
        step = (norm2 - ti.sqrt(norm2)) / fall
        x += step
        running = ti.select(step > ti.static(by_precision(1e-6, 1e-14)) * x, 1, 0)
    return x, ti.select(running == 1, -1, iterations)


@ti.func
def crack_return(prm: ti.template(), t_n, t_s, damage, opening):
    """Traction t_n, t_s >= 0 [Pa], ω, opening [m], dissipation per volume [J/m³] and iterations (0: it holds)."""
    n, s, omega, w, work, iterations = t_n, t_s, damage, opening, 0.0, 0
    T = prm.strength * (1.0 - damage)
    near = ti.static(by_precision(1e-6, 1e-13)) * prm.strength
    left = 0.5 * T * (1.0 - damage) * prm.jump_over_length  # energy of the bonds that are left
    if damage >= 1.0:
        if w > 0.0 or t_n > 0.0:
            n = ti.min(t_n + w * prm.normal_per_metre, 0.0)
            w = ti.max(w + t_n / prm.normal_per_metre, 0.0)
            if t_n < 0.0:
                s = t_s * n / t_n  # what shears before the faces touch does nothing
            else:
                s = 0.0
            iterations = 1
    elif t_n > 0.0:
        if t_n * t_n + (t_s * prm.per_beta) ** 2 > (T + near) ** 2:
            reach = 1.0 - damage
            whole = (t_n / (prm.normal * reach)) ** 2 + (t_s * prm.per_beta / (prm.shear * prm.per_weight * reach)) ** 2
            w += t_n / prm.normal_per_metre
            if whole >= 1.0:
                n, s, omega, work, iterations = 0.0, 0.0, 1.0, left, 1
            else:
                x, iterations = cohesive_jump(prm, t_n, t_s, T)
                omega = ti.min(damage + x, 1.0)
                after = prm.strength * (1.0 - omega)
                n = t_n * after / (after + prm.normal * x)
                s = t_s * after / (after + prm.shear * prm.per_weight * x)
                w -= n / prm.normal_per_metre
                work = 0.5 * (T + after) * x * prm.jump_over_length
    elif t_s + prm.friction * t_n > (T + near) * prm.beta:
        # Slip against cohesion, in closed form: x = Δκ/w_c
        excess = t_s + prm.friction * t_n - T * prm.beta
        x = excess / (prm.beta * (prm.shear * prm.per_weight - prm.strength))
        iterations = 1
        if damage + x >= 1.0:
            omega, w, work = 1.0, 0.0, left  # pressed faces touch
        else:
            omega = damage + x
            s = prm.beta * prm.strength * (1.0 - omega) - prm.friction * t_n
            work = 0.5 * (T + prm.strength * (1.0 - omega)) * x * prm.jump_over_length
            work -= prm.friction * t_n * x * prm.jump_over_length * prm.per_beta
    if omega >= 1.0 and n < 0.0 and s + prm.friction * n > near:
        slip = -prm.friction * n
        work += slip * (s - slip) / prm.shear_modulus
        s = slip
        iterations = ti.max(iterations, 1)
    return n, s, omega, w, work, iterations
