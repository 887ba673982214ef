"""Anticrack Cam-Clay: a weak snow layer that collapses under compression."""

from typing import Annotated, ClassVar, Literal

import numpy as np
import taichi as ti
from pydantic import Field

from .critical_state import CriticalStateLaw
from .elastic import elastic_trial
from .ellipse import YIELD_TOLERANCE, return_to_ellipse, sinh_cosh
from .hencky import deviation_of_strain
from .law import Positive, StateVariable
from .precision import by_precision
from .symmetric import plus_isotropic


@ti.func
def anticrack_cam_clay_update(prm, h, state, A, dt):
    """See `Law`. prm: `CriticalStateLaw.ellipse_parameters`, α; state: ζ, collapsed."""
    K, G, xi, alpha = prm[0], prm[1], prm[2], prm[7]
    h_new, deviator, volume, deviator2, valid = elastic_trial(h, A)
    zeta = state[0]
    intact = state[1] == 0.0
    beta = prm[3] if intact else 0.0
    p = -K * volume
    e2 = (1.0 + 2.0 * beta) * prm[6] * deviator2
    s, c = sinh_cosh(xi * zeta)
    p0 = K * s
    w = p - 0.5 * (1.0 - beta) * p0
    radius = 0.5 * (1.0 + beta) * p0
    state_new = state
    dissipation = 0.0
    iterations = valid - 1
    if w * w + e2 > radius * radius * ti.static(1.0 + by_precision(*YIELD_TOLERANCE)):
        p_trial, ratio = p, 0.0
        side = 1.0 if w > 0.0 else -1.0
        # In each phase ζ = zeta0 + rate Δz; `gap` is the Δz < 0 at which a dilating ellipse has shrunk to a point
        zeta0, rate, gap = zeta, 1.0, -zeta
        start, end = 0.0, w / K
        if intact:
            collapse = zeta / alpha  # |Δz| of complete softening
            gap = -collapse
            rate = -alpha * side
            if w > 0.0:
                end = p / K
                if p >= K * collapse:
                    # Softens completely within the step and hardens from there, without cohesion
                    zeta0, rate, start = -collapse, 1.0, collapse
                    s, c = 0.0, 1.0
                    e2 /= 1.0 + 2.0 * beta
                    beta = 0.0
                    state_new[1] = 1.0
        elif w > 0.0:
            start = ti.max(0.0, -zeta)  # collapsed and opened: first closes the gap, without stress
        if p <= K * gap:
            # Dilates until p₀ = 0 and beyond: separated and stress-free
            p = 0.0
            h_new.fill(0.0)
            if intact:
                zeta0, rate = -gap, 1.0
                state_new[1] = 1.0
        else:
            if w <= 0.0:
                end = ti.max(end, gap)
            p, ratio, iterations = return_to_ellipse(
                p_trial, e2, K, (1.0 + 2.0 * beta) * prm[5], xi, beta, 0.0, zeta0, rate, s, c, side, start, end
            )
            h_new = deviation_of_strain(ratio * deviator, -p / K, ratio * ratio * deviator2)
        compaction = (p_trial - p) / K
        state_new[0] = zeta0 + rate * compaction
        dissipation = 0.5 * (p_trial + p) * compaction + G * deviator2 * (1.0 - ratio * ratio)
        deviator *= ratio
    tau = plus_isotropic(2.0 * G * deviator, -p)
    return h_new, tau, state_new, dissipation, iterations


class AnticrackCamClay(CriticalStateLaw):
    """Weak layer: a cohesive Cam-Clay ellipse that first shrinks under any plastic volume change, then hardens.

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0                          [G 56]
        p₀ = K sinh(ξ max(ζ, 0)),   ζ = −η                                           [G 57 with η for ε_v^p]
        intact:     dζ = −α |dε_v^p|  until ζ = 0: complete softening, p₀ = 0        [G 58]
        collapsed:  dζ = −dε_v^p and β = 0, for good

    [G] Gaume et al., "Modeling snow and avalanches with the Material Point Method and finite strain elastoplasticity".
    ζ₀ = asinh(p₀/K)/ξ. Isotropic collapse takes the plastic compaction ζ₀/α, so the collapse height is that times the
    layer thickness, and the fracture energy about half the peak stress times the collapse height: α must be scaled
    with the grid spacing when the layer is as thick as the grid allows, to keep that energy.
    Backward Euler, softening included (see `ellipse.py`). A step that passes complete softening is solved in the
    collapsed phase, with the whole step in the flow direction.

    Deviations: the switch is a state of each particle, not the time t_c of [G 58]; p is −tr(τ)/3 also in plane strain;
    p₀ = 0 from the start is a collapsed layer.
    Validity: under strain control the softening branch is unique while αξ cosh(ξ ζ₀) < 1 (isotropic compression).
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("compaction", "-", "ζ that sets p0: bonds left while intact, plastic compaction once collapsed"),
        StateVariable("collapsed", "-", "1 after complete softening, else 0"),
    )
    kind: Literal["anticrack_cam_clay"] = "anticrack_cam_clay"
    hardening: Positive  # ξ [-]
    cohesion: Annotated[float, Field(ge=0.0, le=1.0)]  # β [-]
    softening: Positive  # α [-]

    update = staticmethod(anticrack_cam_clay_update)

    @property
    def beta(self):
        return self.cohesion

    def beta_at(self, state):
        return np.where(np.asarray(state)[..., 1] > 0.0, 0.0, self.cohesion)

    def outputs(self, state):
        """p0 [Pa] and damage, the share of the initial strength that is lost; 1 for good once collapsed."""
        fields = super().outputs(state)
        fields["damage"] = np.where(np.asarray(state)[..., 1] > 0.0, 1.0, fields["damage"])
        return fields

    def parameters(self):
        return (*self.ellipse_parameters(), self.softening)

    def initial_state(self):
        return self.initial_zeta, 1.0 if self.p0 == 0.0 else 0.0

    def severed_state(self):
        return 0.0, 1.0
