"""The jumps at which cracks and the material around them bear the same: Newton's method, and a way off its plateaus.

Unknown are the jumps w = u/H of all cracks, three numbers each. The material bears t = n · law(ε_trial − Σ sym(n ⊗ w)),
and a crack R(t + Q w), its answer (crack_return.py) to the traction from which w unloads elastic material, with
Q = G I + (M − G) n ⊗ n. Wanted are the jumps without a residual

    g(w) = t(w) − R(t(w) + Q w)

Looked at first: no crack moves, w = 0; the material does not yield where the cracks are as in an elastic one
(crack_solve.py). Else Newton's method with numerical slopes of the law, and shorter steps until |g| falls. At the apex
of a cone the law has no slope: the stress is the same at every jump until the material has stopped swelling. Where no
shorter step helps it begins again, at jumps that leave the material no swelling, beyond that plateau: after those that
take all strain across and along the cracks, then after those of elastic material.
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti

from .crack_planes import DAMAGE, OPENING, PER_CRACK, elastic_stress, jump_strain, traction
from .crack_return import crack_return
from .crack_solve import crack_solver, row
from .hencky import deviation_of_strain
from .linear_equations import solve_equations
from .precision import by_precision
from .symmetric import contract, plus_isotropic, trace

MOST = 25
"""Steps of Newton's method from each start; three are usual."""
SHORTEST = 2e-3
"""Of a step, over the whole one."""
AT_REST, ELASTIC, STEP, SLOPE, AGAIN = 0, 1, 2, 3, 4
"""What the next update of the law is for: no jump; the jumps in elastic material; a step or a new start of Newton's
method; a column of the slopes; the last jumps once more, whose results are to be kept."""


class Trial(NamedTuple):
    """Without a jump in this step: Hencky strain, its h, its elastic stress."""

    strain: ti.Matrix
    h: ti.Matrix
    stress: ti.Matrix


class Cracks(NamedTuple):
    """Planes (most, 3) of the first `begun` cracks, with what they are at the start of the step in `state`; weaker: the
    crack to begin with."""

    state: ti.Matrix
    planes: ti.Matrix
    begun: int
    weaker: int


