"""A crack with a thickness and an energy of its own within a particle: the double-scale law in its cohesive limit."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
import taichi as ti
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from .arrays import Array
from .crack_return import crack_return
from .elastic import elastic_trial
from .hencky import deviation_of_strain
from .law import Law, Positive, StateVariable
from .precision import by_precision
from .spectral import eigen_of_deviator
from .symmetric import COMPONENTS, PAIRS, contract, plus_isotropic, trace, unpack

DAMAGE, OPENING, NORMAL = 0, 1, 2


class CohesiveCrackParameters(NamedTuple):
    """What the update of `CohesiveCrack` reads."""

    K: float  # bulk modulus [Pa]
    shear_modulus: float  # G [Pa]
    strength: float  # f_t [Pa]
    friction: float  # μ [-]
    beta: float  # β [-]
    per_beta: float  # 1/β [-]
    per_weight: float  # 1/β² [-]
    normal: float  # M w_c/H: fall of t_n per damage [Pa]
    shear: float  # G w_c/H: fall of t_s per damage [Pa]
    normal_per_metre: float  # M/H [Pa/m]
    jump_over_length: float  # w_c/H [-]


@ti.func
def traction(tau, n):
    """τ n of a tensor of 4 or 6 entries."""
    t = ti.Vector([tau[0] * n[0] + tau[3] * n[1], tau[3] * n[0] + tau[1] * n[1], tau[2] * n[2]])
    if ti.static(tau.n == 6):
        t += ti.Vector([tau[5] * n[2], tau[4] * n[2], tau[5] * n[0] + tau[4] * n[1]])
    return t


@ti.func
def normal_of(state):
    """Unit normal of the crack from n ⊗ n in the state, its sign left open; zero where there is none."""
    N = ti.Vector([state[NORMAL + k] for k in ti.static(range(6))])
    n = ti.Vector([N[0], N[3], N[5]])
    if N[1] > N[0] and N[1] >= N[2]:
        n = ti.Vector([N[3], N[1], N[4]])
    elif N[2] > N[0] and N[2] > N[1]:
        n = ti.Vector([N[5], N[4], N[2]])
    # Its largest column; rounding leaves a little of other directions, which two products square away
    n = traction(N, traction(N, n))
    return n / ti.max(n.norm(), ti.static(by_precision(1e-30, 1e-200)))


@ti.func
def carried_along(n, A):
    """Normal of a plane of the material after the step f = I + A: along f⁻ᵀ n, so along the cofactors of f."""
    f = A + ti.Matrix.identity(float, A.n)
    m = n
    if ti.static(A.n == 3):
        columns = [ti.Vector([f[0, j], f[1, j], f[2, j]]) for j in ti.static(range(3))]
        m = n[0] * columns[1].cross(columns[2]) + n[1] * columns[2].cross(columns[0])
        m += n[2] * columns[0].cross(columns[1])
    else:
        m = ti.Vector([f[1, 1] * n[0] - f[1, 0] * n[1], f[0, 0] * n[1] - f[0, 1] * n[0], f.determinant() * n[2]])
    return m / ti.max(m.norm(), ti.static(by_precision(1e-30, 1e-200)))


@ti.func
def cohesive_crack_update(prm: ti.template(), h, state, A, dt):
    """`Law.update` of `CohesiveCrack`."""
    h_new, deviator, volume, deviator2, valid = elastic_trial(h, A)
    G, K = prm.shear_modulus, prm.K
    tau = plus_isotropic(2.0 * G * deviator, K * volume)
    state_new = state
    dissipation, iterations, cracked = 0.0, 0, False
    n = ti.Vector.zero(float, 3)
    if valid == 1:
        cracked = state[NORMAL] + state[NORMAL + 1] + state[NORMAL + 2] > 0.5
        if cracked:
            n = carried_along(normal_of(state), A)
        elif K * volume + ti.static(2.0 * (2.0 / 3.0) ** 0.5) * G * ti.sqrt(deviator2) > prm.strength:
            # The first principal stress is at most −p + 2q/3
            w, V = eigen_of_deviator(deviator, deviator2)
            if K * volume + 2.0 * G * w[0] > prm.strength:
                cracked = True
                n = ti.Vector([V[0, 0], V[1, 0], V[2, 0]])
    if cracked:
        t = traction(tau, n)
        t_n = t.dot(n)
        along = t - t_n * n
        t_s = along.norm()
        along /= ti.max(t_s, ti.static(by_precision(1e-30, 1e-200)))
        n_new, s_new, damage, opening, dissipation, iterations = crack_return(
            prm, t_n, t_s, state[DAMAGE], state[OPENING]
        )
        if iterations != 0:
            opened, slipped = (t_n - n_new) / (K + ti.static(4.0 / 3.0) * G), (t_s - s_new) / G
            strain = deviator
            for k in ti.static(range(h.n)):
                i, j = ti.static(PAIRS[k])
                strain[k] -= opened * n[i] * n[j] + 0.5 * slipped * (n[i] * along[j] + along[i] * n[j])
            deviator = plus_isotropic(strain, -trace(strain) / 3.0)
            volume -= opened
            tau = plus_isotropic(2.0 * G * deviator, K * volume)
            h_new = deviation_of_strain(deviator, volume, contract(deviator, deviator), 1.0)
            state_new[DAMAGE], state_new[OPENING] = damage, opening
        for k in ti.static(range(6)):
            i, j = ti.static(PAIRS[k])
            state_new[NORMAL + k] = n[i] * n[j]
    return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, -1)


class CohesiveCrack(Law):
    """Elastic material that cracks where its largest principal stress reaches its strength: a band within the particle.

        τ̇ = D : (ε̇ − (1/H) sym(n ⊗ u̇)),   ṫ = K^i u̇,   τ n = t                                    [B 107-109]

    [B] Bui and Nguyen (2021), "Smoothed particle hydrodynamics (SPH) and its applications in geomechanics",
    doi:10.1016/j.compgeo.2021.104315, section 3.2.3: double-scale kinematics of a particle of length H with a band of
    normal n, in the limit f = h_l/H → 0 of a band that is thin beside its particle, in which thickness and stiffness of
    the band are gathered in its traction law. [B] leave onset and that law open. Here:

    onset    the largest principal stress reaches f_t; n is its direction, and moves on as a plane of the material
    band     cohesion that fades linearly with the jump, then friction between its faces (crack_return.py)

    Keys: f_t `strength`, G_f `fracture_energy`, β `shear_ratio` (strength in shear over f_t), μ from
    `friction_angle`, H `length`. H is the size of the cell in MPM and the spacing of particles in SPH (`on_grid`): a
    crack in one row of them takes G_f per area on every grid. In MPM that asks for `solver.f_bar = "whole"`; in SPH it
    was not measured. Rows larger than

        2 G_f min(M, G/β²) / f_t²,    M = K + 4G/3

    would snap back and are refused.

    Deviations and limits. One band per particle, whose plane does not change: across it the material may carry more
    than f_t. No crack begins in compression or shear, though one that is there slides. The jump that bonds took is not
    undone by unloading; once they are gone the whole opening must close before the faces press. At equal principal
    stresses the plane is not defined by the stress, and round-off decides.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("crack_damage", "-", "ω: share of the cohesion that the crack has lost"),
        StateVariable("crack_opening", "m", "w: normal jump of the crack"),
        *(StateVariable(f"crack_normal_{c}", "-", f"{c} of n ⊗ n, n the normal of the crack; zero without one")
          for c in COMPONENTS),
    )  # fmt: skip
    TENSORS: ClassVar[tuple[int, ...]] = (NORMAL,)
    OUTPUTS: ClassVar[dict[str, str]] = {"damage": "-", "crack_opening": "m"}
    BONDS: ClassVar[int] = DAMAGE

    kind: Literal["cohesive_crack"] = "cohesive_crack"
    strength: Positive  # f_t [Pa]
    fracture_energy: Positive  # G_f [J/m²]
    shear_ratio: Positive = 1.0  # β [-]
    friction_angle: Annotated[float, Field(ge=0.0, lt=90.0)] = 0.0  # of the faces of a crack [deg]
    length: Positive | None = None  # H [m]; none: the solver's cell or spacing

    update = staticmethod(cohesive_crack_update)

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

    def on_grid(self, spacing: float) -> "Law":
        if self.length is not None:
            return self
        if not spacing < self.largest_length:
            raise ValueError(f"fracture_energy = {self.fracture_energy:g} J/m2 and strength = {self.strength:g} Pa need"
                             f" cells below {self.largest_length:.2g} m, not {spacing:g}: a longer one snaps back")
        return self.model_copy(update={"length": spacing})

    @property
    def tensile_strength(self) -> float:
        return self.strength

    @property
    def complete_opening(self) -> float:
        """w_c = 2 G_f/f_t: the jump at which no cohesion is left [m]."""
        return 2.0 * self.fracture_energy / self.strength

    @property
    def friction_exceeds_dilation(self) -> bool:
        return self.friction_angle > 0.0

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

    def parameters(self) -> CohesiveCrackParameters:
        H, w_c, G = self._length, self.complete_opening, self.shear_modulus
        M = self.bulk_modulus + 4.0 / 3.0 * G
        return CohesiveCrackParameters(
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

    def initial_state(self) -> tuple[float, ...]:
        return (0.0,) * len(self.STATE)

    def yield_function(self, stress: ArrayLike, state: Array) -> Array:
        """Largest principal stress less f_t where intact; by the traction on a crack, |t| of an open one [Pa]."""
        stress, state = np.asarray(stress, float), np.asarray(state, float)
        values, vectors = np.linalg.eigh(unpack(state[..., NORMAL : NORMAL + 6]))
        n = vectors[..., -1]
        t = np.einsum("...ij,...j->...i", stress, n)
        t_n = np.einsum("...i,...i->...", t, n)
        t_s = np.linalg.norm(t - t_n[..., None] * n, axis=-1)
        left, friction = self.strength * (1.0 - state[..., DAMAGE]), np.tan(np.radians(self.friction_angle))
        pressed = (t_s + friction * t_n) / self.shear_ratio - left
        closed = np.where(t_n > 0.0, np.hypot(t_n, t_s / self.shear_ratio) - left, pressed)
        apart = (state[..., DAMAGE] >= 1.0) & (state[..., OPENING] > 0.0)
        intact = np.linalg.eigvalsh(stress)[..., -1] - self.strength
        return np.where(values[..., -1] < 0.5, intact, np.where(apart, np.abs(t_n) + t_s, closed))

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """Of the intact material, whose largest principal stress is at most −p + 2q/3."""
        return 2.0 / 3.0 * np.asarray(q) - np.asarray(p) - self.strength + 0.0 * np.asarray(state)[..., 0]

    def outputs(self, state: Array) -> dict[str, Array]:
        """damage: share of the cohesion that is lost; crack_opening [m]."""
        state = np.asarray(state)
        return {"damage": state[..., DAMAGE], "crack_opening": state[..., OPENING]}
