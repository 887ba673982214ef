"""Where a flow may hold snow: the tiles that kernels work on, and the window around them that the host looks at."""

import numpy as np

from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.volumes.arrays import TILE, Tiles

AWAKE = 3
"""Steps without a look for snow in new tiles, fewer than these have cells."""


class LiveTiles:
    """Live are the tiles that hold snow, or have it next to them. tiles: `arrays.Tiles` for kernels; at_edge: whether
    cells where snow is lost lie in the window."""

    def __init__(self, store, outside, cleared):
        """store: `FlowCells`, whose box is kept to the window; outside (nx + 2 MARGIN, ny + 2 MARGIN): cells where snow
        is lost; cleared: arrays, a row a cell, that are 0 but in live tiles."""
        nx, ny = store.state_array.shape[:2]
        rows = -(-ny // TILE)
        live = np.ones(-(-nx // TILE) * rows, np.int32)
        self.tiles = Tiles(live, len(live), rows, nx, ny)
        self._live, self._store, self._outside = live.reshape(-1, rows), store, outside
        self._cleared = [array.reshape(nx, ny, *array.shape[1:]) for array in cleared]
        self.everywhere()

    def everywhere(self):
        """Snow may be in any tile; to be called when it has come to cells otherwise than by a step."""
        self._window, self._asleep, self.at_edge = None, 0, True
        self._store.everywhere()

    def all_live(self):
        """Take all tiles for live."""
        self._live[:] = 1

    def wake(self):
        """Look which tiles are live; what others held of a step before is cleared. Snow gets no further than a cell in
        a step: a look at every fourth of them is soon enough."""
        if self._asleep > 0:
            self._asleep -= 1
            return
        self._asleep = AWAKE
        (i0, i1), (j0, j1) = self._tiles_within()
        i0, i1, j0, j1 = max(i0 - 1, 0), min(i1 + 1, self._live.shape[0]), max(j0 - 1, 0), min(j1 + 1, self.tiles.rows)
        wet = self._store.state_array[i0 * TILE : i1 * TILE, j0 * TILE : j1 * TILE, 0] > 0.0
        padded = np.zeros(((i1 - i0) * TILE, (j1 - j0) * TILE), bool)
        padded[: wet.shape[0], : wet.shape[1]] = wet
        held = padded.reshape(i1 - i0, TILE, j1 - j0, TILE).any(axis=(1, 3))
        wide = np.pad(held, 1)
        near = np.any([wide[i : i + i1 - i0, j : j + j1 - j0] for i in range(3) for j in range(3)], axis=0)
        for i, j in np.argwhere((self._live[i0:i1, j0:j1] > 0) & ~near) + np.array([i0, j0]):
            for array in self._cleared:
                array[i * TILE : (i + 1) * TILE, j * TILE : (j + 1) * TILE] = 0.0
        self._live[i0:i1, j0:j1] = near
        self._narrow(near, (i0, j0))

    def _narrow(self, near, corner):
        """Keep window and box to the live tiles. Snow that goes over a periodic side comes back anywhere."""
        some = [np.flatnonzero(near.any(axis=axis)) for axis in (1, 0)]
        if self._store.repeats.any() or not len(some[0]):
            return
        self._window = tuple((int(first + one[0]), int(first + one[-1]) + 1)
                             for first, one in zip(corner, some, strict=True))
        self.at_edge = bool(self._outside[self.part()].any())
        self._store.box = tuple(
            slice(min(max(low * TILE - MARGIN, 0), n), min(max(high * TILE - MARGIN, 0), n))
            for (low, high), n in zip(self._window, self._store.grid.shape.tolist(), strict=True))

    def lost(self):
        """Numbers (k,) of the cells with snow where it is lost."""
        if not self.at_edge:
            return np.zeros(0, int)
        part = self.part()
        wet = self._store.state_array[..., 0][part] > 0.0
        at = np.argwhere(self._outside[part] & wet) + np.array([one.start for one in part])
        return np.ravel_multi_index(tuple(at.T), self._outside.shape)

    def part(self):
        """Slices (2,) of the cells, those beyond the sides included, that may hold snow."""
        return tuple(slice(low * TILE, high * TILE) for low, high in self._tiles_within())

    def _tiles_within(self):
        """First tile and one past the last, along both axes, of those that may hold snow."""
        return self._window or ((0, self._live.shape[0]), (0, self.tiles.rows))
