"""Sub-stepping of Cam-Clay: the flow equations along a step, by modified Euler with error control.

The step f = V R is followed as the rotation R, then the stretch V at a constant rate: the elastic strain goes from
ε_a = ½ ln(R b Rᵀ) along Δε = ε_trial − ε_a, which for a pure rotation is zero. With Y = w² + (1 + 2β) (6G²/M²) e:e − r²
(y / M², see `ellipse_at`), associated flow and consistency dY = 0 give

    γ = ⟨−2wK dε_v + 2c e:de⟩ / (4w²K + 2c m e:e + 2w ζ' [(1 − β) w + (1 + β) r] dp₀/dζ),   c = (1 + 2β) 6G²/M²
    de_e = de − γ m e,   m = (1 + 2β) 6G/M²;     dz = 2wγ (plastic compaction);     dζ = ζ' dz

The elastic part up to the surface is exact (Y is a quadratic along a straight path). A substep is accepted when the
difference between Euler's and the modified step is below the tolerance, in p and q, relative to p₀ (Sloan, Abbo & Sheng
2001, doi:10.1108/02644400110365842). What is left of the step where the equations turn stiff (p₀ almost gone, or a
denominator that is not positive: softening too steep for a unique answer), beyond MAX_SUBSTEPS, or of a step
longer than LONGEST_STEP, is left to the implicit return, at its first order.
"""

from snowmpm.compiler import ti

from .critical_state_return import ellipse_at
from .elastic import elastic_trial
from .hencky import deviation_of_strain, hencky_strain, trial_deviation
from .precision import by_precision
from .symmetric import PAIRS, contract

MAX_SUBSTEPS = 1000
FAINT = 0.02  # p₀ over that at the start, below which the implicit return takes over
LONGEST_STEP = 2.0  # strain of a step that is followed; of a longer one the start would be known too badly in float32
STEEP = 0.05  # least denominator, over that without hardening


@ti.func
def turned_start(h_trial, A):
    """h at the start of the step, turned by the rotation of f = I + A: V⁻¹ (f b fᵀ) V⁻¹ − I with V² = f fᵀ; and 1 where
    the step is not too large for that, 0 where round-off would be left of it."""
    _, deviator, volume, deviator2, valid = elastic_trial(0.0 * h_trial, A)
    inverse = deviation_of_strain(deviator, -0.5 * volume, deviator2, -0.5)
    B = A
    for k in ti.static(range(inverse.n)):
        i, j = ti.static(PAIRS[k])
        if ti.static(i < A.n and j < A.n):
            B[i, j] = inverse[k]
            B[j, i] = inverse[k]
    within = deviator2 + volume * volume / 3.0 < LONGEST_STEP * LONGEST_STEP
    return trial_deviation(h_trial, B), ti.select(within and valid == 1, 1, 0)


@ti.func
def flow(prm: ti.template(), deviator, volume, zeta, collapsed, d_deviator, d_volume):
    """Plastic flow over a strain: γ m, dz, dζ, plastic work, and 1 where the equations are well posed."""
    K, alpha = prm.K, prm.alpha
    deviator2 = contract(deviator, deviator)
    w, radius, _, beta, _, value = ellipse_at(prm, -K * volume, deviator2, zeta, collapsed, "")
    rate = ti.select(alpha > 0.0 and collapsed == 0.0, -alpha * ti.select(w > 0.0, 1.0, -1.0), 1.0)
    dp0 = prm.scale * prm.xi * ti.sqrt(prm.offset + value * value)
    c, m = (1.0 + 2.0 * beta) * prm.shear_square, (1.0 + 2.0 * beta) * 2.0 * prm.shear_stiffness
    load = 2.0 * (c * contract(deviator, d_deviator) - w * K * d_volume)
    ideal = 4.0 * w * w * K + 2.0 * c * m * deviator2
    stiffness = ideal + 2.0 * w * rate * ((1.0 - beta) * w + (1.0 + beta) * radius) * dp0
    tiny = ti.static(by_precision(1e-30, 1e-200))
    sound = stiffness > STEEP * ideal and ideal > tiny
    gamma = ti.select(sound, ti.max(load, 0.0) / ti.max(stiffness, tiny), 0.0)
    dz = 2.0 * w * gamma
    work = -K * volume * dz + 2.0 * prm.G * gamma * m * deviator2
    return gamma * m, dz, rate * dz, work, ti.select(sound, 1, 0)


