"""Stress along a line through a body: means of the particles around it."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError

COMPONENTS = {"xx": 0, "yy": 1, "zz": 2, "xy": 3, "yz": 4, "xz": 5}
"""Columns of a frame's stress."""


@dataclass(frozen=True)
class Line:
    """The line on which one coordinate, "x" or "z", has a value [m]; in 3-D in the plane through the middle along y."""

    axis: str
    value: float

    @classmethod
    def of(cls, text):
        """From a text such as "x=0.2". Raises InputError."""
        axis, equals, value = text.partition("=")
        try:
            if axis.strip() in ("x", "z") and equals and np.isfinite(float(value)):
                return cls(axis.strip(), float(value))
        except ValueError:
            pass
        raise InputError(f"--line {text}: must be x=METRES (upright) or z=METRES (level), such as x=0.2")

    def __str__(self):
        return f"{self.axis} = {self.value:.4g} m"


@dataclass(frozen=True)
class StressLine:
    """place (k,): along the line [m]; values: by name, compression positive (k,) [Pa]."""

    line: Line
    place: np.ndarray
    values: dict


def stress_along(case, frame, line):
    """`StressLine` of a frame: stresses along z and x where it holds `stress`, else the pressure `p`; None of a frame
    with neither, or with nothing on the line."""
    held = _values(frame)
    if held is None:
        return None
    x, spacing = case.positions(frame), case.spacing
    across, along = (x[:, 0], x[:, -1]) if line.axis == "x" else (x[:, -1], x[:, 0])
    near = np.abs(across - line.value) <= spacing
    if x.shape[1] == 3:
        near &= np.abs(x[:, 1] - x[:, 1].mean()) <= spacing
    if not near.any():
        return None
    number = np.floor(along[near] / (2.0 * spacing) + 1e-4).astype(np.int64)
    _, label, counts = np.unique(number, return_inverse=True, return_counts=True)
    means = {name: np.bincount(label, values[near]) / counts for name, values in held.items()}
    return StressLine(line, np.bincount(label, along[near]) / counts, means)


def _values(frame):
    if "stress" in frame.fields:
        stress = frame.fields["stress"]
        return {"upright": -stress[:, COMPONENTS["zz"]], "level": -stress[:, COMPONENTS["xx"]]}
    return {"pressure": frame.fields["p"]} if "p" in frame.fields else None
