"""A run whose outlines, classes and areas can be counted: a straight avalanche of known depth and pressure."""

import numpy as np
import shapely

from snowmpm.io import Run, RunWriter
from snowmpm.results import hazard

CELL, ORIGIN = 5.0, np.array([247002.5, 352001.0, 900.0])
LAMBERT = 31287


def lambert():
    """Well-known text of the Austrian Lambert projection."""
    import pyproj

    return pyproj.CRS.from_epsg(LAMBERT).to_wkt()


def write_avalanche(folder, moving=0.0, left=0.0, complete=True, crs=None, end_time=40.0):
    """Release over x = 20 to 60 m, y = 80 to 120 m; flow to x = 500 m, with a hole of 2 x 2 cells; pressure 40 kPa as
    far as x = 300 m, 5 kPa beyond; deposit of 1 m from 460 to 500 m."""
    maps = {name: np.zeros((160, 40)) for name in
            ("release_depth", "peak_depth", "peak_speed", "peak_pressure", "deposit_depth", "arrival_time")}
    maps["release_depth"][4:12, 16:24] = 1.0
    maps["deposit_depth"][92:100, 16:24] = 1.0
    maps["peak_depth"][4:100, 16:24] = 1.0
    maps["peak_depth"][50:52, 19:21] = 0.0
    flows = maps["peak_depth"] > 0.0
    x = CELL * (np.arange(160)[:, None] + 0.5)
    maps["peak_speed"][:] = np.where(flows, 12.0, 0.0)
    maps["peak_pressure"][:] = np.where(flows, np.where(x < 300.0, 4e4, 5e3), 0.0)
    maps["arrival_time"][:] = np.where(flows, np.maximum(x - 60.0, 0.0) / 12.0, 0.0)
    whole = {"release_mass": 4e5, "deposit_mass": 4e5 * (1.0 - left), "moving_share": moving,
             "momentum_share": moving, "left_share": left}

    def ground(plan):
        return 1000.0 - 0.5 * np.minimum(plan[:, 0] - ORIGIN[0], 400.0)

    found = hazard.assess(maps, ORIGIN[:2], CELL, 0.1, whole, ground,
                          shapely.box(*(ORIGIN[[0, 1, 0, 1]] + [20.0, 80.0, 60.0, 120.0])))
    record = {"scene_name": "straight", "crs": crs, "end_time": end_time, "dx": 2.0, "version": "0"}
    with RunWriter(folder, provenance=record, origin=ORIGIN) as writer:
        for time, share in ((0.0, 0.0), (40.0, moving)):
            lost = left * 4e5 * (time > 0.0)
            writer.history(time, {"mass": 4e5 - lost, "removed_mass": lost, "moving_share": share,
                                  "momentum_share": share, "max_speed": 20.0, "front": 10.0 * time}, {})
            writer.frame(time, np.zeros((4, 3)), {})
        units = {"peak_speed": "m/s", "peak_pressure": "Pa", "arrival_time": "s"}
        for name, values in maps.items():
            writer.map(name, np.where(flows, values, np.nan).T, 0.5 * CELL, 0.5 * CELL, CELL, units.get(name, "m"))
        writer.hazard(found.record())
        writer.close(complete=complete)
    return Run(folder)
