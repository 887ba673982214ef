"""A crack with a thickness and an energy of its own within a particle: the double-scale law in its cohesive limit."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from . import crack_state
from .arrays import Array
from .crack_excess import crack_excess
from .crack_parameters import CohesiveCrackParameters, wrapped_parameters
from .crack_planes import DAMAGE, NORMAL, PER_CRACK
from .crack_set import crack_set_update
from .crack_state import FIRST, OWN_OUTPUTS
from .crack_update import cohesive_crack_update
from .cracked_bulk import Bulk
from .declared import Declared
from .law import Law, Positive

TAKEN_OVER = ("density", "youngs_modulus", "poisson_ratio")
"""Numbers that the law around the cracks has from the material."""


class CohesiveCrack(Law):
    """Material that cracks where its largest principal stress reaches its strength: a band within the particle.

        τ̇ = D : (ε̇ − ε̇^p − Σ (1/H) sym(n ⊗ u̇)),   ṫ = K^i u̇,   τ n = t                             [B 107-109]

    [B] Bui and Nguyen (2021), "Smoothed particle hydrodynamics (SPH) and its applications in geomechanics",
    doi:10.1016/j.compgeo.2021.104315, section 3.2.3: double-scale kinematics of a particle of length H with a band of
    normal n, in the limit f = h_l/H → 0 of a band that is thin beside its particle, in which thickness and stiffness of
    the band are gathered in its traction law. [B] leave onset and that law open. Here:

    onset    the largest principal stress reaches f_t; n is its direction, and moves on as a plane of the material
    band     cohesion that fades linearly with the jump, then friction between its faces (crack_return.py)
    second   (`cracks` = 2; [B 4.5]) the largest stress within the plane of the first reaches f_t; its normal lies there
    reset    (`reset`; [B 4.5]) a crack that lost all cohesion has parted the particle: from the next step on it is
             counted (`crack_resets`) and forgotten, and the particle is intact
    around   ε^p of `bulk`, a law of the library; elastic without. Where it yields and a crack moves, both conditions
             hold at the end of the step (crack_set.py)

    Keys: f_t `strength`, G_f `fracture_energy`, β `shear_ratio` (strength in shear over f_t), μ from
    `friction_angle`, H `length`. H is the size of the cell in MPM, and twice the spacing of particles in SPH
    (`on_grid`), where no single row can open: a crack in one row of cells, or two of particles, takes G_f per area on
    every grid. In MPM its particles must deform as one (`docs/cracks.md`). Lengths larger than

        2 G_f min(M, G/β²) / f_t²,    M = K + 4G/3

    would snap back and are refused.

    Deviations and limits. The planes do not change; where no more cracks may begin, the material may carry more than
    f_t across other planes. No crack begins in compression or shear, though one that is there slides. The jump that
    bonds took is not undone by unloading; once they are gone the whole opening must close before the faces press. After
    a reset nothing is left of the opening: faces that meet again do so as intact material. At equal principal stresses
    the plane is not defined by the stress, and round-off decides. Strength and energy do not follow what `bulk` makes
    of the material: compaction strengthens it, not its cracks.
    """

    EXAMPLES: ClassVar = {"length": 0.05}

    STATE: ClassVar[Any] = Declared(FIRST, crack_state.variables)
    TENSORS: ClassVar[Any] = Declared((NORMAL,), crack_state.tensors)
    OUTPUTS: ClassVar[Any] = Declared(OWN_OUTPUTS, crack_state.outputs)
    RATE_DEPENDENT: ClassVar[Any] = Declared(False, lambda law: law.bulk is not None and law.bulk.RATE_DEPENDENT)
    DISSIPATIVE: ClassVar[Any] = Declared(True, lambda law: law.bulk is None or law.bulk.DISSIPATIVE)
    BONDS: ClassVar[int] = DAMAGE

    kind: Literal["cohesive_crack"] = "cohesive_crack"
    strength: Positive
    """tensile strength f_t, at which a crack begins [Pa]"""
    fracture_energy: Positive
    """G_f: energy to open a crack, per area of it [J/m2]"""
    shear_ratio: Positive = 1.0
    """β: strength in shear over that in tension [-]"""
    friction_angle: Annotated[float, Field(ge=0.0, lt=90.0)] = 0.0
    """of the faces of a crack on each other [degrees]"""
    length: Positive | None = None
    """H, over which a crack is spread [m]; the cell of MPM, twice the particle spacing of SPH when missing"""
    cracks: Literal[1, 2] = 1
    """how many cracks a particle may have at a time"""
    reset: bool = False
    """whether a crack without cohesion makes way for the next one"""
    bulk: Bulk | None = None
    """the law around the cracks; elastic when missing"""

    @property
    def update(self) -> Any:
        if self.cracks == 1 and not self.reset and self.bulk is None:
            return cohesive_crack_update
        if self.bulk is None:
            return crack_set_update(self.cracks, self.reset, None, None, 0)
        names: Any = type(self.bulk.parameters())
        return crack_set_update(self.cracks, self.reset, self.bulk.update, names, len(self.bulk.STATE))

    @model_validator(mode="before")
    @classmethod
    def _shared_with_bulk(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("bulk"), dict):
            shared = {name: data[name] for name in TAKEN_OVER if name in data}
            return {**data, "bulk": {**shared, **data["bulk"]}}
        return data

    @model_validator(mode="after")
    def _possible(self):
        if self.reset and self.cracks == 2:
            raise ValueError("reset goes with cracks = 1: it takes the place of a second crack")
        if self.bulk is not None:
            if self.bulk.card is not None:
                raise ValueError("bulk.card is not read: write the numbers of the card, or begin the material with it")
            for name in TAKEN_OVER:
                if self.bulk[name] != self[name]:
                    raise ValueError(f"bulk.{name} = {self.bulk[name]:g} must be {name} of the material,"
                                     f" {self[name]:g}: leave it out")
            if self.bulk.integration != "implicit":
                raise ValueError(f'bulk.return_map = "{self.bulk.integration}" must be "implicit"')
            for key in self.bulk.of_components:
                raise ValueError(f"bulk.{key} is not computed around cracks: leave it out")
        return self

    @model_validator(mode="after")
    def _does_not_snap_back(self):
        if self.length is not None and not self.length < self.largest_length:
            raise ValueError(f"length = {self.length:g} m must be below {self.largest_length:.3g} m: a longer particle"
                             " snaps back (see largest_length)")
        return self

    @property
    def largest_length(self) -> float:
        """Length [m] of a particle from which on it gives back more than its crack can take."""
        M = self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus
        return 2.0 * self.fracture_energy * min(M, self.shear_modulus / self.shear_ratio**2) / self.strength**2

    def on_grid(self, spacing: float, rows: int = 1) -> "Law":
        bulk, length = self.bulk and self.bulk.on_grid(spacing, rows), rows * spacing
        if self.length is not None:
            return self if bulk is self.bulk else self.model_copy(update={"bulk": bulk})
        if not length < self.largest_length:
            raise ValueError(f"fracture_energy = {self.fracture_energy:g} J/m2 and strength = {self.strength:g} Pa need"
                             f" cells below {self.largest_length / rows:.2g} m, not {spacing:g}: a longer one snaps"
                             " back")
        return self.model_copy(update={"length": length, "bulk": bulk})

    def thickened_to(self, thickness: float, new_thickness: float) -> "Law":
        return self._with_bulk_alike(super().thickened_to(thickness, new_thickness))

    def of_whole_layer(self, thickness: float) -> "Law":
        return self._with_bulk_alike(super().of_whole_layer(thickness))

    def _with_bulk_alike(self, law):
        if self.bulk is None:
            return law
        shared = {name: law[name] for name in TAKEN_OVER}
        return law.model_copy(update={"bulk": self.bulk.model_copy(update=shared)})

    @property
    def first_of_bulk(self) -> int:
        """Where the state of the law around the cracks begins."""
        return PER_CRACK * self.cracks + int(self.reset)

    @property
    def tensile_strength(self) -> float:
        return min(self.strength, self.bulk.tensile_strength) if self.bulk else self.strength

    @property
    def tangent_over_elastic(self) -> float:
        return self.bulk.tangent_over_elastic if self.bulk else 1.0

    @property
    def lateral_pressure(self) -> float:
        return self.bulk.lateral_pressure if self.bulk else super().lateral_pressure

    @property
    def complete_opening(self) -> float:
        """w_c = 2 G_f/f_t: the jump at which no cohesion is left [m]."""
        return 2.0 * self.fracture_energy / self.strength

    @property
    def friction_exceeds_dilation(self) -> bool:
        return self.friction_angle > 0.0 or (self.bulk is not None and self.bulk.friction_exceeds_dilation)

    @property
    def bonds_last_below(self) -> float:
        return 1.0

    @property
    def bond_energy(self) -> float:
        return self.fracture_energy / self._length

    @property
    def _length(self):
        """H, or without a grid a length at which the crack does not snap back, for estimates."""
        return self.length or 0.5 * self.largest_length

    def parameters(self) -> Any:
        H, w_c, G = self._length, self.complete_opening, self.shear_modulus
        M = self.bulk_modulus + 4.0 / 3.0 * G
        own = CohesiveCrackParameters(
            K=self.bulk_modulus,
            shear_modulus=G,
            strength=self.strength,
            friction=float(np.tan(np.radians(self.friction_angle))),
            beta=self.shear_ratio,
            per_beta=1.0 / self.shear_ratio,
            per_weight=1.0 / self.shear_ratio**2,
            normal=M * w_c / H,
            shear=G * w_c / H,
            normal_per_metre=M / H,
            jump_over_length=w_c / H,
        )
        if self.bulk is None:
            return own
        of_bulk: Any = self.bulk.parameters()
        names: Any = type(of_bulk)
        return wrapped_parameters(names)(*own, *of_bulk)

    def initial_state(self) -> tuple[float, ...]:
        return (0.0,) * self.first_of_bulk + (self.bulk.initial_state() if self.bulk else ())

    def yield_function(self, stress: ArrayLike, state: Array) -> Array:
        """Largest principal stress less f_t where intact; by the traction on a crack, |t| of an open one [Pa]; or that
        of `bulk`, over its p0 where it is one of Pa²."""
        stress, state = np.asarray(stress, float), np.asarray(state, float)
        found = crack_excess(self, stress, state)
        if self.bulk is not None:
            of_bulk = self.bulk.yield_function(stress, state[..., self.first_of_bulk :])
            found = np.maximum(found, of_bulk / self._pressure_of_bulk)
        return found

    @property
    def _pressure_of_bulk(self):
        """What makes its yield function one of Pa."""
        return (self.bulk and self.bulk.get("p0")) or 1.0

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """Of the intact material, whose largest principal stress is at most −p + 2q/3."""
        state = np.asarray(state)
        found = 2.0 / 3.0 * np.asarray(q) - np.asarray(p) - self.strength + 0.0 * state[..., 0]
        if self.bulk is not None:
            of_bulk = self.bulk.yield_of_invariants(p, q, state[..., self.first_of_bulk :])
            found = np.maximum(found, of_bulk / self._pressure_of_bulk)
        return found

    def outputs(self, state: Array) -> dict[str, Array]:
        """damage: share of the cohesion that is lost, crack_opening [m], of two cracks the larger; cracks: how many
        have begun. Those of `bulk`, but its damage."""
        return crack_state.output_fields(self, np.asarray(state))
