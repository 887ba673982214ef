"""Parameter sets of the reference cases, and deformation paths to drive them along.

A, B, C: slabs of Li et al. (2021) and a soft one; W1-W3: weak layers. SI units.
"""

import numpy as np

from snowmpm.compiler import ti
from snowmpm.materials import AnticrackCamClay, CohesiveCamClay, ModifiedCamClay
from snowmpm.materials.parameters import named
from snowmpm.materials.precision import working_precision

COMMON = {"density": 250.0, "poisson_ratio": 0.3}
A = CohesiveCamClay(**COMMON, youngs_modulus=3e6, critical_slope=1.5, cohesion=0.3, hardening=1.0, p0=30e3)
B = ModifiedCamClay(**COMMON, youngs_modulus=3e6, critical_slope=0.5, hardening=1.0, p0=3e3)
C = CohesiveCamClay(**COMMON, youngs_modulus=1e6, critical_slope=1.2, cohesion=0.3, hardening=0.1, p0=20e3)
SETS = {"A": A, "B": B, "C": C}


def _weak_layer(xi, p0, alpha):
    return AnticrackCamClay(
        density=100.0,
        youngs_modulus=0.5e6,
        poisson_ratio=0.3,
        critical_slope=1.0,
        cohesion=0.3,
        hardening=xi,
        p0=p0,
        softening=alpha,
    )


W1, W2, W3 = _weak_layer(0.1, 3e3, 0.25), _weak_layer(1.0, 3e3, 0.5), _weak_layer(0.5, 1.8e3, 0.5)


def changed(law, **values):
    """The same law with other parameters, checked again."""
    return type(law)(**{**law.model_dump(), **values})


def isotropic(x):
    """F with ln J = −x in equal parts."""
    return np.exp(-np.asarray(x, float) / 3.0)[:, None, None] * np.eye(3)


def diagonal(*logarithmic):
    """F = diag(exp(...)) from three arrays of logarithmic stretches."""
    stretches = np.stack(np.broadcast_arrays(*logarithmic), axis=-1)
    return np.exp(stretches)[..., None] * np.eye(3)


def oedometer(x):
    """Compression x = −ln J along the first axis alone."""
    return diagonal(-np.asarray(x, float), 0.0, 0.0)


def undrained(law, p_start, shear):
    """Isotropic compression to p_start, then triaxial shear at constant volume, ε_s = shear."""
    volume = -p_start / law.bulk_modulus / 3.0
    shear = np.concatenate([[0.0], shear])
    return diagonal(volume + shear / 2.0, volume + shear / 2.0, volume - shear)


def simple_shear(law, p_start, gamma):
    """Isotropic compression to p_start, then simple shear γ of axis 0 along axis 1."""
    F = np.zeros((len(gamma) + 1, 3, 3))
    F[:] = np.eye(3)
    F[1:, 0, 1] = gamma
    return F * np.exp(-p_start / law.bulk_modulus / 3.0)


def random_rotations(n, rng):
    """n proper rotations, uniformly distributed."""
    q = rng.normal(size=(n, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1)[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def stiffness_of(law, stress, state):
    """`law.stiffness` of packed stresses (n, 6) and states, in double precision."""
    function, parameters, n_state = type(law).stiffness, law.parameters(), state.shape[1]
    names, count = type(parameters), len(parameters)

    @ti.kernel
    def evaluate(
        parameters: ti.types.ndarray(), stress: ti.types.ndarray(), state: ti.types.ndarray(), out: ti.types.ndarray()
    ):
        for i in range(out.shape[0]):
            numbers = ti.Vector([parameters[k] for k in ti.static(range(count))])
            tau = ti.Vector([stress[i, k] for k in ti.static(range(6))])
            out[i] = function(named(names, numbers), tau, ti.Vector([state[i, k] for k in ti.static(range(n_state))]))

    out = np.zeros(len(stress))
    with working_precision("f64"):
        evaluate(np.array(parameters), np.ascontiguousarray(stress), np.ascontiguousarray(state), out)
    return out
