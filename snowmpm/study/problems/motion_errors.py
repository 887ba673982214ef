"""How far a body is off a manufactured motion."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class MotionErrors:
    """Of displacement and stress at the end, each over a size of the case: root mean square and worst particle [-]."""

    displacement: float
    largest_displacement: float
    stress: float
    largest_stress: float

    @classmethod
    def of(cls, displacement, stress, lengths, stresses):
        """displacement, stress: errors (n, k), of size `lengths` [m] and `stresses` [Pa]."""
        return cls(*(float(value) for errors, size in ((displacement, lengths), (stress, stresses))
                     for value in _typical_and_largest(errors, size)))


def _typical_and_largest(errors, size):
    square = (errors**2).sum(axis=1)
    return np.sqrt(square.mean()) / size, np.sqrt(square.max()) / size
