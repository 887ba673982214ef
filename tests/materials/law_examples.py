"""One or more examples of every law: what the suite of laws and the other tests over many laws run on.

A law that is registered without an example fails the suite: add one here, and it has all the tests.
"""

from frictional_laws import LAWS as FRICTIONAL
from hypoplastic_laws import DENSE, FAST
from hypoplastic_laws import SAND as LINEAR
from parameter_sets import W1, W2, A, B, C, changed

from snowmpm.materials import LAWS, CohesiveCrack, Elastic, NeoHookean, StomakhinSnow, StVenantKirchhoff, WetSnow
from snowmpm.materials.critical_state import CriticalStateLaw

EXAMPLES = {
    "elastic": Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3),
    "neo-Hookean": NeoHookean(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3),
    "St. Venant-Kirchhoff": StVenantKirchhoff(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3),
    "cracking": CohesiveCrack(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3, strength=3e3, fracture_energy=0.1,
                              shear_ratio=1.2, friction_angle=30.0, length=0.01),
    "modified Cam-Clay": B,
    "cohesive Cam-Clay": A,
    "soft Cam-Clay": C,
    "exponential Cam-Clay": changed(C, hardening=1.0, hardening_law="exponential"),
    "perfect Cam-Clay": changed(A, hardening=0.0),
    "frozen Cam-Clay": changed(A, return_map="frozen"),
    "substepped Cam-Clay": changed(A, return_map="substepped"),
    "weak layer 1": W1,
    "weak layer 2": W2,
    "Stomakhin": StomakhinSnow(density=400.0, youngs_modulus=1.4e5, poisson_ratio=0.2, hardening=10.0,
                               critical_compression=0.025, critical_stretch=0.0075),
    "hypoplastic": LINEAR,
    "critical state": DENSE,
    "solid to gas": FAST,
    "wet snow": WetSnow(density=350.0, youngs_modulus=1e6, poisson_ratio=0.25, friction_angle=25.0, cohesion=2e3,
                        softening_strain=0.05, water_weakening=23.5),
    **FRICTIONAL,
}


def without_example(registry=LAWS, examples=EXAMPLES):
    """Kinds of the registry of laws that no example is of."""
    return set(registry) - {law.kind for law in examples.values()}


def chosen(condition):
    """Names of the examples for which condition(law) holds."""
    return [name for name, law in EXAMPLES.items() if condition(law)]


CAM_CLAYS = chosen(lambda law: isinstance(law, CriticalStateLaw))
STRAIGHT = chosen(lambda law: law.vector_update is not None)