@ti.func
def elastic_share(prm: ti.template(), deviator, volume, zeta, collapsed, d_deviator, d_volume):
    """Share of a straight path of strain up to the surface, from a state on it or inside to one outside."""
    K = prm.K
    w, radius, shear2, beta, _, _ = ellipse_at(prm, -K * volume, contract(deviator, deviator), zeta, collapsed, "")
    shape = 1.0 + 2.0 * beta
    c = shape * prm.shear_square
    a = (K * d_volume) ** 2 + c * contract(d_deviator, d_deviator)
    half_b = c * contract(deviator, d_deviator) - w * K * d_volume
    inside = ti.min(w * w + shape * shear2 - radius * radius, 0.0)
    root = ti.sqrt(half_b * half_b - a * inside)
    tiny = ti.static(by_precision(1e-30, 1e-200))
    # Of the two forms of the larger root, the one without cancellation
    share = ti.select(half_b > 0.0, -inside / ti.max(half_b + root, tiny), (root - half_b) / ti.max(a, tiny))
    return ti.max(0.0, ti.min(1.0, share))


@ti.func
def substeps(prm: ti.template(), h_trial, A, deviator_trial, volume_trial, zeta, collapsed):
    """Follow a step that yields: trial deviator, volume and ζ for the return map that ends it, plastic work, substeps.

    That return map only takes out the drift from the surface, and what was left to it.
    """
    K, tolerance = prm.K, prm.tolerance
    to_q = 2.0 * prm.G * ti.static(1.5**0.5)
    start, followed = turned_start(h_trial, A)
    deviator, volume, _, _ = hencky_strain(start)
    d_deviator, d_volume = deviator_trial - deviator, volume_trial - volume
    done = 1.0
    if followed == 1:
        done = elastic_share(prm, deviator, volume, zeta, collapsed, d_deviator, d_volume)
    deviator += done * d_deviator
    volume += done * d_volume
    p0_start = ellipse_at(prm, 0.0, 0.0, zeta, collapsed, "")[4]
    p0, work, n, sound = p0_start, 0.0, 0, 1
    size = 1.0 - done
    while done < 1.0 and sound == 1 and n < MAX_SUBSTEPS:
        n += 1
        size = ti.min(size, 1.0 - done)
        de, dv = size * d_deviator, size * d_volume
        m1, z1, k1, work1, sound1 = flow(prm, deviator, volume, zeta, collapsed, de, dv)
        ahead = deviator + de - m1 * deviator
        m2, z2, k2, work2, sound2 = flow(prm, ahead, volume + dv + z1, zeta + k1, collapsed, de, dv)
        difference = m2 * ahead - m1 * deviator
        error = 0.5 * ti.max(K * ti.abs(z2 - z1), to_q * ti.sqrt(contract(difference, difference)))
        allowed = tolerance * p0
        sound = sound1 * sound2
        if sound == 1 and error <= allowed:
            done += size
            deviator += de - m1 * deviator - 0.5 * difference
            volume += dv + 0.5 * (z1 + z2)
            zeta += 0.5 * (k1 + k2)
            work += 0.5 * (work1 + work2)
            p0 = ellipse_at(prm, 0.0, 0.0, zeta, collapsed, "")[4]
            sound = ti.select(p0 < FAINT * p0_start, 0, 1)
        size *= ti.max(0.2, ti.min(2.0, 0.8 * ti.sqrt(allowed / ti.max(error, 1e-3 * allowed))))
    rest = ti.max(0.0, 1.0 - done)
    return deviator + rest * d_deviator, volume + rest * d_volume, zeta, work, n
