"""The saw of a saw test on pictures: a blade across the column, with its edge where the cut has come to."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render.floor import saw_test_width

DEEP = 0.10
"""Of the blade along the column [m], at most SHORT of its length."""

SHORT = 0.06

THICK = 0.7
"""Of the blade, in thicknesses of the weak layer: a real one of 2 mm would not be seen."""

TEETH = 12
POINTED = 0.3
"""Share of the blade's depth that its teeth take."""

OUT = (0.06, 0.20)
"""How far the blade stands out of the column, behind it and before it [m]."""

HANDLE = (0.11, 0.5, 1.8)
"""Of the handle: length [m], depth and thickness over those of the blade."""

PRISM = np.array([[0, 1, 2], [0, 2, 3]])


@dataclass(frozen=True)
class SawBlade:
    """times (k,) [s] and edges (k,): x up to which the weak layer is cut [m]; bottom, thickness: of the weak layer
    on the grid [m]; length, width: of the column [m]; origin (3,): of the run; dimension."""

    times: np.ndarray
    edges: np.ndarray
    bottom: float
    thickness: float
    length: float
    width: float
    origin: np.ndarray
    dimension: int

    @classmethod
    def of(cls, run):
        """Of a `Run`; None where it is no saw test, or does not say where its weak layer lies."""
        test = run.saw_test
        if test is None or "length" not in test.about:
            return None
        try:
            scene = run.scene
            layer, base = scene["saw_test"]["weak_layer"], scene["saw_test"].get("base") or {}
            cells = layer.get("cells")
            thickness = float(layer["thickness"]) if cells is None else cells * float(scene["solver"]["dx"])
            bottom = float(base.get("thickness", 0.0))
        except (InputError, LookupError, TypeError, ValueError, AttributeError):
            return None
        times, edges = np.asarray(test["time"], float), np.asarray(test["saw"], float)
        if not len(times):
            times, edges = np.zeros(1), np.array([float(test.about.get("notch") or 0.0)])
        return cls(times, edges, bottom, thickness, float(test.about["length"]), saw_test_width(run), run.origin,
                   run.dimension)

    def edge(self, time):
        """x of the edge [m] along the column at a time [s]."""
        return float(np.interp(time, self.times, self.edges))

    def label(self, time, side):
        """(place (3,), words): where the edge is, on a side (1 or -1) of y, and the length of the cut."""
        edge = self.edge(time)
        across = 0.0 if self.dimension == 2 else side * (0.5 * self.width + OUT[1] + HANDLE[0])
        level = 0.0 if self.dimension == 2 else self.bottom + 0.5 * self.thickness
        return np.array([edge, across, level]) - self.origin, f"saw, cut {edge:.2f} m"

    def placed(self, time, side):
        """Vertices (n, 3) [m] relative to the run's origin and facets, triangles or segments, at a time [s]; its handle
        is on a side (1 or -1) of y."""
        edge, depth = self.edge(time), min(DEEP, SHORT * self.length)
        middle = self.bottom + 0.5 * self.thickness
        half, back, teeth = 0.5 * THICK * self.thickness, edge - depth, edge - POINTED * depth
        if self.dimension == 2:
            ring = np.array([[back, 0.0, middle - half], [teeth, 0.0, middle - half], [edge, 0.0, middle],
                             [teeth, 0.0, middle + half], [back, 0.0, middle + half]])
            return ring - self.origin, np.column_stack([np.arange(5), np.roll(np.arange(5), -1)])
        ends = side * np.array([-0.5 * self.width - OUT[0], 0.5 * self.width + OUT[1]])
        along = np.linspace(*ends, 2 * TEETH + 1)
        parts = [([back, teeth], ends, [middle - half, middle + half])]
        thick, deep = HANDLE[2] * half, HANDLE[1] * depth
        grip = np.array([ends[1], ends[1] + side * HANDLE[0]])
        parts.append(([back, back + deep], grip, [middle - thick, middle + thick]))
        vertices, facets, count = [], [], 0
        for part in parts:
            corners, triangles = _box(*part)
            vertices.append(corners)
            facets.append(triangles + count)
            count += len(corners)
        for k in range(TEETH):
            a, tip, b = along[2 * k : 2 * k + 3]
            vertices.append(np.array([[teeth, a, middle], [edge, tip, middle], [teeth, b, middle]]))
            facets.append(np.array([[count, count + 1, count + 2]]))
            count += 3
        return np.concatenate(vertices) - self.origin, np.concatenate(facets)


def _box(x, y, z):
    """Corners (8, 3) and triangles (12, 3) of a box between two ends each of x, y and z."""
    corners = np.array([[a, b, c] for a in x for b in y for c in z], float)
    faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    return corners, np.concatenate([np.array(face)[PRISM] for face in faces])
