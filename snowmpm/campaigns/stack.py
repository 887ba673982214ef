"""All maps of a campaign in one array: maps.zarr/VARIANT/runs, over run, y and x in map coordinates.

Cells without snow are 0 (arrival_time: NaN); runs that failed are NaN. The runs' map cells have one side and lie on the
same lines, so that they are put together without interpolation.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.campaigns import untrusted
from snowmpm.campaigns.work import MAPPED, MAPS
from snowmpm.errors import InputError
from snowmpm.quantities.table import RASTERS, units_of
from snowmpm.stages import counted

STORE = "maps.zarr"
BLOCK = 1 << 26
"""Bytes of one raster of a block of runs."""

FORMAT = {"consolidated": False}


@dataclass(frozen=True)
class Window:
    """Cells of all runs: corner (2,) [m] of the first, cell [m], shape (rows, columns)."""

    corner: np.ndarray
    cell: float
    shape: tuple

    def place(self, corner, shape):
        """Slices (rows, columns) of a raster of this corner and shape."""
        column, row = np.round((np.asarray(corner) - self.corner) / self.cell).astype(int)
        return np.s_[row : row + shape[0], column : column + shape[1]]

    @property
    def x(self):
        """Middles of the columns [m]."""
        return np.round(self.corner[0] + self.cell * (np.arange(self.shape[1]) + 0.5), 6)

    @property
    def y(self):
        """Middles of the rows [m]."""
        return np.round(self.corner[1] + self.cell * (np.arange(self.shape[0]) + 0.5), 6)


def window_of(files):
    """`Window` around the rasters of maps.npz files. Raises InputError where their cells differ."""
    low, high, cell = np.full(2, np.inf), np.full(2, -np.inf), None
    for file in counted(files, "looking at maps", "runs"):
        maps = untrusted.maps(file, MAPPED[:1])
        own, corner, shape = float(maps["cell"]), maps["corner"], maps[MAPPED[0]].shape
        cell = cell or own
        if abs(own - cell) > 1e-6 * cell:
            raise InputError(f"{file}: map cells of {own:g} m, others of {cell:g} m: set maps.cell")
        low = np.minimum(low, corner)
        high = np.maximum(high, corner + cell * np.array(shape[::-1]))
    columns, rows = np.round((high - low) / cell).astype(int).tolist()
    return Window(low, cell, (rows, columns))


def write_stack(plan, variant, records):
    """Write the stack of a variant; -> whether it has maps. records: of the runs, by hash."""
    import xarray

    members = [member for member in plan.members if member.variant == variant]
    files = {member.run: plan.results(member) / MAPS for member in members
             if records.get(member.hash, {}).get("status") == "done"}
    files = {run: file for run, file in files.items() if file.exists()}
    if not files:
        return False
    window, units = window_of(list(files.values())), units_of(RASTERS)
    together = int(np.clip(BLOCK // (4 * window.shape[0] * window.shape[1]), 1, 256))
    chunks = (together, *(min(n, 128) for n in window.shape))
    for begin in counted(range(0, len(members), together), "stacking maps", "blocks of runs"):
        part = members[begin : begin + together]
        values = {name: np.full((len(part), *window.shape), np.nan, np.float32) for name in MAPPED}
        for k, member in enumerate(part):
            if member.run in files:
                _put(values, k, files[member.run], window)
        data = {name: (("run", "y", "x"), array, {"units": units[name]}) for name, array in values.items()}
        block = xarray.Dataset(data, {"run": [member.run for member in part], "x": ("x", window.x, {"units": "m"}),
                                      "y": ("y", window.y, {"units": "m"})}, {"cell": window.cell})
        encoding = {name: {"chunks": chunks} for name in MAPPED} if begin == 0 else None
        block.to_zarr(plan.folder / STORE, group=f"{variant}/runs", mode="w" if begin == 0 else "a",
                      append_dim=None if begin == 0 else "run", encoding=encoding, **FORMAT)
    return True


def _put(values, k, file, window):
    maps = untrusted.maps(file, MAPPED)
    for name, array in values.items():
        raster = maps[name]
        if name != "arrival_time":
            array[k] = 0.0
            raster = np.nan_to_num(raster)
        array[k][window.place(maps["corner"], raster.shape)] = raster


def open_stack(folder, variant, what="runs"):
    """`xarray.Dataset` of the runs' maps, or of "maps" made of them; None where there is none."""
    import xarray

    # The groups that hold it too: zarr reads their metadata
    for place in (folder / STORE, folder / STORE / variant):
        untrusted.require_plain_group(place)
    untrusted.require_plain_store(folder / STORE / variant / what)
    try:
        found = xarray.open_zarr(folder / STORE, group=f"{variant}/{what}", chunks=None, consolidated=False)
        _require_whole(found, what)
        return found
    except (FileNotFoundError, KeyError):
        return None
    except Exception as error:  # zarr and xarray raise many kinds for what is torn or foreign
        raise untrusted.damaged(folder / STORE / variant / what, error) from None


def _require_whole(found, what):
    """ValueError for a data set that lacks what this program writes."""
    wanted = {"cell"} if what == "runs" else {"cell", "campaign", "scene", "meaning", "runs"}
    if missing := sorted(wanted - set(found.attrs)):
        raise ValueError(f"has no {', '.join(missing)}")
    if not isinstance(found.attrs["cell"], int | float) or not {"x", "y"} <= set(found.dims):
        raise ValueError("cell, x or y are missing or of another kind")
    for name, one in found.data_vars.items():
        if one.ndim < 2 or one.dims[-2:] != ("y", "x"):
            raise ValueError(f"{name} is no map")
        one.isel(dict.fromkeys(one.dims[:-2], 0)).load()  # a block of it, so that one that is cut off is met here
