"""Base class of reference solutions (answers)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class History:
    """A curve of the run and the one that is known: labels of the axes; x, y (n,) and known_x, known_y (m,)."""

    x_label: str
    y_label: str
    x: np.ndarray
    y: np.ndarray
    known_x: np.ndarray
    known_y: np.ndarray


class Answer:
    """An empty answer; `snowmpm.comparison.answers` defines its parts."""

    SOURCE = ""

    def __init__(self, case, reference):
        self.case, self.reference = case, reference

    def quantities(self):
        """Numbers of the run with their reference, each a `Quantity`."""
        return []

    def facts(self):
        """Further facts by name."""
        return {}

    def profile(self):
        """The reference line of the surface, or None."""
        return None

    def history(self):
        """A `History`, or None."""
        return None

    def centre(self):
        """Origin of distances, or None."""
        return None
