"""How far a depth-averaged flow spreads: areas of peak thickness on four paths by four ways, with the same friction.

    python tests/benchmarks/depth_areas.py TERRAIN ISEESNOW --mot BINARY --avaframe PYTHON [--cells 5]
                                           [--ways columns volumes MoT-Voellmy com1DFA]
    python tests/benchmarks/depth_areas.py TERRAIN ISEESNOW --paths CoulombOnly --ways MPM --cells 3 2

TERRAIN: AvaFrame's avaGar.asc, avaAlr.tif and their releases; ISEESNOW: the study's cases
(tests/benchmarks/iseesnow.py). MoT-Voellmy is compiled from its source (cc -O3), PYTHON has `pip install avaframe`.
1.5 m of snow normal to the ground; Voellmy friction, on CoulombOnly its dry part alone. Areas are in plan, of the
largest thickness normal to the ground at any time on cells of the run; seconds are processor seconds of whole programs
on one thread. Writes depth_areas.csv, and prints the areas of the programs of the study.
"""

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import rasterio
from rasterio.features import rasterize
from rasterio.transform import from_origin
from scipy import ndimage

import snowmpm

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from snowmpm.scenes.schema import Scene
from snowmpm.seeding.region_files import read_features
from tests.benchmarks.depth_peers import spent, write

HERE = Path(__file__).parent
THICKNESS, DENSITY, G = 1.5, 200.0, 9.81
MAP_CELL = 10.0
"""Of runs in three dimensions [m]: finer ones would hold too few particles."""
BEYOND = (0.1, 0.5, 1.0, 2.0)
"""Thickness [m]."""
PATHS = {"avaGar": ("avaGar.asc", "relGar.shp", 0.25, 2000.0), "avaAlr": ("avaAlr.tif", "relAlr.shp", 0.25, 2000.0),
         "CoulombOnly": ("DEM_CoulombOnly.asc", "release1HS.shp", 0.4, None),
         "IdealizedTopo": ("DEM_IdealizedTopo.asc", "release1HS.shp", 0.4, 2000.0)}
"""Elevation model, release, mu, xi [m/s2]."""


def files(options, path):
    raster, release, mu, xi = PATHS[path]
    folder = options.terrain if path.startswith("ava") else options.iseesnow / path / "Inputs"
    return (folder / raster).resolve(), (folder / release).resolve(), mu, xi


def areas(thickness, speed, cell):
    """Areas [ha], and the largest values."""
    return {**{f"area_{least:g}": (thickness > least).sum() * cell**2 / 1e4 for least in BEYOND},
            "area_1_m/s": (speed > 1.0).sum() * cell**2 / 1e4, "thickness": thickness.max(), "speed": speed.max()}


def ours(scheme, inputs, folder, cell, **more):
    raster, release, mu, xi = inputs
    tables = {
        "name": "path", "dimension": 3, "end_time": 400.0, "output": {"interval": 10.0, "map_cell": cell},
        "solver": {"method": "depth", "dx": cell, "depth": {"scheme": scheme}, **more},
        "terrain": {"kind": "dem", "file": str(raster),
                    "friction": {"law": "voellmy", "mu": mu, "xi": xi} if xi else mu},
        "materials": {"snow": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "release", "material": "snow",
                    "shape": {"kind": "layer", "top": THICKNESS, "region": {"file": str(release)}}}]}
    (folder / "scene.toml").write_text(Scene.model_validate(tables).to_toml())
    return done(folder, cell)


def done(folder, cell):
    """Numbers of a scene once it was run, and its peak thickness. cell: of its maps [m]."""
    seconds, _ = spent([sys.executable, "-m", "snowmpm", "run", folder / "scene.toml", "-o", folder / "run",
                           "--overwrite", "--threads", 1])
    run = snowmpm.open_run(folder / "run")
    peaks = run.maps["peak_thickness"].values, run.maps["peak_speed"].values
    return {"seconds": seconds, "steps_seconds": run.summary["wall_time_of"]["steps"], "time": run.times[-1],
            **areas(*map(np.nan_to_num, peaks), cell)}, peaks[0]


