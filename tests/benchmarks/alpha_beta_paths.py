"""Alpha-beta on the paths of AvaFrame, beside its own com2AB: `python tests/benchmarks/alpha_beta_paths.py DATA`.

DATA: folder avaframe/data of AvaFrame (github.com/OpenNHM/AvaFrame, EUPL). Its answers were taken from version 2.1 with
its own settings, the split points of its folders. Writes figures/alpha_beta_paths.csv.
"""

import csv
import sys
import warnings
from pathlib import Path

import numpy as np
import shapefile
from scipy.interpolate import RegularGridInterpolator

from snowmpm.runout.alpha_beta import alpha_beta
from snowmpm.runout.profile import profile_of
from snowmpm.terrain.raster import read_raster

COM2AB = {
    ("avaAlr", "ABAlr"): (27.6655, 26.1572, 35.2674, 2946.2),
    ("avaGar", "Gar"): (29.9253, 27.9331, 34.5515, 2235.0),
    ("avaGar", "Gar23"): (29.5273, 26.3978, 29.1807, 1434.7),
    ("avaHit", "upValley"): (31.2856, 28.8602, 33.9604, 1858.9),
    ("avaHit", "downValley"): (30.7714, 28.0755, 31.9381, 1663.5),
    ("avaKot", "ABKot"): (31.8986, 29.5032, 33.3726, 1675.2),
    ("avaWog", "ABWog"): (26.2902, 24.0840, 28.2086, 2139.1),
    ("avaHelix", ""): (35.6151, 32.4397, 36.0062, 1385.7),
}
"""beta, alpha, alpha of small avalanches [degrees], length to alpha [m]."""


def main(data):
    rows = []
    for (name, path), theirs in COM2AB.items():
        inputs = Path(data) / name / "Inputs"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            raster = read_raster(next(one for one in sorted(inputs.iterdir()) if one.suffix in (".asc", ".tif")))
        height = RegularGridInterpolator((raster.y, raster.x), raster.z)
        points = [np.array(one.points[0]) for one in shapefile.Reader(inputs / "POINTS" / "splitPoint.shp").shapes()]
        found = next(one for one in shapefile.Reader(inputs / "LINES" / "pathAB.shp").shapeRecords()
                     if (one.record.as_dict().get("Name") or "") == path)
        profile = profile_of(np.array(found.shape.points), lambda places, z=height: z(places[:, ::-1]), name)
        split = min(points, key=lambda point, line=profile.plan: np.linalg.norm(line - point, axis=1).min())
        own = alpha_beta(profile, "austria", profile.nearest(split))
        small = alpha_beta(profile, "austria_small", profile.nearest(split))
        usual = alpha_beta(profile, "austria")
        rows.append({"path": f"{name} {path}".strip(), "beta": f"{own.beta:.4f}", "beta_com2ab": theirs[0],
                     "alpha": f"{own.alpha:.4f}", "alpha_com2ab": theirs[1], "alpha_small": f"{small.alpha:.4f}",
                     "alpha_small_com2ab": theirs[2], "runout": f"{own.runouts[0]:.1f}", "runout_com2ab": theirs[3],
                     "alpha_without_split": f"{usual.alpha:.4f}"})
        print(rows[-1])
    output = Path(__file__).parent / "figures" / "alpha_beta_paths.csv"
    with output.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(sys.argv[1])
