"""The update of cracks that are more than one, that heal into new particles, or that lie in material that yields.

Where the material yields, its stress for the strain that the jumps leave, τ = law(ε_trial − Σ sym(n ⊗ u)/H), is the
elastic one less what it relaxed, δ = τ − D : (ε_trial − Σ sym(n ⊗ u)/H). For a given δ the jumps are those of elastic
material; δ is found by iterations, each with one update of the law, accelerated by the last two changes (Anderson
1965, doi:10.1145/321296.321305). Many steps have a shorter way: the material yields and no crack moves, or a crack
opens and the material unloads; both are looked at first, in this order.
"""

import functools

import taichi as ti

from .crack_planes import (
    DAMAGE,
    NORMAL,
    OPENING,
    PER_CRACK,
    carried_along,
    elastic_stress,
    jump_strain,
    normal_of,
    traction,
)
from .crack_solve import crack_solver, row
from .elastic import elastic_trial
from .hencky import deviation_of_strain
from .precision import by_precision
from .spectral import eigen_of_deviator
from .symmetric import PAIRS, contract, plus_isotropic, trace

MOST = 25
"""Updates of the surrounding law in a step."""
LONGER = 9.0
"""Most that a change is lengthened by."""


@ti.func
def first_plane(tau, strength):
    """1 where the first principal stress is more than the strength [Pa], else 0, and its direction."""
    found, n = 0, ti.Vector.zero(float, 3)
    mean = trace(tau) / 3.0
    deviator = plus_isotropic(tau, -mean)
    square = contract(deviator, deviator)
    if mean + ti.static((2.0 / 3.0) ** 0.5) * ti.sqrt(square) > strength:
        w, V = eigen_of_deviator(deviator, square)
        if mean + w[0] > strength:
            found = 1
            n = ti.Vector([V[0, 0], V[1, 0], V[2, 0]])
    return found, n


@ti.func
def plane_across(tau, n, strength):
    """The same of the stress within a plane of normal n: 1 where it is more than the strength, and its direction."""
    axis = ti.Vector([0.0, 0.0, 1.0])
    if ti.abs(n[0]) < ti.min(ti.abs(n[1]), ti.abs(n[2])):
        axis = ti.Vector([1.0, 0.0, 0.0])
    elif ti.abs(n[1]) < ti.abs(n[2]):
        axis = ti.Vector([0.0, 1.0, 0.0])
    a = n.cross(axis).normalized()
    b = n.cross(a)
    aa, ab, bb = a.dot(traction(tau, a)), a.dot(traction(tau, b)), b.dot(traction(tau, b))
    half, mean = 0.5 * (aa - bb), 0.5 * (aa + bb)
    radius = ti.sqrt(half * half + ab * ab)
    # Twice the angle of the direction from a: (half, ab)/radius
    along = ti.sqrt(ti.max(0.5 * (radius + half), 0.0))
    across = ti.sqrt(ti.max(0.5 * (radius - half), 0.0)) * ti.select(ab < 0.0, -1.0, 1.0)
    m = a
    if radius > 0.0:
        m = (along * a + across * b).normalized()
    return ti.select(mean + radius > strength, 1, 0), m


@ti.func
def shares(error, change, older):
    """How much of the last change and of the one before to take back, so that least is left of the error: Anderson's
    acceleration of depth two. All are stresses.

    At an apex the stress hangs on no strain, and δ goes on by equal steps: then much longer ones.
    """
    aa, bb, ab = contract(change, change), contract(older, older), contract(change, older)
    a, b, size = contract(error, change), contract(error, older), contract(error, error)
    share, older_share = -LONGER, 0.0
    if aa > 1e-4 * size:
        det = aa * bb - ab * ab
        if det > ti.static(by_precision(1e-3, 1e-8)) * aa * bb:
            share, older_share = (a * bb - b * ab) / det, (b * aa - a * ab) / det
        else:
            share = a / aa
        share = ti.min(ti.max(share, -LONGER), LONGER)
        older_share = ti.min(ti.max(older_share, -LONGER), LONGER)
    return share, older_share


