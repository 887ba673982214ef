"""ISeeSnow (doi:10.5194/egusphere-2025-6053): thirteen programs on the same avalanche, and how their numbers are read.

Data: the study's cases, each with Inputs/ and peaks/ (5 m rasters), outside the repository.
"""

from pathlib import Path

import numpy as np
import rasterio
import shapefile

from snowmpm.scenes.schema import Scene
from snowmpm.terrain.surface import TerrainSurface

CASES = {"CoulombOnly": {"law": "coulomb", "mu": 0.4}, "IdealizedTopo": {"law": "voellmy", "mu": 0.4, "xi": 2000.0}}
DENSITY = 200.0
NEAR = 700.0
"""Distance from the thalweg [m] within which cells count, as in the study."""
FLOWS = 1.0
"""Peak speed [m/s] beyond which a cell counts as reached, as in the study."""


def scene(folder, case, dx=5.0, **changes):
    """Scene of a case by the depth-averaged method."""
    inputs = Path(folder) / case / "Inputs"
    friction = CASES[case]
    tables = {
        "name": case, "dimension": 3, "end_time": 300.0, "output": {"interval": 10.0, "map_cell": 5.0},
        "solver": {"method": "depth", "dx": dx},
        "terrain": {"kind": "dem", "file": str(inputs / f"DEM_{case}.asc"),
                    "friction": friction["mu"] if friction["law"] == "coulomb" else friction},
        "materials": {"snow": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "release", "material": "snow",
                    "shape": {"kind": "layer", "top": 1.5, "region": {"file": str(inputs / "release1HS.shp")}}}]}
    return Scene.model_validate({**tables, **changes})


def scene_3d(folder, case, dx):
    """The same case by MPM in three dimensions, for Coulomb friction: snow without cohesion, whose inner friction, M /
    sqrt(3) = 0.58, is above that of the ground, so that it slides on it and not over its own lowest layer."""
    return scene(folder, case, dx, end_time=150.0, solver={"dx": dx},
                 materials={"snow": {"card": "li_cold_dense", "critical_slope": 1.0, "cohesion": 0.0,
                                     "density": DENSITY, "youngs_modulus": 1e6, "hardening": 3.0}})


def thalweg(folder, case):
    """Points (n, 2) [m] of the path along which run-outs are measured."""
    return np.array(shapefile.Reader(str(Path(folder) / case / "Inputs" / "LINES" / "path_aimec.shp")).shape(0).points)


def along(path, plan):
    """Distance along a path and from it [m], of plan positions (n, 2)."""
    ends = np.diff(path, axis=0)
    lengths = np.linalg.norm(ends, axis=1)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    best, place = np.full(len(plan), np.inf), np.zeros(len(plan))
    for a, step, length, s in zip(path, ends, lengths, starts, strict=False):
        share = np.clip((plan - a) @ step / length**2, 0.0, 1.0)
        away = np.linalg.norm(plan - a - share[:, None] * step, axis=1)
        nearer = away < best
        best[nearer], place[nearer] = away[nearer], s + share[nearer] * length
    return place, best


def numbers(path, x, y, speed, depth):
    """Run-out s [m], percentiles of peak speed and depth over the affected cells, areas [m2] above 1 m/s and 0.1 m."""
    plan = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    place, away = along(path, plan)
    speed, depth = np.nan_to_num(speed).ravel(), np.nan_to_num(depth).ravel()
    reached = (speed > FLOWS) & (away < NEAR)
    cell = abs(x[1] - x[0]) * abs(y[1] - y[0])
    found = {"runout": place[reached].max() if reached.any() else np.nan}
    for name, values, own in (("speed", speed, speed > FLOWS), ("depth", depth, depth > 0.1)):
        for share in (95, 99):
            found[f"{name}_{share}"] = np.percentile(values[own], share) if own.any() else np.nan
        found[f"{name}_max"] = values.max()
        found[f"{name}_area"] = own.sum() * cell
    return found


def of_program(folder, case):
    """{program: numbers} of all programs of the study."""
    path, found = thalweg(folder, case), {}
    for file in sorted((Path(folder) / case / "peaks").glob("*.tif")):
        kind = next((k for k in ("pfv", "s_max") if file.stem.endswith(k)), None)
        if kind is None:
            continue
        other = file.with_name(file.name.replace("pfv", "pft").replace("s_max", "h_max"))
        with rasterio.open(file) as speed, rasterio.open(other) as depth:
            x = speed.transform.c + (np.arange(speed.width) + 0.5) * speed.transform.a
            y = speed.transform.f + (np.arange(speed.height) + 0.5) * speed.transform.e
            name = next(part for part in reversed(file.stem.split("_")) if part not in ("pfv", "s", "max"))
            found[name] = numbers(path, x, y, speed.read(1), depth.read(1))
    return found


def of_run(folder, case, run):
    """Numbers of a run of ours, its depths taken normal to the ground, as the study's are."""
    maps = run.maps
    speed, depth = maps["peak_speed"], maps["peak_depth"]
    rows, columns = speed.values.shape
    x, y = (origin + start + speed.cell * np.arange(n)
            for origin, start, n in zip(run.origin, (speed.x0, speed.y0), (columns, rows), strict=False))
    ground = TerrainSurface.of(run.terrain.vertices + run.origin, run.terrain.facets)
    z = ground.height(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(rows, columns)
    slope = np.stack(np.gradient(z, speed.cell))
    return numbers(thalweg(folder, case), x, y, speed.values, depth.values / np.sqrt(1.0 + (slope**2).sum(axis=0)))
