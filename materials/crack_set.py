"""The update of cracks that are more than one, that heal into new particles, or that lie in material that yields.

The cracks that are there and the material around them come to bear the same (crack_balance.py). Where that stress is
more than may stay, a new crack begins, and they do so anew.
"""

import functools

from snowmpm.compiler import ti

from .crack_balance import Cracks, Trial, crack_balance
from .crack_planes import DAMAGE, NORMAL, OPENING, PER_CRACK, carried_along, elastic_stress, normal_of, traction
from .crack_solve import row
from .elastic import elastic_trial
from .hencky import hencky_strain
from .spectral import eigen_of_deviator
from .symmetric import PAIRS, contract, plus_isotropic, trace


@ti.func
def first_plane(tau, driven, strength):
    """1 where the first principal stress is more than the strength [Pa], else 0, and its direction.

    driven: a stress of the same axes, in the same order, that has them where tau is the same in all directions.
    """
    found, n = 0, ti.Vector.zero(float, 3)
    mean = trace(tau) / 3.0
    deviator = plus_isotropic(tau, -mean)
    square = contract(deviator, deviator)
    if mean + ti.static((2.0 / 3.0) ** 0.5) * ti.sqrt(square) > strength:
        axes = plus_isotropic(driven, -trace(driven) / 3.0)
        V = eigen_of_deviator(axes, contract(axes, axes))[1]
        first = ti.Vector([V[0, 0], V[1, 0], V[2, 0]])
        if first.dot(traction(tau, first)) > strength:
            found, n = 1, first
    return found, n


@ti.func
def plane_across(tau, driven, n, strength):
    """The same of the stress within a plane of normal n: 1 where it is more than the strength, and its direction."""
    axis = ti.Vector([0.0, 0.0, 1.0])
    if ti.abs(n[0]) < ti.min(ti.abs(n[1]), ti.abs(n[2])):
        axis = ti.Vector([1.0, 0.0, 0.0])
    elif ti.abs(n[1]) < ti.abs(n[2]):
        axis = ti.Vector([0.0, 1.0, 0.0])
    a = n.cross(axis).normalized()
    b = n.cross(a)
    aa, ab, bb = a.dot(traction(driven, a)), a.dot(traction(driven, b)), b.dot(traction(driven, b))
    half = 0.5 * (aa - bb)
    radius = ti.sqrt(half * half + ab * ab)
    # Twice the angle of the direction from a: (half, ab)/radius
    along = ti.sqrt(ti.max(0.5 * (radius + half), 0.0))
    across = ti.sqrt(ti.max(0.5 * (radius - half), 0.0)) * ti.select(ab < 0.0, -1.0, 1.0)
    m = a
    if radius > 0.0:
        m = (along * a + across * b).normalized()
    return ti.select(m.dot(traction(tau, m)) > strength, 1, 0), m


@functools.cache
def crack_set_update(most, resets, bulk, names, n_bulk):
    """Update function (see `Law`) of up to `most` cracks.

    resets: cracks without cohesion make way for new ones. bulk: update function of the surrounding law, None for
    elastic material; names: class of its numbers; n_bulk: its state variables. state: PER_CRACK numbers a crack, how
    often a crack made way (only if `resets`), then the state of the surrounding law.
    """
    balance, counter = crack_balance(most, bulk, names), most * PER_CRACK
    first, width = (counter + (1 if resets else 0), n_bulk) if n_bulk else (0, 1)  # there is no empty vector

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_trial, deviator, volume, _, valid = elastic_trial(h, A)
        trial, h_new = plus_isotropic(deviator, volume / 3.0), h_trial
        tau_trial = elastic_stress(prm, trial)
        start, begun = state, 0
        planes, numbers = ti.Matrix.zero(float, most, 3), ti.Matrix.zero(float, most, 2)
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
        weaker = 0
        if ti.static(most > 1):  # noqa: SIM102 (one is compile time)
            if begun > 1 and start[ti.static(PER_CRACK + DAMAGE)] > start[DAMAGE]:
                weaker = 1
        inner = ti.Vector([start[ti.static(first + k)] for k in ti.static(range(width))])
        inner_new, tau, work, iterations, going = inner, tau_trial, 0.0, -1, 1
        if valid == 0:
            begun = 0  # the material alone says what stress there was
        while going == 1:
            going = 0
            without, cracks = ti.static(Trial(trial, h_trial, tau_trial), Cracks(start, planes, begun, weaker))
            numbers, h_new, tau, driven, inner_new, work, iterations, moved = balance(
                prm, without, inner, cracks, A, dt)
            if valid == 1 and moved == -1:
                # Left out: once more for the stress that there was
                valid, begun, going = 0, 0, 1
                deviator, volume, _, _ = hencky_strain(h)
                trial, h_trial = plus_isotropic(deviator, volume / 3.0), h
                tau_trial = elastic_stress(prm, trial)
            elif valid == 0:
                iterations, work = -1, 0.0
            else:
                n = ti.Vector.zero(float, 3)
                if begun == 0:
                    going, n = first_plane(tau, driven, prm.strength)
                elif ti.static(most > 1):  # noqa: SIM102
                    if begun == 1:
                        going, n = plane_across(tau, driven, row(planes, 0), prm.strength)
                if going == 1:
                    for c in ti.static(range(most)):
                        if c == begun:
                            for i in ti.static(range(3)):
                                planes[c, i] = n[i]
                    begun += 1
        state_new = state
        if iterations < 0:
            h_new = h
        else:
            state_new = start
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