@functools.cache
def crack_set_update(most, resets, bulk, names, n_bulk):
    """Update function (see `Law`) of up to `most` cracks.

    resets: cracks without cohesion make way for new ones. bulk: update function of the surrounding law, None for
    elastic material; names: class of its numbers; n_bulk: its state variables. state: PER_CRACK numbers a crack, how
    often a crack made way (only if `resets`), then the state of the surrounding law.
    """
    solve, wrapped = crack_solver(most), bulk is not None
    counter = most * PER_CRACK
    first, width = (counter + (1 if resets else 0), n_bulk) if n_bulk else (0, 1)  # there is no empty vector

    def numbers_of_bulk(prm):
        return names(**{name: getattr(prm, f"bulk_{name}") for name in names._fields})

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, volume, _, valid = elastic_trial(h, A)
        trial = plus_isotropic(deviator, volume / 3.0)
        tau_trial = elastic_stress(prm, trial)
        scale = ti.sqrt(tau_trial.norm_sqr()) + prm.strength
        M = prm.K + ti.static(4.0 / 3.0) * prm.shear_modulus
        start, begun = state, 0
        planes, jumps, numbers = (ti.Matrix.zero(float, most, 3), ti.Matrix.zero(float, most, 3),
                                  ti.Matrix.zero(float, most, 2))
        for c in ti.static(range(most)):
            at = ti.static(c * PER_CRACK)
            if state[at + NORMAL] + state[at + NORMAL + 1] + state[at + NORMAL + 2] > 0.5:
                n = normal_of(state, ti.static(at + NORMAL))
                if valid == 1:
                    n = carried_along(n, A)
                begun += 1
                for i in ti.static(range(3)):
                    planes[c, i] = n[i]
        if ti.static(resets):  # noqa: SIM102 (one is compile time)
            if valid == 1 and begun == 1 and state[DAMAGE] >= 1.0:
                begun = 0
                for k in ti.static(range(PER_CRACK)):
                    start[k] = 0.0
                start[counter] += 1.0
        for c in ti.static(range(most)):
            numbers[c, 0], numbers[c, 1] = start[ti.static(c * PER_CRACK)], start[ti.static(c * PER_CRACK + 1)]
        weaker = 0
        if ti.static(most > 1):  # noqa: SIM102 (one is compile time)
            if begun > 1 and start[ti.static(PER_CRACK + DAMAGE)] > start[DAMAGE]:
                weaker = 1
        inner = ti.Vector([start[ti.static(first + k)] for k in ti.static(range(width))])
        inner_new = inner
        strain, tau, h_start = trial, tau_trial, h_new
        lag, before, off_before = 0.0 * trial, 0.0 * trial, 0.0 * trial  # δ, what the last one led to, its error
        older, older_step = 0.0 * trial, 0.0 * trial
        crack_work, bulk_work, count, tries, bulk_count, moved, going = 0.0, 0.0, 0, 0, 0, 0, 1
        while going == 1:
            # The material around the cracks
            relaxed, noise = 0.0 * trial, 0.0
            tau = elastic_stress(prm, strain)
            if ti.static(wrapped):
                own = ti.static(numbers_of_bulk(prm))
                h_new, found, inner_new, bulk_work, bulk_count = bulk(own, h_start, inner, 0.0 * A, dt)
                relaxed = found - tau
                # Its strain is read anew from h, whose eigenvalues spread by exp(2√2 |ε|)
                spread = ti.exp(ti.static(8.0**0.5) * ti.sqrt(contract(strain, strain))) - 1.0
                noise = ti.static(by_precision(1e-6, 1e-15)) * (M * spread + scale)
                if relaxed.norm_sqr() <= noise * noise:
                    relaxed = 0.0 * trial
                else:
                    tau = found
            off = relaxed - lag
            agree = off.norm() <= ti.static(by_precision(4e-6, 5e-13)) * scale + 2.0 * noise
            settled = count > 0 and agree
            # New cracks, where the stress is one that may stay
            added = 0
            if valid == 1 and moved >= 0 and (settled or (count == 0 and begun == 0)):
                n = ti.Vector.zero(float, 3)
                if begun == 0:
                    added, n = first_plane(tau, prm.strength)
                elif ti.static(most > 1):  # noqa: SIM102
                    if begun == 1:
                        added, n = plane_across(tau, row(planes, 0), prm.strength)
                if added == 1:
                    for c in ti.static(range(most)):
                        if c == begun:
                            for i in ti.static(range(3)):
                                planes[c, i] = n[i]
                    begun += 1
            if valid == 0 or begun == 0 or (settled and added == 0) or moved < 0 or count >= MOST:
                going = 0
                if valid == 1 and begun > 0 and not settled:
                    moved = -1
            else:
                target = relaxed
                if added == 1:
                    tries = 0
                elif count > 0:
                    tries += 1
                    change, step = off - off_before, relaxed - before
                    if tries > 1:
                        if tries == 2 or contract(off, off) > 1e-4 * contract(relaxed, relaxed):
                            older, older_step = 0.0 * trial, 0.0 * trial  # far from the end the last one misleads less
                        share, older_share = shares(off, change, older)
                        target = relaxed - share * step - older_share * older_step
                    older, older_step = change, step
                    before, off_before = relaxed, off
                attempt, alone = 0, False
                while attempt < 3:
                    attempt += 1
                    jumps, numbers, crack_work, moved = solve(prm, tau_trial + target, start, planes, begun, weaker)
                    if count > 0 or relaxed.norm_sqr() == 0.0 or (attempt == 1 and moved == 0):
                        alone = count == 0 and moved == 0
                        attempt = 3
                    elif attempt == 1:
                        target = 0.0 * trial  # a crack moves: it goes first
                    elif attempt == 2 and moved == 0:
                        target = relaxed  # it moves for what the material relaxed
                    else:
                        attempt = 3
                lag = target
                count += 1
                if alone and (begun == most or ti.static(most == 1)):
                    going = 0  # what was found of the material stands
                else:
                    strain = trial
                    for c in ti.static(range(most)):
                        if c < begun:
                            strain -= jump_strain(trial, row(planes, c), row(jumps, c))
                    swell = trace(strain)
                    part = plus_isotropic(strain, -swell / 3.0)
                    h_start = deviation_of_strain(part, swell, contract(part, part), 1.0)
                    h_new = h_start
        state_new, work, iterations = state, 0.0, -1
        if valid == 0:
            h_new = h
        else:
            state_new = start
            work = bulk_work + crack_work
            iterations = ti.select(moved < 0 or bulk_count < 0, -1, ti.max(bulk_count, ti.select(moved > 0, count, 0)))
            for c in ti.static(range(most)):
                if c < begun:
                    at = ti.static(c * PER_CRACK)
                    state_new[at + DAMAGE], state_new[at + OPENING] = numbers[c, 0], numbers[c, 1]
                    for k in ti.static(range(6)):
                        i, j = ti.static(PAIRS[k])
                        state_new[at + NORMAL + k] = planes[c, i] * planes[c, j]
            for k in ti.static(range(n_bulk)):
                state_new[first + k] = inner_new[k]
        return h_new, tau, state_new, work, iterations

    return update
