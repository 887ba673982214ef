"""Function of a law of the ground at many states at once."""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.materials.parameters import named


@functools.cache
def _kernel(function, names):
    """Kernel of a function of a law: numbers (n, parameters), states (n, 4) -> result (n, 2)."""
    count = len(names._fields)

    @taichi_kernel
    def evaluate(numbers: ti.types.ndarray(), states: ti.types.ndarray(), result: ti.types.ndarray()):
        ti.loop_config(serialize=True)
        for i in range(states.shape[0]):
            vector = ti.Vector([numbers[i, k] for k in ti.static(range(count))])
            found = function(named(names, vector), states[i, 0], states[i, 1], states[i, 2], states[i, 3])
            result[i, 0], result[i, 1] = found[0], found[1]

    return evaluate


def stresses(law, numbers, states):
    """Dry part [Pa] and rate [Pa s/m] (n, 2) of a law's class (`ground.law.FrictionLaw.stress`).

    numbers (n, parameters): in the order of its PARAMETERS; states (n, 4): density [kg/m3], normal stress [Pa], speed
    [m/s], depth [m].
    """
    return evaluated(law.stress, law.PARAMETERS, numbers, states)


def evaluated(function, names, numbers, states):
    """(n, 2) of a Taichi function of a law, of its parameters (NamedTuple `names`) and four numbers of a state."""
    result = np.zeros((len(states), 2))
    if len(states):
        with runtime.precision("f64"):
            _kernel(function, names)(np.ascontiguousarray(numbers, float), np.ascontiguousarray(states, float), result)
    return result
