"""Anticrack Cam-Clay: a weak snow layer that collapses under compression."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from .arrays import Array
from .critical_state import CriticalStateLaw
from .hardening import LEAST_RATE, HardeningRate
from .law import Law, Positive, StateVariable

BAND = 1.1
"""Height of the row that a collapse localises in [cells]."""


class AnticrackCamClay(CriticalStateLaw):
    """Weak layer: a cohesive Cam-Clay ellipse that first shrinks under any plastic volume change, then hardens.

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0                          [G 56]
        p₀ = K sinh(ξ max(ζ, 0)),   ζ = −η                                           [G 57 with η for ε_v^p]
        intact:     dζ = −α |dε_v^p|  until ζ = 0: complete softening, p₀ = 0        [G 58]
        collapsed:  dζ = −dε_v^p and β = 0, for good

    [G] Gaume et al., "Modeling snow and avalanches with the Material Point Method and finite strain elastoplasticity";
    the law is that of Gaume, Gast, Teran, van Herwijnen and Jiang (2018), Nature Communications 9, 3047,
    doi:10.1038/s41467-018-05181-w. Keys of a scene: M `critical_slope`, β `cohesion`, ξ `hardening`, α `softening`,
    p₀ at the start `p0`, t `reference_thickness`; K from `youngs_modulus` and `poisson_ratio`.
    ζ₀ = asinh(p₀/K)/ξ. Isotropic collapse takes the plastic compaction ζ₀/α, so the collapse height is that times the
    thickness t of the layer, and the fracture energy per area about half the peak stress times the collapse height.

    On a grid the softening localises: rows of cells collapse one after the other, each for itself, and what a crack has
    to pay is the energy of the first one, of height h = `BAND` cells (measured), not of the whole layer. Given t as
    `reference_thickness`, the law is used with (`on_grid`)

        ξ_h = ξ h / t     so that     ζ = (h / t) (plastic compaction of a row),   w_f = h w(ξ_h) = t w(ξ)

    since ξ and ζ appear as ξζ only, and α is the same in both phases: the collapse height t ζ₀/α and all that follows
    it, compaction and hardening, are those of the layer as a whole, but gathered in one row. Elastic stiffness,
    strength and Maxwell load do not change. A layer of more than about two cells has room for a second row, which the
    weight of a falling slab may collapse as well: its collapse is then too high. So a layer is best `thickened_to` two
    cells on any grid: with E d/t over a thickness d, and t_d = d, stiffness, strength, collapse and energy per area are
    the same. Cells too large for their softening (a row would snap back: α ξ_h beyond `critical_hardening`) are
    refused.
    Backward Euler, softening included (see `ellipse.py`). A step that passes complete softening is solved in the
    collapsed phase, with the whole step in the flow direction.

    Deviations: the switch is a state of each particle, not the time t_c of [G 58]; p is −tr(τ)/3 also in plane strain;
    p₀ = 0 from the start is a collapsed layer.
    Validity: under strain control the softening branch is unique while αξ cosh(ξ ζ₀) < 1 (isotropic compression).
    """

    EXAMPLES: ClassVar = {"reference_thickness": 0.1}

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("compaction", "-", "ζ that sets p0: bonds left while intact, plastic compaction once collapsed"),
        StateVariable("collapsed", "-", "1 after complete softening, else 0"),
    )
    BONDS: ClassVar[int] = 1
    kind: Literal["anticrack_cam_clay"] = "anticrack_cam_clay"
    hardening: Annotated[HardeningRate, Field(gt=0.0)]
    """rate ξ of hardening, of `p0` with plastic compaction [-]"""
    hardening_law: Literal["sinh"] = "sinh"
    """bonds are used up at a finite plastic strain, which an exponential law never reaches"""
    cohesion: Annotated[float, Field(ge=0.0, le=1.0)]
    """β: tensile over compressive strength of the intact layer [-]"""
    softening: Positive
    """α: how fast plastic deformation breaks the bonds [-]"""
    reference_thickness: Positive | None = None
    """t of the layer that collapses as one [m]; when missing, the softening is as given on any grid"""

    @property
    def beta(self) -> float:
        return self.cohesion

    @property
    def alpha(self) -> float:
        return self.softening

    @property
    def collapses(self) -> bool:
        return True

    @property
    def collapse_thickness(self) -> float | None:
        return self.reference_thickness

    def thickened_to(self, thickness: float, new_thickness: float) -> "Law":
        reference = (self.reference_thickness or thickness) * new_thickness / thickness
        return super().thickened_to(thickness, new_thickness).model_copy(update={"reference_thickness": reference})

    def on_grid(self, spacing: float, rows: int = 1) -> "Law":
        if self.reference_thickness is None:
            return self
        rate = self.hardening * BAND * spacing / self.reference_thickness
        largest = self.critical_hardening() / self.softening
        if not LEAST_RATE <= rate < largest:
            bounds = [limit * self.reference_thickness / (self.hardening * BAND) for limit in (LEAST_RATE, largest)]
            raise ValueError(f"reference_thickness = {self.reference_thickness:g} m needs cells between {bounds[0]:.2g}"
                             f" and {bounds[1]:.2g} m, not {spacing:g}: beyond, a row of them snaps back")
        return self.model_copy(update={"hardening": rate, "reference_thickness": None})

    def of_whole_layer(self, thickness: float) -> "Law":
        return super().of_whole_layer(thickness).on_grid(thickness / BAND)

    def initial_state(self) -> tuple[float, ...]:
        return self.initial_zeta, 1.0 if self.p0 == 0.0 else 0.0

    @property
    def bonds_last_below(self) -> float:
        return 1.0

    @property
    def bond_energy(self) -> float:
        """That of an isotropic collapse, ½ p₀ ζ₀ / α."""
        return 0.5 * self.p0 * self.initial_zeta / self.softening

    def severed_state(self) -> tuple[float, ...] | None:
        return 0.0, 1.0

    def beta_at(self, state: Array) -> float | Array:
        return np.where(np.asarray(state)[..., 1] > 0.0, 0.0, self.cohesion)

    def outputs(self, state: Array) -> dict[str, Array]:
        """p0 [Pa] and damage, the share of the initial strength that is lost; 1 for good once collapsed."""
        fields = super().outputs(state)
        fields["damage"] = np.where(np.asarray(state)[..., 1] > 0.0, 1.0, fields["damage"])
        return fields
