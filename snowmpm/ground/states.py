"""Shear stress of a friction law at many states at once."""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.materials.parameters import named


@functools.cache
def _kernel(law):
    """Kernel of a law's class: numbers (n, parameters), states (n, 4) -> result (n, 2)."""
    stress, names = law.stress, law.PARAMETERS
    count = len(names._fields)

    @taichi_kernel
    def evaluate(numbers: ti.types.ndarray(), states: ti.types.ndarray(), result: ti.types.ndarray()):
        ti.loop_config(serialize=True)
        for i in range(states.shape[0]):
            vector = ti.Vector([numbers[i, k] for k in ti.static(range(count))])
            found = stress(named(names, vector), states[i, 0], states[i, 1], states[i, 2], states[i, 3])
            result[i, 0], result[i, 1] = found[0], found[1]

    return evaluate


def stresses(law, numbers, states):
    """Dry part [Pa] and rate [Pa s/m] (n, 2) of a law's class (`ground.law.FrictionLaw.stress`).

    numbers (n, parameters): in the order of its PARAMETERS; states (n, 4): density [kg/m3], normal stress [Pa], speed
    [m/s], depth [m].
    """
    result = np.zeros((len(states), 2))
    if len(states):
        with runtime.precision("f64"):
            _kernel(law)(np.ascontiguousarray(numbers, float), np.ascontiguousarray(states, float), result)
    return result
