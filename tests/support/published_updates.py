"""The update of frictional plasticity in rate form, as published: for comparison with the return map on Hencky strains.

[B] Bui and Nguyen (2021), doi:10.1016/j.compgeo.2021.104315, section 3.2.2. Cauchy stress σ, tension positive;
stretching D and spin W of a velocity gradient; hypoelastic, with Jaumann's rate [B 83-84]:

    dσ/dt = C : (D − D^p) + W σ − σ W          (the printed 83 and 84 contradict each other in the sign of the spin)

Algorithm 1: D^ep where f(σ_n) >= 0, else C; explicit. Algorithm 2 [B 85-87]: an elastic trial with its rotation, then
one plastic correction with the gradients at the trial. Both for `DruckerPrager` without softening: f = q − α p − k.
"""

import numpy as np

EYE = np.eye(3)


def invariants(sigma):
    """p, q [Pa] and the deviator s (3, 3) of a stress."""
    p = -np.trace(sigma) / 3.0
    s = sigma + p * EYE
    return p, np.sqrt(1.5 * (s * s).sum()), s


def elastic(law, D):
    """C : D."""
    return law.bulk_modulus * np.trace(D) * EYE + 2.0 * law.shear_modulus * (D - np.trace(D) / 3.0 * EYE)


def excess(law, sigma):
    """Yield function f [Pa]: above 0 is not admissible."""
    p, q, _ = invariants(sigma)
    return q - law.alpha * p - law.k


def gradients(law, sigma):
    """f_σ and g_σ."""
    _, q, s = invariants(sigma)
    shear = 1.5 * s / max(q, 1e-300)
    return shear + law.alpha / 3.0 * EYE, shear + law.alpha_psi / 3.0 * EYE


def algorithm_1(law, sigma, D, W, dt):
    """σ after a step: explicit, with the elastoplastic stiffness where σ has reached the surface and is loaded."""
    rate = elastic(law, D)
    if excess(law, sigma) >= 0.0:
        f, g = gradients(law, sigma)
        loading = (f * rate).sum()
        if loading > 0.0:
            rate = rate - loading / (f * elastic(law, g)).sum() * elastic(law, g)
    return sigma + dt * (rate + W @ sigma - sigma @ W)


def algorithm_2(law, sigma, D, W, dt):
    """σ after a step: elastic trial, and one correction with the gradients there."""
    trial = sigma + dt * (elastic(law, D) + W @ sigma - sigma @ W)
    over = excess(law, trial)
    if over < 0.0:
        return trial
    f, g = gradients(law, trial)
    return trial - over / (f * elastic(law, g)).sum() * elastic(law, g)


def follow(algorithm, law, sigma, L, steps, time=1.0):
    """σ (steps, 3, 3) along a constant velocity gradient L [1/s]."""
    D, W, path = 0.5 * (L + L.T), 0.5 * (L - L.T), []
    for _ in range(steps):
        sigma = algorithm(law, sigma, D, W, time / steps)
        path.append(sigma)
    return np.array(path)