@functools.cache
def crack_balance(most, bulk, names):
    """Taichi function of up to `most` cracks in a law; arguments as of `crack_set.crack_set_update`.

        balance(prm, trial, inner, cracks, A, dt) -> numbers, h, tau, driven, inner, work, iterations, moved

    trial: `Trial`; inner: state of the law; cracks: `Cracks`.
    numbers (most, 2): damage, opening; driven: stress of elastic material at these jumps, which has the principal axes
    of tau where that has none, as at the apex of a cone; moved: 0 where all cracks hold, −1 where no balance was found.
    """
    solve, wrapped, n = crack_solver(most), bulk is not None, 3 * most
    equations = solve_equations(n)

    def numbers_of_bulk(prm):
        own = prm._asdict()
        return names(**{name: own[f"bulk_{name}"] for name in names._fields})

    @ti.func
    def free_traction(prm: ti.template(), t, w, normal):
        """t + Q w of a crack."""
        M = prm.K + ti.static(4.0 / 3.0) * prm.shear_modulus
        return t + prm.shear_modulus * w + (M - prm.shear_modulus) * w.dot(normal) * normal

    @ti.func
    def without_swelling(trial, planes, begun, w):
        """Jumps w, opened further until they leave the material no swelling."""
        result, swell = w, trace(trial)
        for c in ti.static(range(most)):
            swell -= row(w, c).dot(row(planes, c))
        if swell > 0.0:
            for c in ti.static(range(most)):
                for i in ti.static(range(3)):
                    result[c, i] += swell / begun * planes[c, i]
        return result

    @ti.func
    def without_strain_of_planes(trial, planes):
        """Jumps that leave none of the strain across and along the cracks: 2 ε n − (n · ε n) n, one after the other."""
        w, strain = ti.Matrix.zero(float, most, 3), trial
        for c in ti.static(range(most)):
            normal = row(planes, c)
            across = traction(strain, normal)
            jump = 2.0 * across - across.dot(normal) * normal
            strain -= jump_strain(trial, normal, jump)
            for i in ti.static(range(3)):
                w[c, i] = jump[i]
        return w

    @ti.func
    def balance(prm: ti.template(), trial: ti.template(), inner, cracks: ti.template(), A, dt):
        M = prm.K + ti.static(4.0 / 3.0) * prm.shear_modulus
        scale = ti.sqrt(trial.stress.norm_sqr()) + prm.strength
        none = ti.Matrix.zero(float, most, 3)
        w, tried, elastic, step, share = none, none, none, none, 1.0
        borne, residual, norm = none, none, -1.0  # at w; −1: no jumps are known yet
        slopes, column, slope_step = ti.Matrix.zero(float, n, n), 0, 0.0
        h, tau, driven, inner_new = trial.h, trial.stress, trial.stress, inner
        numbers, works, counts = ti.Matrix.zero(float, most, 2), ti.Vector.zero(float, most), ti.Vector.zero(int, most)
        work, total, bulk_count, iterations, starts, moved, aim, going = 0.0, 0.0, 0, 0, 0, 0, AT_REST, 1
        while going == 1:
            # The material around the cracks
            strain, h_start = trial.strain, trial.h
            if aim != AT_REST:
                for c in ti.static(range(most)):
                    if c < cracks.begun:
                        strain -= jump_strain(trial.strain, row(cracks.planes, c), row(tried, c))
                swell = trace(strain)
                part = plus_isotropic(strain, -swell / 3.0)
                h_start = deviation_of_strain(part, swell, contract(part, part), 1.0)
            driven = elastic_stress(prm, strain)
            h, tau, yields = h_start, driven, 0
            # Its strain is read anew from h, whose eigenvalues spread by exp(2√2 |ε|)
            spread = ti.exp(ti.static(8.0**0.5) * ti.sqrt(contract(strain, strain))) - 1.0
            noise = ti.static(by_precision(1e-6, 1e-15)) * (M * spread + scale)
            if ti.static(wrapped):
                own = ti.static(numbers_of_bulk(prm))
                h, found, inner_new, work, bulk_count = bulk(own, h_start, inner, 0.0 * A, dt)
                if bulk_count > 0 or (found - tau).norm_sqr() > noise * noise:
                    tau, yields = found, 1
            # The answers of the cracks there, and for a step of Newton's method how they change
            at, t_at, probes = tried, none, 1
            for c in ti.static(range(most)):
                t = traction(tau, row(cracks.planes, c))
                for i in ti.static(range(3)):
                    t_at[c, i] = t[i]
            if aim == SLOPE:
                for c in ti.static(range(most)):
                    for i in ti.static(range(3)):
                        slopes[3 * c + i, column] = (t_at[c, i] - borne[c, i]) / slope_step
                column += 1
                at, t_at, probes = w, borne, ti.select(column < 3 * cracks.begun, 0, 4)
            answers, changes = none, ti.Matrix.zero(float, n, 3)
            for own in range(ti.select(probes > 0, cracks.begun, 0)):
                normal, free, omega, opened = ti.Vector.zero(float, 3), ti.Vector.zero(float, 3), 0.0, 0.0
                for c in ti.static(range(most)):
                    if own == c:
                        normal = row(cracks.planes, c)
                        free = free_traction(prm, row(t_at, c), row(at, c), normal)
                        omega = cracks.state[ti.static(c * PER_CRACK + DAMAGE)]
                        opened = cracks.state[ti.static(c * PER_CRACK + OPENING)]
                push = ti.static(by_precision(1e-3, 1e-7)) * (free.norm() + prm.strength)
                first = ti.Vector.zero(float, 3)
                for probe in range(probes):
                    z = free
                    for i in ti.static(range(3)):
                        if probe == i + 1:
                            z[i] += push
                    t_n = z.dot(normal)
                    along = z - t_n * normal
                    t_s = along.norm()
                    along /= ti.max(t_s, ti.static(by_precision(1e-30, 1e-200)))
                    n_new, s_new, omega_new, opened_new, dissipated, count = crack_return(prm, t_n, t_s, omega, opened)
                    answer = n_new * normal + s_new * along
                    if probe == 0:
                        first = answer
                    for c in ti.static(range(most)):
                        if own == c:
                            for i in ti.static(range(3)):
                                if probe == 0:
                                    answers[c, i] = answer[i]
                                else:
                                    changes[3 * c + i, probe - 1] = (answer[i] - first[i]) / push
                            if probe == 0:
                                numbers[c, 0], numbers[c, 1] = omega_new, opened_new
                                works[c], counts[c] = dissipated, count
            # What to do next
            off = t_at - answers
            size, near = off.norm(), 2.0 * noise * yields
            near += ti.static(by_precision(1e-6, 1e-14)) * (M * at.norm() + t_at.norm() + prm.strength)
            begin_anew = 0
            # At too large a strain round-off hides the answer; single precision takes every answer
            known = bulk_count >= 0 and noise < ti.static(by_precision(1e9, 1e-3 if wrapped else 1e200)) * scale
            if cracks.begun == 0:
                going = 0
            elif aim == SLOPE:
                if column < 3 * cracks.begun:
                    tried = w
                else:
                    # (T − R' (T + Q)) dw = −g
                    matrix, right = ti.Matrix.identity(float, n), ti.Vector.zero(float, n)
                    for i in range(3 * cracks.begun):
                        right[i] = -residual[i // 3, i % 3]
                        for j in range(3 * cracks.begun):
                            entry = slopes[i, j]
                            for k in range(3):
                                stiff = slopes[i - i % 3 + k, j]
                                if j // 3 == i // 3:
                                    along = cracks.planes[i // 3, k] * cracks.planes[i // 3, j % 3]
                                    stiff += (M - prm.shear_modulus) * along
                                    if k == j % 3:
                                        stiff += prm.shear_modulus
                                entry -= changes[i, k] * stiff
                            if i == j:
                                entry -= ti.static(by_precision(1e-5, 1e-9)) * prm.shear_modulus
                            matrix[i, j] = entry
                    found_step = equations(matrix, right)
                    for c in ti.static(range(most)):
                        for i in ti.static(range(3)):
                            step[c, i] = found_step[3 * c + i]
                    # On a plateau it has no length of its own
                    longest = ti.sqrt(contract(trial.strain, trial.strain)) + w.norm()
                    step *= ti.min(1.0, longest / ti.max(step.norm(), ti.static(by_precision(1e-30, 1e-200))))
                    share, aim = 1.0, STEP
                    tried = w + step
            elif known and (size <= near or aim == AGAIN or (aim == ELASTIC and yields == 0 and moved >= 0)):
                going = 0
                moved = 0
                for c in ti.static(range(most)):
                    if c < cracks.begun and counts[c] != 0:
                        moved = ti.select(moved == -1 or counts[c] < 0, -1, 1)
            elif aim == AT_REST:
                elastic, numbers, total, moved = solve(prm, trial.stress, cracks.state, cracks.planes, cracks.begun,
                                                       cracks.weaker)
                tried, aim = elastic, ELASTIC
            elif norm < 0.0 and not known:
                begin_anew = 1
            elif known and (norm < 0.0 or size < (1.0 - 1e-4 * share) * norm):
                w, borne, residual, norm = at, t_at, off, size
                iterations += 1
                slope_step = ti.sqrt(noise / M)
                tried, column, aim = w, 0, SLOPE
                if iterations > MOST:
                    begin_anew = 1
            else:
                share *= 0.5
                tried = w + share * step
                if share < SHORTEST:
                    begin_anew = 1
                    if norm <= 10.0 * near:
                        tried, aim, begin_anew = w, AGAIN, 0
            if aim == SLOPE and going == 1:
                for c in ti.static(range(most)):
                    for i in ti.static(range(3)):
                        if 3 * c + i == column:
                            tried[c, i] += slope_step
            if begin_anew == 1:
                starts += 1
                iterations, norm, aim = 0, -1.0, STEP
                if starts == 1:
                    tried = without_swelling(trial.strain, cracks.planes, cracks.begun,
                                             without_strain_of_planes(trial.strain, cracks.planes))
                elif starts == 2:
                    tried = without_swelling(trial.strain, cracks.planes, cracks.begun, elastic)
                else:
                    going, moved = 0, -1
        total = work
        for c in ti.static(range(most)):
            if c < cracks.begun:
                total += works[c]
        if bulk_count < 0:
            moved = -1
        if moved > 0:
            iterations = ti.max(iterations, 1)
        return numbers, h, tau, driven, inner_new, total, ti.max(bulk_count, iterations), moved

    return balance
