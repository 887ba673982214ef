"""What the triangles of a mesh look like."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, repr=False)
class Skin:
    """Triangles of one material: vertices (n, 3) [m], facets (m, 3), places st (n, 2) on a picture, (0, 0) its lower
    left corner, outside of [0, 1] repeated; picture (rows, columns, 3) uint8, the uppermost row first."""

    vertices: Any
    facets: Any
    st: Any
    picture: Any

    def colours(self, st: Any) -> Any:
        """sRGB bytes (k, 3) at places (k, 2) on the picture, linear between its pixels."""
        rows, columns = self.picture.shape[:2]
        st = np.asarray(st, float)
        st = np.where((st >= 0.0) & (st <= 1.0), st, st % 1.0)  # 1 is the other edge, not that of the next picture
        x, y = st[:, 0] * columns - 0.5, (1.0 - st[:, 1]) * rows - 0.5
        left, top = np.floor(x).astype(int), np.floor(y).astype(int)
        across, down = (x - left)[:, None], (y - top)[:, None]
        found = 0.0
        for i, weight in ((0, 1.0 - down), (1, down)):
            for j, share in ((0, 1.0 - across), (1, across)):
                pixels = self.picture[(top + i).clip(0, rows - 1), (left + j).clip(0, columns - 1)]
                found = found + weight * share * pixels
        return found.astype(np.float32)
