"""The contract of a constitutive law: what a solver, a scene and an output file may ask of it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict, Field

from snowmpm.keys import TABLE_CONFIG, Keyed
from snowmpm.registry import LAWS

from .arrays import Array
from .symmetric import invariants

REDO = -2
"""Iterations of a straight-line update (`Law.vector_update`) that `update` has to do instead."""

LARGEST = 1e12
"""More is no number of a material in SI units, and what is made of it might not fit a float32."""

Positive = Annotated[float, Field(gt=0.0, le=LARGEST, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0.0, le=LARGEST, allow_inf_nan=False)]


@dataclass(frozen=True)
class StateVariable:
    """One internal variable of a law, kept for every particle between steps."""

    name: str
    unit: str
    description: str


class Law(Keyed, BaseModel):
    """Isotropic elastoplastic law at finite strain; frozen data, checked on construction, unknown keys refused.

    Elasticity, unless a law says otherwise: τ = λ tr(ε) I + 2μ ε (Kirchhoff), Hencky strain ε = ½ ln b, b = Fe Feᵀ.
    Signs: τ > 0 in tension; p = −tr(τ)/3 > 0 in compression; q = √(3/2 s:s), always three-dimensional, also in plane
    strain. A law adds its own fields, its `kind`, STATE, OUTPUTS, `parameters`, and one function:

        update(prm, h, state, A, dt) -> (h, τ, state, dissipation, iterations)

    prm          the numbers of `parameters()` by name, see `parameters.named`; the argument must be `ti.template()`
    h            symmetric tensor at the start of the step, 6 entries, or 4 in plane strain (see symmetric.py): b − I,
                 or the Cauchy stress [Pa] of a law with STORED "stress"
    state        vector that starts with the STATE variables (longer is allowed; the rest is returned untouched)
    A            f − I, f the relative deformation gradient of the step, 3×3, or 2×2 in plane strain. It must be
                 that of the path: I + dt grad v of a velocity given at the start swells a turning body.
    dt           step [s]; only rate-dependent laws read it
    dissipation  plastic work of the step, per unit reference volume [J/m³]: τ : Δε_plastic >= 0 with the stress at its
                 end. (The elastic energy that the return takes out, ψ(ε_trial) − ψ(ε), is ½ Δε_plastic : C : Δε_plastic
                 more; summed over small steps that overshoot adds up to what no work was done for.)
    iterations   Newton iterations; 0 elastic (or stress-free); −1 the update failed: not converged, or A is not finite
                 or turns the particle inside out (det f <= 0), in which case A is ignored. Callers count and report it.

    A law may also have `vector_update`, the same function in a straight line, without loops or calls of a mathematical
    library, so that a compiler works on several particles at once (`packs.py`). Where a state is beyond it,
    `iterations` is REDO, none of the other results may be used, and `update` takes over; elsewhere it is `update` to
    round-off.

    `update` is a Taichi function, called as `Class.update(...)` from any kernel compiled in the working precision. All
    numbers arrive at run time: changing a parameter compiles nothing.
    """

    model_config = TABLE_CONFIG | ConfigDict(strict=True)

    REGISTRIES: ClassVar = (LAWS,)
    STATE: ClassVar[tuple[StateVariable, ...]] = ()
    OUTPUTS: ClassVar[dict[str, str]] = {}  # derived fields of `outputs` and their units
    STORED: ClassVar[Literal["strain", "stress"]] = "strain"  # what h is; a law that stores its stress has `stiffness`
    stiffness: ClassVar[Any] = None  # Taichi function (prm, τ, state) -> bound of ρ₀ c² [Pa], of a law that stiffens
    TENSORS: ClassVar[tuple[int, ...]] = ()  # first index in STATE of each symmetric tensor kept there, 6 entries each
    BONDS: ClassVar[int | None] = None  # index of the STATE variable that tells bonds broken, see `bonds_last_below`
    vector_update: ClassVar[Any] = None  # Taichi function like `update`, see above
    FADES: ClassVar[int | None] = None  # index of the STATE variable that strength fades with
    OF_COMPONENTS: ClassVar[tuple[str, ...]] = ()  # keys that a component computes; without one they are refused
    failure_function: ClassVar[Any] = None  # (stress, state) -> > 0 where a law without a yield surface fails
    IN_PORES: ClassVar[bool] = False  # True of a fluid in the pores of others, which takes no room of its own
    DISSIPATIVE: ClassVar[bool] = True  # False where a published law may give plastic work back
    YIELDS: ClassVar[bool] = True  # False where every deformation is undone with the load
    RATE_DEPENDENT: ClassVar[bool] = False  # True where `update` reads dt

    density: Positive
    """ρ₀, at the start [kg/m3]"""
    youngs_modulus: Positive
    """E [Pa]"""
    poisson_ratio: Annotated[float, Field(gt=-1.0, lt=0.5)]
    """ν [-]"""
    grain_diameter: Positive | None = None
    """d, for the inertial number of the output [m]"""
    grain_density: Positive | None = None
    """ρ_s, of the grains themselves [kg/m3]"""
    card: str | None = None
    """name of the material card whose numbers these are"""
    began_with: str | None = None
    """name of the card from which the numbers began, where some were changed"""
    card_source: str | None = None
    """what a card of one's own says about the origin of its numbers"""

    if TYPE_CHECKING:  # of every law, its own

        @property
        def kind(self) -> str: ...

        @property
        def update(self) -> Any: ...

    def __init_subclass__(cls, **options: Any) -> None:
        """A law with an `update` of its own does not take over the `vector_update` of another."""
        if "update" in cls.__dict__ and "vector_update" not in cls.__dict__:
            cls.vector_update = None
        super().__init_subclass__(**options)

    @property
    def bulk_modulus(self) -> float:
        """K = E / (3 (1 − 2ν)) [Pa]"""
        return self.youngs_modulus / (3.0 * (1.0 - 2.0 * self.poisson_ratio))

    @property
    def shear_modulus(self) -> float:
        """G = μ = E / (2 (1 + ν)) [Pa]"""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    def wave_speed(self) -> float:
        """Speed of the elastic P-wave at the reference density, √((K + 4G/3) / ρ₀) [m/s]."""
        return float(np.sqrt((self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus) / self.density))

    @property
    def tangent_over_elastic(self) -> float:
        """Largest stress along an axis per strain along it, over K + 4G/3: 1 unless yielding makes it stiffer [-].

        See `return_tangent`. A time step must follow it.
        """
        return 1.0

    def fastest_wave(self) -> float:
        """Bound of the speed of P-waves at the reference density [m/s], whether it yields or not."""
        return self.wave_speed() * float(np.sqrt(self.tangent_over_elastic))

    def wave_speed_at(self, stress: Array, state: Array) -> Array:
        """Bound of the speed of P-waves [m/s] (n,) at Kirchhoff stresses (n, 6), packed [Pa], and states (n, n_state).

        It is `fastest_wave` for a law of constant stiffness. For one that stiffens, a time step must follow the largest
        of these, which `stiffness` gives to a kernel as ρ₀ c² (or a little more).
        """
        return np.full(len(stress), self.fastest_wave())

    @property
    def associated(self) -> bool:
        """Whether plastic strain is normal to the yield surface that the step ends on."""
        return False

    @property
    def tensile_strength(self) -> float:
        """Isotropic tension that the initial state carries [Pa]; inf where no tension ends it."""
        return 0.0

    @property
    def friction_exceeds_dilation(self) -> bool:
        """Whether it has friction and dilates by less than normality asks for."""
        return False

    @property
    def collapses(self) -> bool:
        """Whether its bonds break under compression, one row of cells after the other."""
        return False

    @property
    def collapse_thickness(self) -> float | None:
        """Thickness [m] of the layer whose collapse the law gathers in one row of cells; None: that of the grid."""
        return None

    @property
    def of_components(self) -> dict[str, float]:
        """Those of the keys OF_COMPONENTS that are given, with their values."""
        return {key: self[key] for key in self.OF_COMPONENTS if self[key] is not None}

    @property
    def integration(self) -> str:
        """How a step is followed: "implicit", which may be in closed form, "frozen" or "substepped"."""
        return "implicit"

    def on_grid(self, spacing: float, rows: int = 1) -> "Law":
        """The law that cells of this size [m] need, so that a solver's result does not hang on them: this one, unless
        it softens over a length of its own. rows: of cells or particles that a jump takes with the solver's method.
        Raises ValueError for cells that are too large."""
        return self

    def thickened_to(self, thickness: float, new_thickness: float) -> "Law":
        """The law of a thin layer [m] that is made thicker or thinner: with the stiffness, strength and
        collapse of the layer, per area."""
        return self.model_copy(update={"youngs_modulus": self.youngs_modulus * new_thickness / thickness})

    def of_whole_layer(self, thickness: float) -> "Law":
        """The law of a layer [m] that deforms as a whole, without cells, half of whose mass rests on the ground."""
        return self.model_copy(update={"density": 0.5 * self.density})

    @property
    def lateral_pressure(self) -> float:
        """K₀ = σ_lateral / σ_axial of a first compression without lateral strain; elastic value ν / (1 − ν) [-]."""
        return self.poisson_ratio / (1.0 - self.poisson_ratio)

    def parameters(self) -> tuple[float, ...]:
        """NamedTuple of the numbers that `update` and the other Taichi functions read as `prm`, of one class for the
        class of the law (see parameters.py)."""
        raise NotImplementedError

    def initial_state(self) -> tuple[float, ...]:
        """Initial value of each STATE variable."""
        return ()

    @property
    def bonds_last_below(self) -> float:
        """Value of the state variable BONDS from which on all bonds are broken; −inf without bonds that break."""
        return -np.inf

    @property
    def bond_energy(self) -> float:
        """Plastic work per volume that breaks all bonds, about [J/m³]; 0 without bonds that break."""
        return 0.0

    def severed_state(self) -> tuple[float, ...] | None:
        """STATE of material whose bonds are cut (saw cut, removed support), or None where the law has no such state.

        The caller must also set h to zero, since a stress may not be admissible any more.
        """
        return None

    def hencky_from_stress(self, stress: ArrayLike, state: ArrayLike | None = None) -> Array:
        """Hencky strain (..., 3, 3) of a Kirchhoff stress (..., 3, 3) [Pa]; NaN where a law knows no elastic strain.

        state (..., n_state): read by laws whose stiffness depends on it, the initial one when missing.
        """
        stress = np.asarray(stress, float)
        mean = np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
        return (stress - mean) / (2.0 * self.shear_modulus) + mean / (3.0 * self.bulk_modulus)

    def h_from_stress(self, stress: ArrayLike) -> Array:
        """Stored tensor h (..., 3, 3) of a Kirchhoff stress (..., 3, 3) [Pa] in the initial state: exp(2ε) − I, or the
        stress itself where that is STORED."""
        if self.STORED == "stress":
            return np.asarray(stress, float)
        values, vectors = np.linalg.eigh(self.hencky_from_stress(stress))
        return np.einsum("...ik,...k,...jk->...ij", vectors, np.expm1(2.0 * values), vectors)

    def elastic_energy(self, stress: Array, state: Array) -> Array:
        """Recoverable energy per unit reference volume [J/m³] of Kirchhoff stresses (n, 6), packed [Pa].

        ψ = p²/(2K) + s:s/(4G) for Hencky elasticity, whatever the state (n, n_state). NumPy.
        """
        trace = stress @ [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
        square = np.einsum("ij,ij,j->i", stress, stress, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        return (square - trace**2 / 3.0) / (4.0 * self.shear_modulus) + trace**2 / (18.0 * self.bulk_modulus)

    def yield_function(self, stress: ArrayLike, state: Array) -> Array:
        """Yield function of Kirchhoff stresses (..., 3, 3) [Pa] and states (..., n_state), <= 0 where admissible.

        Its scale is the law's own (Pa or Pa²); −inf where a law never yields. NumPy.
        """
        return self.yield_of_invariants(*invariants(stress), state)

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """Yield function of a law that needs p, q [Pa] and state (..., n_state) only. Broadcasts; NumPy."""
        return np.full(np.broadcast_shapes(np.shape(p), np.shape(q), np.shape(state)[:-1]), -np.inf)

    def outputs(self, state: Array) -> dict[str, Array]:
        """Derived fields by name (see OUTPUTS), each (n,), from state (n, n_state). NumPy."""
        return {}
