"""A frame of a run as PyVista data sets."""

from typing import TYPE_CHECKING

import numpy as np

from snowmpm.annotations import Numbers

if TYPE_CHECKING:  # slow to import
    import pyvista

    from snowmpm.io import Frame, Run

SNOW, TERRAIN = "snow", "terrain"
UNITS = "units"
"""Key of `user_dict` with the units of the arrays by name."""


def blocks_of(frame: "Frame", run: "Run | None", i: int) -> "pyvista.MultiBlock":
    """Blocks "snow", "terrain" and each obstacle by its name, in map coordinates [m]; run, i: that it is frame i of, or
    None, then there is snow only."""
    import pyvista

    blocks = pyvista.MultiBlock()
    snow = pyvista.PolyData(np.asarray(frame.positions, float))
    for name, values in frame.fields.items() if len(frame) else ():
        snow.point_data[name] = values
    snow.user_dict[UNITS] = {} if run is None else {name: run.units.get(name, "") for name in frame.fields}
    snow.user_dict["time"] = frame.time
    blocks[SNOW] = snow
    if run is not None and run.terrain is not None:
        blocks[TERRAIN] = _surface(run.terrain.vertices + frame.origin, run.terrain.facets)
    for name, obstacle in ({} if run is None else run.obstacles).items():
        own = f"{name} (obstacle)" if name in (SNOW, TERRAIN) else name
        blocks[own] = _surface(obstacle.placed(i) + frame.origin, obstacle.facets)
    return blocks


def _surface(vertices: Numbers, facets: Numbers) -> "pyvista.PolyData":
    """Triangles (m, 3), or segments (m, 2) of a section."""
    import pyvista

    cells = np.column_stack([np.full(len(facets), facets.shape[1]), facets]).ravel()
    places = np.asarray(vertices, float)
    return pyvista.PolyData(places, faces=cells) if facets.shape[1] == 3 else pyvista.PolyData(places, lines=cells)
