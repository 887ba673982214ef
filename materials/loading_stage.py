"""A stage of a test at a material point: which strains and which stresses are prescribed along it.

    F = (I + Γ) diag(exp ε) F₀,    Γ strictly upper triangular

The six controlled strains are three logarithmic stretches ε_xx, ε_yy, ε_zz (tension positive) and three amounts of
shear Γ_xy, Γ_yz, Γ_xz, all from the start F₀ of the test. det F = exp(tr ε) det F₀ whatever the shears, and Γ_xz alone
is simple shear along x of planes normal to z, which keep their area and direction. The stress is Cauchy's, σ = τ/det F.
"""

from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array
from .symmetric import COMPONENTS, PAIRS


class LoadingError(ValueError):
    """A test that cannot be made as asked for. `step`, counted from 1: the one that failed, None if none was begun."""

    step: int | None

    def __init__(self, message: str, step: int | None = None) -> None:
        super().__init__(message)
        self.step = step


@dataclass(frozen=True)
class LoadingStage:
    """A part of a test along which prescribed strains and stresses change in proportion.

    strain, stress: values at the end of the stage by component ("xx" ... "xz"): strains from the start of the test,
    Cauchy stresses [Pa], both positive in tension. A component named in neither keeps its strain.
    steps: equal steps; duration: of the whole stage [s], read by rate-dependent laws only.
    """

    strain: dict[str, float] = field(default_factory=dict)
    stress: dict[str, float] = field(default_factory=dict)
    steps: int = 100
    duration: float = 1.0

    def __post_init__(self) -> None:
        for name, values in (("strain", self.strain), ("stress", self.stress)):
            for component, value in values.items():
                if component not in COMPONENTS:
                    raise LoadingError(f"{name} {component}: a component is one of {', '.join(COMPONENTS)}")
                if not isfinite(value):
                    raise LoadingError(f"{name} {component} = {value}: must be finite")
        both = [component for component in self.strain if component in self.stress]
        if both:
            raise LoadingError(f"strain and stress {both[0]}: only one of them can be prescribed")
        if self.steps < 1 or not (self.duration > 0.0 and isfinite(self.duration)):
            raise LoadingError("a stage takes at least one step and some time")

    def targets(self, strain: ArrayLike) -> tuple[Array, Array]:
        """(6,) strains and (6,) stresses at the end of the stage, NaN where free, for one that starts at `strain`."""
        strains, stresses = np.array(strain, float), np.full(6, np.nan)
        for component, value in self.strain.items():
            strains[COMPONENTS.index(component)] = value
        for component, value in self.stress.items():
            stresses[COMPONENTS.index(component)] = value
        strains[np.isfinite(stresses)] = np.nan
        return strains, stresses


def deformation_of(strain: ArrayLike) -> Array:
    """(I + Γ) diag(exp ε), (..., 3, 3), of controlled strains (..., 6)."""
    strain = np.asarray(strain, float)
    F = np.zeros((*strain.shape[:-1], 3, 3))
    stretch = np.exp(strain[..., :3])
    for k, (i, j) in enumerate(PAIRS):
        F[..., i, j] = stretch[..., j] * (1.0 if i == j else strain[..., k])
    return F
