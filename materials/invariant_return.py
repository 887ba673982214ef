"""What a law of (p, q) alone does to the tensors: it rescales the deviator and replaces the trace, no eigenvectors."""

import taichi as ti

from .hencky import deviation_of_strain
from .symmetric import plus_isotropic


@ti.func
def stress_of_invariants(shear_modulus, deviator, p, factor):
    """Kirchhoff stress [Pa] whose deviatoric Hencky strain is `factor` e, and whose pressure is p."""
    return plus_isotropic((2.0 * shear_modulus * factor) * deviator, -p)


@ti.func
def h_of_invariants(per_bulk, deviator, deviator2, p, factor):
    """Stored tensor h of that state; exactly zero where it is free of stress. deviator2: e : e."""
    h = deviator * 0.0
    if factor != 0.0 or p != 0.0:
        h = deviation_of_strain(deviator, -p * per_bulk, deviator2, factor)
    return h
