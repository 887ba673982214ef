"""A single material point driven along a path of deformation."""

from dataclasses import dataclass

import numpy as np

from .stress_update import StressUpdate
from .symmetric import invariants, size, unpack


@dataclass(frozen=True)
class Path:
    """What a material point did, one row for each deformation gradient of the path.

    kirchhoff (n, 3, 3) [Pa], tension positive; p [Pa], compression positive; q [Pa]; p0 [Pa] (NaN where the law has
    none); elastic_strain (n, 3, 3), the Hencky strain; plastic_volumetric_strain ln det Fp (compaction negative);
    state (n, n_state); dissipation, summed from the start [J/m³]; iterations of each step, −1 where one failed.
    """

    kirchhoff: np.ndarray
    p: np.ndarray
    q: np.ndarray
    p0: np.ndarray
    elastic_strain: np.ndarray
    plastic_volumetric_strain: np.ndarray
    state: np.ndarray
    dissipation: np.ndarray
    iterations: np.ndarray


class MaterialPoint:
    """A law at one point: `MaterialPoint(law).drive(F)`.

    precision "f32" or "f64"; dimension 3, or 2 for plane strain (the same stresses from 2×2 gradients).
    """

    def __init__(self, law, precision="f64", dimension=3):
        self.law, self.dimension = law, dimension
        self._update = StressUpdate(law, dimension, precision)

    def drive(self, F, dt=1.0):
        """Follow total deformation gradients F (n, d, d), starting from I with the law's initial state -> `Path`.

        Each step uses the exact relative gradient f = F_n F_(n−1)⁻¹; dt is the time of a step [s].
        Raises ValueError for a path that is not (n, d, d), not finite, or has det F <= 0.
        """
        F = np.asarray(F, float)
        d = self.dimension
        if F.ndim != 3 or F.shape[1:] != (d, d):
            raise ValueError(f"F must have shape (n, {d}, {d}), not {F.shape}")
        if not np.isfinite(F).all() or (np.linalg.det(F) <= 0.0).any():
            raise ValueError("F must be finite with det F > 0 all along the path")
        before = np.concatenate([np.eye(d)[None], F[:-1]])
        increments = (F - before) @ np.linalg.inv(before)
        start = np.zeros((1, size(d)))
        followed = self._update.follow(start, self._update.initial_state(1), increments[None], dt)
        return self._path(F, followed)

    def _path(self, F, followed):
        stress = unpack(followed.stress[0].astype(float))
        strain = self.law.hencky_from_stress(stress)
        p, q = invariants(stress)
        state = followed.state[0].astype(float)
        return Path(
            kirchhoff=stress,
            p=p,
            q=q,
            p0=np.asarray(self.law.outputs(state).get("p0", np.full(len(F), np.nan))),
            elastic_strain=strain,
            plastic_volumetric_strain=np.log(np.linalg.det(F)) - np.trace(strain, axis1=1, axis2=2),
            state=state,
            dissipation=np.cumsum(followed.dissipation[0], dtype=float),
            iterations=followed.iterations[0],
        )
