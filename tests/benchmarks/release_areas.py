"""Release areas found on real terrain, beside the release polygons that come with it and AvaFrame's own delineation.

    python tests/benchmarks/release_areas.py DATA [--peer FILE] [-o FILE.csv]

DATA is the folder avaframe/data of AvaFrame (EUPL-1.2), whose releases were drawn by experts for known avalanche paths.
FILE is praDelineationVeitinger.py of AvaFrame's scenario model chain (OpenNHM/AvaScenarioModelChain): its functions are
called on the same terrain without forest, wind from everywhere, threshold 0.30, as its defaults are. Needs numba.

Columns: path; rule: ours (frequent, rare, extreme) or the peer; areas: their number; flagged: share of the ground that
can release; covered: share of the drawn release that lies in it; iou: of the drawn release and the one area that it has
most of; agree: share of the cells in which ours and the peer's say the same.
"""

import argparse
import csv
import sys
import types
import warnings
from pathlib import Path

import numpy as np
import shapely
from rasterio.features import geometry_mask

from snowmpm.region import release_areas, release_terrain
from snowmpm.region.elevations import as_geotiff, open_elevations
from snowmpm.seeding.regions import read_regions

WANTED = "sectorMask", "windShelterPrep", "windShelterNumba", "bellCurve", "slidingSum"


def peer_of(file):
    """Functions of the peer's file by name, without what it imports."""
    import ast

    import numba

    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    body = [node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name in WANTED]
    found = types.ModuleType("peer")
    found.__dict__.update(np=np, njit=numba.njit, prange=numba.prange)
    exec(compile(ast.Module(body, []), str(file), "exec"), found.__dict__)
    return found


def fuzzy(peer, z, cell):
    """The peer's possibility of release of each cell, without forest."""
    filled = np.where(np.isfinite(z), z, -9999.0).astype(np.float32)
    distance, mask = peer.windShelterPrep(6, 0 - 180 + 270, 0 + 180 + 270, cell)
    shelter = peer.windShelterNumba(filled, mask.astype(np.float32), distance, 0.5, 6, -9999)
    east, north = horn(z, cell)
    slope = np.degrees(np.arctan(np.hypot(east, north)))
    up = 1.0 / np.sqrt(1.0 + east**2 + north**2)
    sums = [np.pad(peer.slidingSum(np.ascontiguousarray(np.nan_to_num(part))), 1)
            for part in (-east * up, -north * up, up)]
    rough = 1.0 - np.sqrt(sum(part**2 for part in sums)) / 9.0
    steep = np.where((slope > 60.0) | (slope < 28.0), 0.0, peer.bellCurve(np.nan_to_num(slope), 11, 4, 43))
    sheltered = peer.bellCurve(shelter, 2, 5, 2)
    trees = peer.bellCurve(np.zeros_like(z), 40, 3.5, -15)
    least = np.minimum(np.minimum(steep, sheltered), trees)
    return np.maximum((1.0 - least) * least + least * (steep + sheltered + trees) / 3.0 - (rough >= 0.02), 0.0)


def horn(z, cell):
    """Slopes to the east and the north, not smoothed, as GDAL has them."""
    east, north = np.full((2, *z.shape), np.nan)
    a, b, c, d, f, g, h, i = (z[:-2, :-2], z[:-2, 1:-1], z[:-2, 2:], z[1:-1, :-2], z[1:-1, 2:], z[2:, :-2],
                              z[2:, 1:-1], z[2:, 2:])
    east[1:-1, 1:-1] = (c + 2 * f + i - a - 2 * d - g) / (8.0 * cell)
    north[1:-1, 1:-1] = (a + 2 * b + c - g - 2 * h - i) / (8.0 * cell)
    return east, north


def rows_of(folder, peer, scratch):
    """Rows of the table of one path."""
    terrain = next((one for one in sorted(Path(folder, "Inputs").glob("*")) if one.suffix in (".asc", ".tif")), None)
    releases = sorted(Path(folder, "Inputs", "REL").glob("*.shp"))
    if terrain is None or not releases:
        return
    with open_elevations(as_geotiff(terrain, scratch)) as elevations:
        grid = elevations.grid
        shape = (grid.rows, grid.columns)
        z = elevations.read((0, grid.rows), (0, grid.columns))
        drawn = shapely.union_all([one.polygons.geometry for file in releases
                                   for one in read_regions(file, "REL", grid.system)])
        known, inside = np.isfinite(z), geometry_mask([drawn], shape, grid.transform(), invert=True)
        own = {}
        for name, rule in release_terrain.RULES.items():
            areas = release_areas.release_areas(elevations, rule)
            own[name] = geometry_mask([one.geometry for one in areas], shape, grid.transform(), invert=True)
            parts = shapely.get_parts(drawn)
            iou = [max((one.geometry.intersection(part).area / one.geometry.union(part).area for one in areas),
                       default=0.0) for part in parts]
            yield {"path": Path(folder).name, "rule": name, "areas": len(areas), **shares(own[name], inside, known),
                   "iou": f"{np.average(iou, weights=[part.area for part in parts]):.2f}"}
        if peer:
            theirs = fuzzy(peer, z, grid.cell) >= 0.3
            agree = float((theirs == own["extreme"])[known].mean())
            yield {"path": Path(folder).name, "rule": "AvaFrame", **shares(theirs, inside, known),
                   "agree": f"{agree:.3f}"}


def shares(mask, inside, known):
    return {"flagged": f"{float(mask[known].mean()):.3f}", "covered": f"{float(mask[inside].mean()):.3f}"}


def main():
    import tempfile

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--peer", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    choice = parser.parse_args()
    warnings.simplefilter("ignore")
    peer, rows = choice.peer and peer_of(choice.peer), []
    with tempfile.TemporaryDirectory() as scratch:
        for folder in sorted(choice.data.glob("ava*")):
            for row in rows_of(folder, peer, scratch):
                rows.append(row)
                print(row, flush=True)
    with (choice.output.open("w", newline="", encoding="utf-8") if choice.output else sys.stdout) as file:
        table = csv.DictWriter(file, ["path", "rule", "areas", "flagged", "covered", "iou", "agree"],
                               lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
