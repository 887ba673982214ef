"""Hencky elasticity: the law of a material that never yields, and the trial state of every other law."""

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from snowmpm.compiler import ti

from .hencky import hencky_strain, log_series, log_volume, strain_of_volume, trial_deviation
from .law import REDO, Law
from .precision import by_precision
from .symmetric import plus_isotropic

STEP_LIMIT = 0.25
"""A : A up to which a step cannot turn a particle inside out."""


@ti.func
def determinant_of_step(A):
    """det (I + A)"""
    return (A + ti.Matrix.identity(float, A.n)).determinant()


@ti.func
def trial_state(h, A):
    """Stored tensor h of the trial state f b fᵀ with f = I + A, and 1 if the step could be made.

    A step that is not finite or has det f <= 0 is left out (A = 0) and reported as 0; f b fᵀ alone would not show it.
    """
    h_trial = trial_deviation(h, A)
    valid = 1
    # |A| < 1 cannot turn f inside out, so the determinant is only needed for steps beyond any time step limit
    if not (A.norm_sqr() < STEP_LIMIT):
        stretch = determinant_of_step(A)
        possible = stretch > 0.0 and stretch < ti.static(by_precision(1e30, 1e100))
        valid = ti.select(possible, 1, 0)
        h_trial = ti.select(possible, h_trial, h)
    return h_trial, valid


@ti.func
def elastic_trial(h, A):
    """`trial_state` and its Hencky strain: h, deviator e, trace, e : e, and 1 if the step could be made.

    Far from the identity the trace comes from the determinants of the state and of the step where they are known better
    than that of their product. A step to a strain that is not known even so is left out like an impossible one.
    """
    h_trial, valid = trial_state(h, A)
    deviator, volume, deviator2, near = log_series(h_trial)
    if not near:
        known = 0
        if valid == 1:
            by_parts, error = log_volume(h, A)
            deviator, volume, deviator2, known = strain_of_volume(h_trial, by_parts, error)
        if known == 0:
            h_trial, valid = h, 0
            deviator, volume, deviator2, known = hencky_strain(h)
    return h_trial, deviator, volume, deviator2, valid


@ti.func
def small_elastic_trial(h, A):
    """`elastic_trial` in a straight line, for strains and steps that are small; the last number is 0 elsewhere."""
    h_trial = trial_deviation(h, A)
    deviator, volume, deviator2, near = log_series(h_trial)
    # f b fᵀ does not tell a particle from one turned inside out
    return h_trial, deviator, volume, deviator2, ti.select(near and determinant_of_step(A) > 0.0, 1, 0)


class ElasticParameters(NamedTuple):
    """What the update of `Elastic` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]


def elastic_update(trial, failed):
    """Update function (see `Law`) that makes its trial state by a function and reports a failure by a number."""

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, volume, _, valid = trial(h, A)
        tau = plus_isotropic(2.0 * prm.G * deviator, prm.K * volume)
        return h_new, tau, state, 0.0, ti.select(valid == 1, 0, failed)

    return update


class Elastic(Law):
    """Isotropic Hencky elasticity.

        ψ = ½ K (tr ε)² + G dev ε : dev ε,   τ = K tr(ε) I + 2 G dev ε

    Gaume et al., "Modeling snow and avalanches with the Material Point Method and finite strain elastoplasticity",
    eqs. 4, 18-19, 22; the same in Gaume et al. (2018), doi:10.1038/s41467-018-05181-w.
    Path-independent: a closed loop of deformation gives back all energy. Loses ellipticity beyond a stretch of e in
    compression, far outside what snow carries elastically.
    """

    kind: Literal["elastic"] = "elastic"
    YIELDS: ClassVar[bool] = False

    update = staticmethod(elastic_update(elastic_trial, -1))
    vector_update = staticmethod(elastic_update(small_elastic_trial, REDO))

    @property
    def tensile_strength(self) -> float:
        return np.inf

    def parameters(self) -> ElasticParameters:
        return ElasticParameters(self.bulk_modulus, self.shear_modulus)
