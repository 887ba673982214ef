"""A single material point driven along a path of deformation, or of strains and stresses."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, Precision, Whole
from .law import Law
from .loading_stage import LoadingError, LoadingStage
from .mixed_control import MixedControl, Reached
from .stress_update import StressUpdate
from .symmetric import invariants, pack, unpack


@dataclass(frozen=True, repr=False)
class Path:
    """What a material point did, one row for each step of the path.

    kirchhoff (n, 3, 3) [Pa], tension positive; p [Pa], compression positive; q [Pa]; p0 [Pa] (NaN where the law has
    none); elastic_strain (n, 3, 3), the Hencky strain (NaN for a rate law); plastic_volumetric_strain ln det Fp since
    F = I (compaction negative); state (n, n_state); dissipation, summed from the start [J/m³]; iterations of each step;
    deformation F (n, 3, 3).
    """

    kirchhoff: Array
    p: Array
    q: Array
    p0: Array
    elastic_strain: Array
    plastic_volumetric_strain: Array
    state: Array
    dissipation: Array
    iterations: Whole
    deformation: Array

    def __repr__(self) -> str:
        if not len(self.p):
            return "Path(no steps)"
        failed = int((self.iterations < 0).sum())
        return (f"Path({len(self.p)} steps, p = {self.p[-1]:.4g} Pa, q = {self.q[-1]:.4g} Pa at the end, dissipation"
                f" {self.dissipation[-1]:.4g} J/m3" + (f", {failed} steps failed)" if failed else ")"))

    @property
    def cauchy(self) -> Array:
        """Cauchy stress σ = τ / det F (n, 3, 3) [Pa]; a path starts in the reference configuration."""
        return self.kirchhoff / np.linalg.det(self.deformation)[:, None, None]


class MaterialPoint:
    """A law at one point: `MaterialPoint(law).drive(F)`.

    precision "f32" or "f64"; dimension 3, or 2 for plane strain (the same stresses from 2×2 gradients).
    """

    law: Law
    dimension: int
    precision: Precision

    def __init__(self, law: Law, precision: Precision = "f64", dimension: int = 3) -> None:
        self.law, self.dimension, self.precision = law, dimension, precision
        self._update = StressUpdate(law, dimension, precision)

    def __repr__(self) -> str:
        return f"MaterialPoint({self.law.kind}, {self.precision}, {self.dimension}-D)"

    def drive(self, F: ArrayLike, dt: float = 1.0, stress: ArrayLike | None = None) -> Path:
        """Follow total deformation gradients F (n, d, d), starting from I with the law's initial state -> `Path`.

        Each step uses the exact relative gradient f = F_n F_(n−1)⁻¹; dt is the time of a step [s].
        stress: initial Kirchhoff stress (3, 3) [Pa], zero by default; rate laws need one.
        Raises ValueError for a path that is not (n, d, d), not finite, or has det F <= 0, and for an initial stress
        that the law's initial state does not admit; LoadingError, which names the step, where the law fails.
        """
        F = np.asarray(F, float)
        d = self.dimension
        if F.ndim != 3 or F.shape[1:] != (d, d):
            raise ValueError(f"F must have shape (n, {d}, {d}), not {F.shape}")
        if not np.isfinite(F).all() or (np.linalg.det(F) <= 0.0).any():
            raise ValueError("F must be finite with det F > 0 all along the path")
        before = np.concatenate([np.eye(d)[None], F[:-1]])
        increments = (F - before) @ np.linalg.inv(before)
        start = self._initial(stress)
        integrated = self._update.integrate(
            pack(self.law.h_from_stress(start), d)[None], self._update.initial_state(1), increments[None], dt
        )
        failed = np.flatnonzero(integrated.iterations[0] < 0)
        if len(failed):
            raise LoadingError(f"step {failed[0] + 1}: the stress update failed; smaller steps may help",
                               int(failed[0]) + 1)
        whole = np.tile(np.eye(3), (len(F), 1, 1))
        whole[:, :d, :d] = F
        return _path(self.law, whole, integrated.stress[0], integrated.state[0], integrated.dissipation[0],
                     integrated.iterations[0], start)

    def load(self, stages: Iterable[LoadingStage], stress: ArrayLike | None = None) -> Path:
        """Follow `LoadingStage`s of strains and Cauchy stresses (mixed control, see `MixedControl`) -> `Path`.

        stress: as in `drive`. Raises LoadingError, which names the step, for a stress that cannot be reached;
        ValueError for a point in plane strain: prescribe zero strain out of the plane instead.
        """
        if self.dimension != 3:
            raise ValueError("mixed control needs dimension = 3")
        control, start = MixedControl(self.law, self.precision), self._initial(stress)
        return path_of(self.law, control.follow_stages(stages, control.at_stress(start)), start)

    def _initial(self, stress: ArrayLike | None) -> Array:
        """The initial stress (3, 3), which must be admissible."""
        stress = np.zeros((3, 3)) if stress is None else np.asarray(stress, float)
        if stress.any() and not self.law.yield_function(stress, self._update.initial_state(1)[0]) <= 0.0:
            raise ValueError("the initial stress lies outside the law's yield surface")
        return stress


def path_of(law: Law, rows: Sequence[Reached], start: Array | None = None) -> Path:
    """`Path` of a list of `Reached`, which began at F = I and the Kirchhoff stress `start` (3, 3) [Pa], or none."""
    start = np.zeros((3, 3)) if start is None else start
    F, stress, state, dissipation, iterations = (np.array(column) for column in zip(*(
        (row.deformation, row.kirchhoff, row.state, row.dissipation, row.iterations) for row in rows), strict=True))
    return _path(law, F, stress, state, dissipation, iterations, start)


def _path(law: Law, F: Array, stress: Array, state: Array, dissipation: Array, iterations: Whole, start: Array) -> Path:
    stress, state = unpack(np.asarray(stress, float)), np.asarray(state, float)
    strain = law.hencky_from_stress(stress, state)
    p, q = invariants(stress)
    elastic_volume = np.trace(strain, axis1=1, axis2=2) - np.trace(law.hencky_from_stress(start))
    return Path(
        kirchhoff=stress,
        p=p,
        q=q,
        p0=np.asarray(law.outputs(state).get("p0", np.full(len(F), np.nan))),
        elastic_strain=strain,
        plastic_volumetric_strain=np.log(np.linalg.det(F)) - elastic_volume,
        state=state,
        dissipation=np.cumsum(dissipation, dtype=float),
        iterations=np.asarray(iterations),
        deformation=F,
    )
