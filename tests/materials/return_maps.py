"""The return map of the Cam-Clay laws in (p, q), without tensors around it: trial states of any size, at any state."""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.materials.critical_state_return import critical_state_return
from snowmpm.materials.parameters import named
from snowmpm.materials.precision import working_precision


@functools.cache
def _kernel(precision, names):
    @ti.kernel
    def return_all(parameters: ti.types.ndarray(), trial: ti.types.ndarray(), found: ti.types.ndarray()):
        for i in range(trial.shape[0]):
            numbers = ti.Vector([parameters[k] for k in ti.static(range(len(names._fields)))])
            p, ratio, zeta, collapsed, iterations, yielded = critical_state_return(
                named(names, numbers), trial[i, 0], trial[i, 1], trial[i, 2], trial[i, 3], False
            )
            found[i, 0] = p
            found[i, 1] = ratio
            found[i, 2] = zeta
            found[i, 3] = collapsed
            found[i, 4] = iterations
            found[i, 5] = yielded

    return return_all


def returned(law, p_trial, q_trial, state=None, precision="f64"):
    """p, q, state (n, n_state), iterations, yielded from trial p and q [Pa] and a state, one or for each."""
    p_trial, q_trial = np.broadcast_arrays(np.atleast_1d(p_trial).astype(float), np.atleast_1d(q_trial).astype(float))
    state = np.broadcast_to(law.initial_state() if state is None else state, (len(p_trial), len(law.STATE)))
    deviator2 = q_trial**2 / (6.0 * law.shear_modulus**2)
    with working_precision(precision) as (_, dtype):
        collapsed = state[:, 1] if len(law.STATE) > 1 else np.zeros(len(p_trial))
        trial = np.column_stack([p_trial, deviator2, state[:, 0], collapsed]).astype(dtype)
        found = np.zeros((len(trial), 6), dtype)
        parameters = law.parameters()
        _kernel(precision, type(parameters))(np.array(parameters, dtype), trial, found)
    found = found.astype(float)
    new_state = found[:, 2 : 2 + len(law.STATE)]
    return found[:, 0], found[:, 1] * q_trial, new_state, found[:, 4].astype(int), found[:, 5] == 1.0


def violation(law, p, q, state):
    """Yield function over the larger of the initial and the current p0, squared; <= 0 is admissible."""
    scale = np.maximum(law.p0_at(np.asarray(state)[..., 0]), max(law.p0, 1e-4 * law.bulk_modulus))
    return law.yield_of_invariants(p, q, state) / scale**2