def in_3d(inputs, folder, cell):
    """By MPM in three dimensions, of snow without cohesion that slides on the ground; Coulomb friction only."""
    raster, release, mu, xi = inputs
    if xi:
        raise SystemExit("MPM: Coulomb friction only: --paths CoulombOnly")
    tables = {
        "name": "path", "dimension": 3, "end_time": 110.0, "output": {"interval": 10.0, "map_cell": MAP_CELL},
        "solver": {"dx": cell}, "terrain": {"kind": "dem", "file": str(raster), "friction": mu},
        "materials": {"snow": {"card": "li_cold_dense", "critical_slope": 1.0, "cohesion": 0.0, "density": DENSITY,
                               "youngs_modulus": 1e6, "hardening": 3.0}},
        "bodies": [{"name": "release", "material": "snow",
                    "shape": {"kind": "layer", "top": THICKNESS, "region": {"file": str(release)}}}]}
    (folder / "scene.toml").write_text(Scene.model_validate(tables).to_toml())
    return done(folder, MAP_CELL)


def lattice(raster, release, cell):
    """Heights and release thickness on square cells over the raster, and the lower left corner."""
    with rasterio.open(raster) as file:
        z, raster_cell, bounds = file.read(1).astype(float), file.transform.a, file.bounds
        if (missing := (z == file.nodata) | np.isnan(z)).any():  # MoT-Voellmy takes no gaps, not even at the border
            z = z[tuple(ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True))]
    columns, rows = (int(size / cell) for size in (bounds.right - bounds.left, bounds.top - bounds.bottom))
    at = [(np.arange(n) + 0.5) * cell / raster_cell - 0.5 for n in (rows, columns)]
    z = ndimage.map_coordinates(z, np.meshgrid(*at, indexing="ij"), order=1, mode="nearest")
    shapes = [({"type": "Polygon", "coordinates": [np.asarray(ring).tolist() for ring in polygon]}, THICKNESS)
              for feature in read_features(release, "release") for polygon in feature.parts]
    depth = rasterize(shapes, (rows, columns), transform=from_origin(bounds.left, bounds.top, cell, cell))
    return z, depth, (bounds.left, bounds.top - rows * cell)


RCF = """# Run information
#
MoT-Voellmy input file version          2024-09-10
Area of Interest                        path
UTM zone                                33N
EPSG geodetic datum code                25833
Run name                                path
#
# File names
#
Grid filename                           ./dem.asc
Release depth filename                  ./release.asc
Bed depth filename                      -
Bed shear strength filename             -
Forest density filename                 -
Tree diameter filename                  -
Start velocity u filename               -
Start velocity v filename               -
Output filename root                    {out}
Output format                           ESRI_ASCII_Grid
#
# Physical parameters
#
Gravitational acceleration   (m/s^2)    9.81
Flow density                (kg/m^3)    {density}
Bed density                 (kg/m^3)    140.0
Deposit density             (kg/m^3)    400.0
Rheology                                Voellmy
Parameters                              constant
Dry-friction coefficient         (-)    {mu}
Turbulent drag coefficient       (-)    {k}
Effective drag height            (m)    0.0
Centrifugal effects                     yes
Passive earth-pressure coeff.    (-)    1.0
#
Forest effects                          no
Tree drag coefficient            (-)    1.0
Modulus of rupture             (MPa)    50.0
Forest decay coefficient       (m/s)    0.15
#
Entrainment                             none
Erosion coefficient              (-)    0.0
Bed strength profile                    global
Bed friction coefficient         (-)    0.25
Deposition                              no
Evolving geometry                       no
#
# Numerical parameters
#
Simulation time                  (s)    400.0
Minimum time step                (s)    0.0001
Maximum time step                (s)    0.5000
Output interval                  (s)    400.0
Write velocity vectors                  no
Write maximum pressure                  no
Write instant. pressure                 no
Minimum flow depth               (m)    0.01
Minimum speed                  (m/s)    0.01
Momentum threshold          (kg m/s)    {momentum}
Initial CFL number               (-)    0.3
"""
"""As handed to the study, but for paths, friction and the end."""


