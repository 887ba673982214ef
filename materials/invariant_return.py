"""What a law of (p, q) alone does to the tensors: it rescales the deviator and replaces the trace, no eigenvectors.

Such an update is put together from three parts, which a `Form` names: the trial state, the return map, and the tensor h
of what it found. They come for any state, and in a straight line for states that are near enough (`Law.vector_update`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from snowmpm.compiler import ti

from .elastic import elastic_trial, small_elastic_trial
from .hencky import deviation_of_small_strain, deviation_of_strain
from .law import REDO
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


@ti.func
def _h_of_any(per_bulk, deviator, deviator2, p, factor):
    return h_of_invariants(per_bulk, deviator, deviator2, p, factor), 1


@ti.func
def _h_of_small(per_bulk, deviator, deviator2, p, factor):
    h, small = deviation_of_small_strain(deviator, -p * per_bulk, deviator2, factor)
    return h, ti.select(small, 1, 0)


@dataclass(frozen=True)
class Form:
    """Which functions an update is made of. trial: like `elastic_trial`; h: like `h_of_invariants`, and 1, or 0 where
    it is not right; failed: what `iterations` then are; straight: whether return maps must be in a straight line."""

    trial: Callable[..., Any]
    h: Callable[..., Any]
    failed: int
    straight: bool


GENERAL = Form(elastic_trial, _h_of_any, -1, False)
STRAIGHT = Form(small_elastic_trial, _h_of_small, REDO, True)


def end_of(form):
    """Function that ends an update in a `Form`, for laws whose parameters hold G and 1/K."""

    @ti.func
    def end(prm: ti.template(), changed, h, deviator, deviator2, p, factor, valid):
        """h, anew if changed, and Kirchhoff stress [Pa] of p and `factor` times the deviator; valid, 0 if h is wrong.
        """
        h_end, valid_end = h, valid
        if changed:
            h_end, near = form.h(prm.per_K, deviator, deviator2, p, factor)
            valid_end *= near
        return h_end, stress_of_invariants(prm.G, deviator, p, factor), valid_end

    return end
