"""Shear stress of a law of ground friction at many states, through a kernel."""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.ground import LAWS, Bingham, Coulomb, FrictionalViscous, MuI, SamosAt, Voellmy
from snowmpm.materials.parameters import named
from snowmpm.materials.precision import working_precision

EXAMPLES = {
    "coulomb": Coulomb(mu=0.4, tau0=30.0, cohesion=100.0),
    "voellmy": Voellmy(mu=0.155, xi=1750.0, tau0=70.0),
    "samos_at": SamosAt(mu=0.155),
    "frictional_viscous": FrictionalViscous(mu=0.2, viscosity=5.0, exponent=1.5, cohesion=50.0),
    "bingham": Bingham(yield_stress=200.0, viscosity=40.0),
    "mu_i": MuI(mu_s=0.38, mu_2=0.64, grain_diameter=0.05, grain_density=400.0),
}
assert EXAMPLES.keys() == LAWS.keys()


@functools.cache
def kernel(law, precision):
    """Kernel of a law class; the numbers are those of each state."""
    with working_precision(precision) as (real, _):
        table = ti.types.ndarray(real, 2)
        count = len(law.PARAMETERS._fields)
        names, stress = law.PARAMETERS, law.stress

        @ti.kernel
        def evaluate(numbers: table, states: table, result: table):
            for i in range(states.shape[0]):
                vector = ti.Vector([numbers[k, i] for k in ti.static(range(count))])
                found = stress(named(names, vector), states[i, 0], states[i, 1], states[i, 2], states[i, 3])
                result[i, 0], result[i, 1] = found[0], found[1]

    return evaluate


def parts(law, sigma, speed, depth, density=300.0, precision="f64", gravity=9.81, numbers=None):
    """Dry part [Pa] and rate [Pa s/m] of a law, broadcast over the states."""
    shape = np.broadcast_shapes(*map(np.shape, (density, sigma, speed, depth)))
    states = np.stack([np.broadcast_to(value, shape).ravel() for value in (density, sigma, speed, depth)], axis=1)
    if numbers is None:
        numbers = np.repeat(np.array(law.parameters(gravity), float)[:, None], len(states), axis=1)
    with working_precision(precision) as (_, real):
        result = np.zeros((len(states), 2), real)
        kernel(type(law), precision)(np.ascontiguousarray(numbers, real), states.astype(real), result)
    return result[:, 0].reshape(shape), result[:, 1].reshape(shape)


def shear(law, sigma, speed, depth, **more):
    """tau [Pa]."""
    dry, rate = parts(law, sigma, speed, depth, **more)
    return dry + rate * speed
