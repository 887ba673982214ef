"""What every answer is made of."""

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
    """An answer that knows nothing yet; `snowmpm.comparison.answers` says what each part is."""

    SOURCE = ""

    def __init__(self, case, reference):
        self.case, self.reference = case, reference

    def quantities(self):
        """Numbers of the run beside known ones, a `Quantity` each."""
        return []

    def facts(self):
        """What else there is to say, by name."""
        return {}

    def profile(self):
        """The known line of the surface, or None."""
        return None

    def history(self):
        """A `History`, or None."""
        return None

    def centre(self):
        """Where distances are measured from, or None."""
        return None
