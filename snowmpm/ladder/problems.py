"""Problems on which the rungs of the ladder are measured: scenes with an answer."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from snowmpm.errors import InputError

DATA = "SNOWMPM_STUDY_DATA"
"""Variable that names the folder of cases whose terrain does not ship: iseesnow and terrain."""


@dataclass(frozen=True)
class Known:
    """An answer that is known. value; unsure: to what share; source: in words."""

    value: float
    unsure: float
    source: str


@dataclass(frozen=True)
class Problem:
    """name; scene: name or file of one; changes: of its keys; questions: {name: what is `Known`; or to what share the
    answer of the finest rung is known, None: as well as the rung before it tells}; finest: name of that rung; at,
    obstacle: of `Ask`; most [s]: forecast of the other rungs."""

    name: str
    scene: str
    questions: Mapping[str, Known | float | None]
    finest: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    at: tuple[float, float] | None = None
    obstacle: str | None = None
    most: float = 120.0


def yes(source):
    """A slab that releases."""
    return {"release": Known(1.0, 0.0, source)}


def no(source):
    """A slab that stays."""
    return {"release": Known(0.0, 0.0, source)}


ONE_CELL = {"run-out": 0.02, "affected-area": 0.08}
"""By MPM on cells as wide as the snow is deep, 1.4 to 1.6 of its thickness. Half of such cells, 0.8 of it, move the
run-out on two real paths by up to 2 % and the affected area by up to 8 % (scenes/library/avalanche_on_raster.toml)."""
FLOWS = {"run-out": None, "affected-area": None, "peak-pressure": None, "deposit-volume": None}
SAW = {"critical-length": 0.06, "crack-speed": None}
"""A bin of the record on the finest grid is an eighth of the length, which is known to half of it."""
IN_TRACK = {"peak-pressure": 0.02, "deposit-volume": 0.01}
"""Half of such cells move both by less in the valley, with Coulomb friction."""
SETTLED = {"settlement": None}
SOFT = {"initial": {"stress": "none"}, "reference": None, "end_time": 3.0}
"""Soil that is let down on its base at once, and settles."""
ELASTIC = {"kind": "elastic", "poisson_ratio": 0.3}
YIELDING = {"kind": "cohesive_cam_clay", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
            "critical_slope": 1.2, "cohesion": 0.1, "hardening": 1.0, "p0": 6e3}


TWO_ROWS = {"solver.dx": 1.5}
"""Of particles in the release, by which its depth is known better than by one."""
SMALL = {"bodies.0.shape": {"kind": "layer", "top": 1.5, "region": {
    "x": [600155.0, 600215.0], "y": [200170.0, 200300.0]}}}
"""A smaller release above the valley of the library."""


def wall(place, size):
    """The small release, and a wall in the track. place: middle of its face [m], z of the ground; size: along and
    across [m]."""
    (x, y, z), (along, across) = place, size
    return {**SMALL, **TWO_ROWS, "obstacles": [{"name": "wall", "contact": "separate", "friction": 0.3, "shape": {
            "kind": "box", "min": [x, y - across / 2.0, z - 8.0], "max": [x + along, y + across / 2.0, z + 15.0]}}]}


BOX = [[0.0, 0.0], [24.0, 0.0], [24.0, 6.0], [0.0, 6.0]]
SNOW = {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}

PROBLEMS = {one.name: one for one in (
    Problem("valley, Coulomb", "avalanche_on_raster", FLOWS, "3-D mpm, 2 cells", TWO_ROWS, at=(600530.0, 200255.0)),
    Problem("valley, Voellmy", "avalanche_depth_averaged", {**ONE_CELL, **IN_TRACK}, "3-D mpm, 1 cell",
            {"terrain.friction": {"law": "voellmy", "mu": 0.25, "xi": 1500.0}}, at=(600522.6, 200233.4)),
    Problem("flow, cold and dense", "flow_cold_dense", {"run-out": None}, "mpm, 16 cells"),
    Problem("flow, sliding slab", "flow_sliding_slab", {"run-out": None}, "mpm, 32 cells"),
    Problem("flow, warm plug", "flow_warm_plug", {"run-out": None}, "mpm, 32 cells"),
    Problem("column of sand", "column_collapse_2d", {"run-out": None}, "mpm, 32 cells"),
    Problem("tall column of sand", "column_collapse_2d", {"run-out": None}, "mpm, 32 cells",
            {"bodies.0.shape.max": [0.2, 0.8], "end_time": 2.0}),
    Problem("round column of sand", "column_collapse_3d", {"run-out": None}, "mpm, 16 cells"),
    Problem("wall", "impact_wall_2d", {"load": None}, "mpm, 32 cells"),
    Problem("dam", "impact_wedge_2d", {"load": None}, "mpm, 32 cells"),
    Problem("wall in a flume", "flume_impact", {"load": None}, "mpm, 32 cells"),
    Problem("mast", "impact_mast", {"load": None}, "mpm, 8 cells"),
    Problem("wall in the channel", "avalanche_on_raster", {"load": None}, "3-D mpm, 2 cells",
            wall((600480.0, 200238.0, 1257.0), (4.0, 24.0)), most=600.0),
    Problem("post in the track", "avalanche_on_raster", {"load": None}, "3-D mpm, 2 cells",
            wall((600430.0, 200241.0, 1285.0), (3.0, 10.0)), most=600.0),
    Problem("wall across the valley", "avalanche_on_raster", {"load": None}, "3-D mpm, 2 cells",
            wall((600540.0, 200233.0, 1232.0), (6.0, 40.0)), most=600.0),
    Problem("saw test on the flat", "pst_2d", SAW, "resolved, 40 cells"),
    Problem("saw test, up 30 degrees", "pst_2d", SAW, "resolved, 40 cells", {"saw_test.slope_angle": 30.0}),
    Problem("saw test, soft slab", "pst_2d", SAW, "resolved, 40 cells",
            {"materials.slab.youngs_modulus": 1.5e6, "materials.slab.density": 200.0}),
    Problem("saw test, stiff slab", "pst_2d", SAW, "resolved, 40 cells",
            {"materials.slab.youngs_modulus": 6e6, "materials.slab.density": 300.0}),
    Problem("saw test in 3-D", "pst", SAW, "3-D resolved, 20 cells"),
    Problem("saw test in 3-D, up 30 degrees", "pst", SAW, "3-D resolved, 20 cells", {"saw_test.slope_angle": 30.0}),
    Problem("saw test in 3-D, soft slab", "pst", SAW, "3-D resolved, 20 cells",
            {"materials.slab.youngs_modulus": 1.5e6, "materials.slab.density": 200.0}),
    Problem("slope of 45 degrees", "slope_failure", {"factor-of-safety": None}, "reduction, 40 cells"),
    Problem("slope of stronger soil", "slope_failure", {"factor-of-safety": None}, "reduction, 40 cells",
            {"materials.soil.friction_angle": 25.0, "materials.soil.cohesion": 8.0e3}),
    Problem("gentle slope", "slope_failure", {"factor-of-safety": None}, "reduction, 40 cells",
            {"bodies.0.shape.points": [[0.0, 0.0], [24.0, 0.0], [24.0, 9.0], [17.0, 9.0], [8.0, 3.0], [0.0, 3.0]]}),
    Problem("skier on a slab", "skier_trigger", yes("the scene"), "mpm, 1 x its dx"),
    Problem("a fifth of a skier", "skier_trigger", no("the scene"), "mpm, 1 x its dx",
            {"events.0.force": [0.0, -157.0]}),
    Problem("new snow", "natural_release", yes("the scene"), "mpm, 1 x its dx"),
    Problem("half of the new snow", "natural_release", {"release": None}, "mpm, 1 x its dx",
            {"events.0.force": [0.0, -4280.0]}),
    Problem("whumpf", "whumpf_2d", no("the scene"), "mpm, 1 x its dx"),
    Problem("remote trigger", "remote_trigger_2d", yes("the scene"), "mpm, 1 x its dx"),
    Problem("slab over a gully", "slab_release", yes("the scene"), "interface, 1 x its dx"),
    Problem("slab over a gully, on a strong layer", "slab_release", no("no scar of a cut in it grows"),
            "interface, 1 x its dx", {"materials.weak_layer.p0": 1e5, "materials.weak_layer.softening": 0.5}),
    Problem("thinner slab over a gully", "slab_release", {"release": None}, "interface, 1 x its dx",
            {f"bodies.{i}.shape.top": 1.15 for i in range(4, 8)}),
    Problem("small release in the valley", "avalanche_on_raster",
            {"peak-pressure": None, "deposit-volume": None}, "3-D mpm, 2 cells", SMALL,
            at=(600522.6, 200233.4)),
    Problem("elastic layer under its weight", "slope_failure",
            {"settlement": Known(0.02624, 0.02, "density gravity H^2 / (3 M) of small strains")}, "implicit, 8 cells",
            {**SOFT, "materials.soil": {**ELASTIC, "density": 300.0, "youngs_modulus": 1e6},
             "bodies.0.shape.points": BOX}),
    Problem("bank of firm soil under its weight", "slope_failure", SETTLED, "implicit, 16 cells",
            {**SOFT, "materials.soil.friction_angle": 35.0, "materials.soil.cohesion": 2e4,
             "materials.soil.youngs_modulus": 3e6}),
    Problem("snow that yields under its weight", "slope_failure", SETTLED, "implicit, 16 cells",
            {**SOFT, "materials.soil": YIELDING, "bodies.0.shape.points": BOX}),
)}
"""By name, those that run from what ships."""


def of_data():
    """Problems on terrain that does not ship, by name; {} where the folder is not there. Raises InputError for a folder
    without them."""
    given = os.environ.get(DATA)
    if not given:
        return {}
    folder = Path(given).resolve()
    if not (folder / "terrain" / "avaGar.asc").exists():
        raise InputError(f"{DATA} = {given}: has no terrain/avaGar.asc")

    def on(raster, release, friction, thickness=1.5):
        return {"terrain": {"kind": "dem", "file": str(raster), "friction": friction},
                "materials": {"snow": SNOW}, "end_time": 400.0, "output": {"interval": 5.0},
                "bodies": [{"name": "release", "material": "snow",
                            "shape": {"kind": "layer", "top": thickness, "region": {"file": str(release)}}}]}

    terrain, study = folder / "terrain", folder / "iseesnow"
    programs = "median of the programs of ISeeSnow, of their rasters of peak thickness"
    found = [
        Problem("avaGar", "avalanche_depth_averaged", ONE_CELL, "3-D mpm, 1 cell",
                on(terrain / "avaGar.asc", terrain / "relGar.shp", 0.35)),
        Problem("avaAlr", "avalanche_depth_averaged", ONE_CELL, "3-D mpm, 1 cell",
                on(terrain / "avaAlr.tif", terrain / "relAlr.shp", 0.35)),
        Problem("CoulombOnly", "avalanche_depth_averaged",
                {"run-out": ONE_CELL["run-out"], "affected-area": Known(379425.0, 0.118, programs)}, "3-D mpm, 1 cell",
                on(study / "CoulombOnly/Inputs/DEM_CoulombOnly.asc", study / "CoulombOnly/Inputs/release1HS.shp", 0.4)),
        Problem("IdealizedTopo", "avalanche_depth_averaged",
                {"affected-area": Known(209212.0, 0.105, programs)}, "depth, 2.5 m",
                on(study / "IdealizedTopo/Inputs/DEM_IdealizedTopo.asc", study / "IdealizedTopo/Inputs/release1HS.shp",
                   {"law": "voellmy", "mu": 0.4, "xi": 2000.0})),
    ]
    return {one.name: one for one in found}
