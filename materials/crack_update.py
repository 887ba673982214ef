"""The update of elastic material with one crack, in closed form but for the jump of an opening crack."""

from snowmpm.compiler import ti

from .crack_planes import DAMAGE, NORMAL, OPENING, carried_along, normal_of, traction
from .crack_return import crack_return
from .elastic import elastic_trial
from .hencky import deviation_of_strain
from .precision import by_precision
from .spectral import eigen_of_deviator
from .symmetric import PAIRS, contract, plus_isotropic, trace


@ti.func
def cohesive_crack_update(prm: ti.template(), h, state, A, dt):
    """`Law.update` of `CohesiveCrack`."""
    h_new, deviator, volume, deviator2, valid = elastic_trial(h, A)
    G, K = prm.shear_modulus, prm.K
    tau = plus_isotropic(2.0 * G * deviator, K * volume)
    state_new = state
    dissipation, iterations, cracked = 0.0, 0, False
    n = ti.Vector.zero(float, 3)
    if valid == 1:
        cracked = state[NORMAL] + state[NORMAL + 1] + state[NORMAL + 2] > 0.5
        if cracked:
            n = carried_along(normal_of(state, NORMAL), A)
        elif K * volume + ti.static(2.0 * (2.0 / 3.0) ** 0.5) * G * ti.sqrt(deviator2) > prm.strength:
            # The first principal stress is at most −p + 2q/3
            w, V = eigen_of_deviator(deviator, deviator2)
            if K * volume + 2.0 * G * w[0] > prm.strength:
                cracked = True
                n = ti.Vector([V[0, 0], V[1, 0], V[2, 0]])
    if cracked:
        t = traction(tau, n)
        t_n = t.dot(n)
        along = t - t_n * n
        t_s = along.norm()
        along /= ti.max(t_s, ti.static(by_precision(1e-30, 1e-200)))
        n_new, s_new, damage, opening, dissipation, iterations = crack_return(
            prm, t_n, t_s, state[DAMAGE], state[OPENING]
        )
        if iterations != 0:
            opened, slipped = (t_n - n_new) / (K + ti.static(4.0 / 3.0) * G), (t_s - s_new) / G
            strain = deviator
            for k in ti.static(range(h.n)):
                i, j = ti.static(PAIRS[k])
                strain[k] -= opened * n[i] * n[j] + 0.5 * slipped * (n[i] * along[j] + along[i] * n[j])
            deviator = plus_isotropic(strain, -trace(strain) / 3.0)
            volume -= opened
            tau = plus_isotropic(2.0 * G * deviator, K * volume)
            h_new = deviation_of_strain(deviator, volume, contract(deviator, deviator), 1.0)
            state_new[DAMAGE], state_new[OPENING] = damage, opening
        for k in ti.static(range(6)):
            i, j = ti.static(PAIRS[k])
            state_new[NORMAL + k] = n[i] * n[j]
    return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, -1)
