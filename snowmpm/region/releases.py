"""What became of each release: releases.gpkg, its area with the numbers of its runs."""

from pathlib import Path

import numpy as np

from snowmpm.gis.layers import Layer
from snowmpm.gis.vectors import write_geopackage
from snowmpm.region import journal, plan
from snowmpm.stages import counted

FILE = "releases.gpkg"


def write(setting, index, folder):
    """Write a layer a scenario, of all release areas, also those that were not run; -> the path."""
    layers = []
    for k, name in enumerate(counted(index.names, "listing releases", "scenarios")):
        own = np.flatnonzero(index.scenario == k)
        first = np.searchsorted(index.area[own], np.arange(1, setting.areas[name] + 2))
        features = [(area.geometry, {**area.fields(name), **_numbers(index, own[first[area.number - 1] :
                                                                                first[area.number]])})
                    for area in plan.read_areas(setting.folder, name)]
        layers.append(Layer(name, "MultiPolygon", features))
    return write_geopackage(Path(folder) / FILE, layers, setting.wkt)


def _numbers(index, runs):
    """Fields of the runs of a release."""
    done = runs[index.status[runs] == 0]
    away = (index.status[runs] == journal.STATUS.index("out_of_reach")).all()
    failed = int((index.status[runs] == journal.FAILED).sum())
    status = ("not run" if not len(runs) else "cannot reach the area of interest" if away
              else f"{failed} of {len(runs)} runs failed" if failed else "done")
    angles = index.travel_angle[done][np.isfinite(index.travel_angle[done])]
    return {"status": status, "runs": len(runs), "final": bool(index.final[done].all()) if len(done) else None,
            "left_share": round(float(index.left_share[done].max()), 4) if len(done) else None,
            "travel_angle_deg": round(float(angles.min()), 1) if len(angles) else None,
            "pressure_kpa": round(float(index.pressure[done].max()) / 1e3, 1) if len(done) else None}