def of_mot(binary, inputs, folder, cell):
    raster, release, mu, xi = inputs
    z, depth, corner = lattice(raster, release, cell)
    here = folder / "mot"
    shutil.rmtree(here, ignore_errors=True)
    for name in "hs":
        (here / "out" / name).mkdir(parents=True)
    head = {"ncols": z.shape[1], "nrows": z.shape[0], "xllcorner": f"{corner[0]:.6f}", "yllcorner": f"{corner[1]:.6f}",
            "cellsize": cell, "NODATA_value": -9999}
    for name, values in (("dem", z), ("release", depth)):
        np.savetxt(here / f"{name}.asc", values, "%.4f", header="\n".join(f"{k} {v}" for k, v in head.items()),
                   comments="")
    momentum = 0.1 * depth.sum() * cell**2 * DENSITY  # of a mean of 0.1 m/s
    (here / "run.rcf").write_text(RCF.format(out=f"{here}/out/run", density=DENSITY, mu=mu, k=G / xi if xi else 0.0,
                                             momentum=momentum))
    seconds, _ = spent([Path(binary).resolve(), "run.rcf"], strict=False, cwd=here)
    peaks = [read(next((here / "out").rglob(f"*{kind}*.asc"))) for kind in ("h_max", "s_max")]
    return {"seconds": seconds, **areas(*peaks, cell)}, peaks[0]


def read(path):
    with rasterio.open(path) as file:
        return np.maximum(np.nan_to_num(file.read(1).astype(float), posinf=0.0, neginf=0.0), 0.0)


def of_avaframe(python, inputs, folder, cell):
    raster, release, mu, xi = inputs
    here = folder / "ava"
    shutil.rmtree(here, ignore_errors=True)
    (here / "Inputs" / "REL").mkdir(parents=True)
    z, _, corner = lattice(raster, release, cell)
    head = {"ncols": z.shape[1], "nrows": z.shape[0], "xllcorner": f"{corner[0]:.6f}", "yllcorner": f"{corner[1]:.6f}",
            "cellsize": cell, "NODATA_value": -9999}
    np.savetxt(here / "Inputs" / "dem.asc", z, "%.4f",
               header="\n".join(f"{k} {v}" for k, v in head.items()), comments="")
    for file in release.parent.glob(f"{release.stem}.*"):
        shutil.copy(file, here / "Inputs" / "REL" / f"release{file.suffix}")
    seconds, said = spent([python, HERE / "peers" / "avaframe_path.py", here, mu, cell, *([xi] if xi else [])],
                          cwd=folder)
    told = json.loads(next(line[4:] for line in said.splitlines() if line.startswith("ROW ")))
    peaks = [read(next(path for path in told["peaks"] if kind in Path(path).name)) for kind in ("pft", "pfv")]
    return {"seconds": seconds, "steps_seconds": told["seconds"], **areas(*peaks, cell)}, peaks[0]


def of_study(folder, path):
    """Areas [ha] of each program of the study (ISeeSnow): their least, median and largest."""
    found = []
    for file in sorted((folder / path / "peaks").glob("*.tif")):
        if file.stem.endswith(("pft", "h_max")):
            with rasterio.open(file) as raster:
                thickness, cell = np.nan_to_num(raster.read(1)), raster.transform.a
            found.append([(thickness > least).sum() * cell**2 / 1e4 for least in BEYOND])
    return {name: by(found, axis=0).round(1).tolist() for name, by in (("least", np.min), ("median", np.median),
                                                                       ("largest", np.max))}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("terrain", type=Path)
    parser.add_argument("iseesnow", type=Path)
    parser.add_argument("--mot")
    parser.add_argument("--avaframe")
    parser.add_argument("--cells", type=float, nargs="+", default=[5.0], help="[m]")
    parser.add_argument("--ways", nargs="+", default=["columns", "volumes", "MoT-Voellmy", "com1DFA"])
    parser.add_argument("--paths", nargs="+", default=list(PATHS))
    parser.add_argument("--keep", type=Path, help="folder for the rasters of peak thickness (NAME.npy)")
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    makers = {"columns": lambda *rest: ours("columns", *rest), "volumes": lambda *rest: ours("volumes", *rest),
              "MoT-Voellmy": lambda *rest: of_mot(options.mot, *rest),
              "com1DFA": lambda *rest: of_avaframe(options.avaframe, *rest), "MPM": in_3d}
    rows = []
    for path in options.paths:
        for cell in options.cells:
            for way in options.ways:
                with tempfile.TemporaryDirectory() as name:
                    numbers, peak = makers[way](files(options, path), Path(name), cell)
                rows.append({"path": path, "cell": cell, "way": way, **numbers})
                print(rows[-1], flush=True)
                if options.keep:
                    options.keep.mkdir(parents=True, exist_ok=True)
                    np.save(options.keep / f"{path}_{cell:g}_{way}.npy", peak)
    write(rows, options.output / "depth_areas.csv")
    for path in options.paths:
        if not path.startswith("ava"):
            print(path, of_study(options.iseesnow, path))


if __name__ == "__main__":
    main()
