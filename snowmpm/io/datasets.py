"""A run as xarray data sets: labelled, with units, in map coordinates. Needs xarray, of the extra `xarray`."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.labels import attributes
from snowmpm.io.status import cautions

AXES = ["x", "y", "z"]
COMPONENTS = ["xx", "yy", "zz", "xy", "yz", "xz"]


def require_xarray():
    """The package. Raises InputError, with the command to install it."""
    try:
        import xarray
    except ImportError:
        raise InputError("data sets need xarray: pip install 'snowmpm[xarray]'") from None
    return xarray


def dataset(run, what):
    """Data set `what` of a run -> xarray.Dataset; see `Run.to_xarray`."""
    if what not in DATASETS:
        raise InputError.not_in("data set", what, list(DATASETS))
    xarray = require_xarray()
    found = DATASETS[what](run, xarray)
    found.attrs |= {"title": run.name, "source": f"snowmpm {run.provenance.get('version', '')}".strip(),
                    "complete": int(run.complete), "not_final": " ".join(cautions(run))}
    if run.provenance.get("crs"):
        found.attrs["crs_wkt"] = run.provenance["crs"]
    return found


def history(run, xarray):
    """The time series, over time."""
    names = [name for name in run.history if name != "time"]
    values = {name: ("time", run.history[name], attributes(name, run.units.get(name))) for name in names}
    return xarray.Dataset(values, {"time": ("time", run.history["time"], attributes("time", "s"))})


def particles(run, xarray):
    """All frames, over time and particle, read on demand."""
    from snowmpm.io.lazy_frames import FrameArray

    sizes = {"time": len(run), "particle": max((run.n_points(i) for i in range(len(run))), default=0)}
    coordinates = {"time": ("time", run.times, attributes("time", "s")), "axis": AXES,
                   "particles": ("time", np.array([run.n_points(i) for i in range(len(run))]),
                                 {"long_name": "number of particles; rows beyond it are empty", "units": "1"})}
    values = {}
    for name in ("position", *run.field_names):
        lazy = FrameArray(run, name, sizes["particle"])
        tail = () if len(lazy.shape) == 2 else ("axis",) if lazy.shape[2] == 3 else ("component",)
        if tail == ("component",):
            coordinates["component"] = COMPONENTS
        unit = "m" if name == "position" else run.units.get(name)
        values[name] = (("time", "particle", *tail), lazy.variable_data(xarray), attributes(name, unit))
    return xarray.Dataset(values, coordinates)


def maps(run, xarray):
    """Rasters in plan over y and x, the middle of each cell in map coordinates; of a run in 3-D, at its end."""
    if not run.maps:
        raise InputError(f"{run.path}: no maps: they are made of runs in three dimensions, at their end")
    found = {}
    for name, raster in run.maps.items():
        rows, columns = raster.values.shape
        x, y = (run.origin[k] + start + raster.cell * np.arange(n)
                for k, (start, n) in enumerate(((raster.x0, columns), (raster.y0, rows))))
        found[name] = xarray.DataArray(raster.values, {"y": ("y", y, attributes("y", "m")),
                                                       "x": ("x", x, attributes("x", "m"))},
                                       attrs=attributes(name, raster.units))
    return xarray.Dataset(found)


def saw_test(run, xarray):
    """A propagation saw test: over time, and over x along the column."""
    test = run.saw_test
    if test is None:
        raise InputError(f"{run.path}: not a saw test")
    coordinates = {name: (name, test[name], attributes(name, test.units[name])) for name in ("time", "x")}
    values = {}
    for name, data in test.values.items():
        if name not in coordinates:
            dims = ("time", "x") if data.ndim == 2 else ("x",) if name in test.bins else ("time",)
            values[name] = (dims, data, attributes(name, test.units[name]))
    return xarray.Dataset(values, coordinates)


DATASETS = {"history": history, "particles": particles, "maps": maps, "saw_test": saw_test}
"""Functions (run, xarray) -> Dataset by name."""
