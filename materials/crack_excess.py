"""By how much a stress is beyond what cracked material bears."""

import numpy as np

from .arrays import Array
from .crack_planes import DAMAGE, NORMAL, OPENING, PER_CRACK
from .symmetric import unpack


def crack_excess(law, stress: Array, state: Array) -> Array:
    """Yield function [Pa] of the cracks of a `CohesiveCrack` for Kirchhoff stresses (..., 3, 3) [Pa] and its states.

    Where a crack may still begin, the largest principal stress less f_t (of a second one within the plane of the
    first); of a crack, its traction beyond its strength, |t| of an open one without cohesion. The largest of these.
    """
    friction, found = np.tan(np.radians(law.friction_angle)), np.full(stress.shape[:-2], -np.inf)
    there, across = np.zeros(stress.shape[:-2], int), stress
    for c in range(law.cracks):
        own = state[..., PER_CRACK * c : PER_CRACK * (c + 1)]
        values, vectors = np.linalg.eigh(unpack(own[..., NORMAL : NORMAL + 6]))
        has, n = values[..., -1] >= 0.5, vectors[..., -1]
        t = np.einsum("...ij,...j->...i", stress, n)
        t_n = np.einsum("...i,...i->...", t, n)
        t_s = np.linalg.norm(t - t_n[..., None] * n, axis=-1)
        left = law.strength * (1.0 - own[..., DAMAGE])
        pressed = (t_s + friction * t_n) / law.shear_ratio - left
        closed = np.where(t_n > 0.0, np.hypot(t_n, t_s / law.shear_ratio) - left, pressed)
        apart = (own[..., DAMAGE] >= 1.0) & (own[..., OPENING] > 0.0)
        beyond = np.where(apart, np.abs(t_n) + t_s, closed)
        found = np.where(has, np.maximum(found, beyond), found)
        if c == 0 and law.cracks > 1:
            inside = np.eye(3) - np.where(has[..., None, None], n[..., :, None] * n[..., None, :], 0.0)
            across = inside @ stress @ inside
        there = there + has
    intact = np.linalg.eigvalsh(across)[..., -1] - law.strength
    return np.where(there < law.cracks, np.maximum(found, intact), found)
