"""A first scene on the user's own slope: `snowmpm new NAME --terrain FILE`."""

import math
import os
import warnings

import numpy as np

from snowmpm.errors import InputError, nearest_file
from snowmpm.scenes import starts
from snowmpm.scenes.terrain import Dem, Mesh
from snowmpm.seeding.attributes import ABSENT
from snowmpm.seeding.regions import read_regions
from snowmpm.setup.build import build
from snowmpm.stepping.abilities import course
from snowmpm.terrain import load_terrain
from snowmpm.terrain.first_release import STEEP, first_release, may_leave

MESHES = (".stl", ".obj", ".ply", ".glb")
RASTERS = (".asc", ".tif", ".tiff")
PARTICLES = 40_000  # about so many: a few minutes
FRICTION = 0.35  # of the bed, as the scene has it
FRAMES = 150  # at most about so many
LATER = 4.0  # end time of a depth-averaged flow over the moment at which blocks that slide without pressure rest
LONGEST = 3600.0  # s, within which they are looked for
LEAST_CELL, USUAL_CELL, MOST_CELL = 1.0, 5.0, 10.0  # m, of a depth-averaged flow
ACROSS = 8.0  # cells across a release, at the least
SAMPLES = 60  # along each side of a release: places at which the ground's slope is measured
LONG = 300.0  # thicknesses of the snow, from which on a slope is long against its depth


def scene_on_ground(name, file, ground, release=None, thickness=None, unit=None, in_plan=False):
    """Text of a scene `name` to be written to `file`, with an end time that `outlook` puts right, and lines that
    summarise it.

    ground: mesh or raster; release: polygons in plan (.geojson, .shp, .gpkg), or None for a first guess; thickness of
    the snow [m], or None for that of the polygons, or one that suits the size of the slope; unit: of a raster's
    elevations, "m", "ft" or "us-ft", or None for what the file says; in_plan: whether the flow is
    depth-averaged. Raises InputError for a file that cannot be used.
    """
    surface, kind = load_ground(ground, unit)
    extent = surface.upper - surface.lower
    words = f"{extent[0]:.4g} m by {extent[1]:.4g} m in plan, {extent[2]:.4g} m high"
    own, assumed = None, ""  # thickness that the release's file gives
    if release is None:
        found = first_release(surface, thickness or _usual(extent))
        region = f"{{ x = {_pair(found.x)}, y = {_pair(found.y)} }}"
        sides = " by ".join(f"{high - low:.3g} m" for low, high in (found.x, found.y))
        where = f"{sides} in plan, {found.slope:.0f} degrees steep"
        area, centre = found.area, (sum(found.x) / 2.0, sum(found.y) / 2.0)
        stretch = 1.0 / math.cos(math.radians(min(found.slope, 60.0)))
        told = [f"ground: {words}", f"release: {where}; a guess, to be put right in the file"]
        if found.slope < STEEP[0]:
            told.append(f"the steepest part has {found.slope:.0f} degrees, and avalanches want {STEEP[0]:g}: is z up,"
                        " in m?")
    else:
        if not release.is_file():
            raise InputError(f"--release {release}: no such file{nearest_file(release)}")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # told again when the scene is built
            polygons = read_regions(release.resolve(), "--release", surface.system)
        own, assumed = _given_thickness(polygons, release, thickness)
        where, region = f"{release.name}", f"{{ file = {starts.quoted(_relative(release, file))} }}"
        area = sum(polygon.area() for polygon in polygons)
        stretch = _stretch(surface, polygons)
        centre = sum(polygon.area() * (polygon.lower + polygon.upper) / 2.0 for polygon in polygons) / area
        told = [f"ground: {words}", f"release: {area:.4g} m2 in plan from {release}"]
    side = math.sqrt(area)
    thick = thickness or own or _rounded(min(_usual(extent), 0.2 * side))
    volume = area * stretch * thick
    length = float(math.hypot(*extent))
    if in_plan:
        dx = _cell_in_plan(surface, side)
    else:
        # Between the coarsest that is accepted and a third of the thickness
        dx = _rounded(min(max((8.0 * volume / PARTICLES) ** (1.0 / 3.0), thick / 3.0), 1.5 * thick))
    end = max(4.0, round(3.0 * math.sqrt(length)))
    if thickness is None and own is None and release is not None:
        warnings.warn(f"thickness: {thick:.4g} m is an assumption{assumed}; --thickness gives another", stacklevel=2)
    told.append(f"thickness: {thick:.4g} m" + (
        (", from the file (mean over the area)" if own is not None else ", an assumption" + (
            "" if release is not None else "; --thickness gives another"))
        if thickness is None else f", in place of {own:.4g} m of the file" if own is not None else ""))
    if not in_plan and length > LONG * thick:
        told.append("long against its depth: --method depth gives its run-out and maps in seconds")
    if surface.system is None:
        told.append("the ground names no coordinate system: its numbers are taken as metres")
    if may_leave(surface, centre, FRICTION):
        told.append("the ground may end before the snow stops, and what leaves it is lost: a larger ground is better")
    from_file = own is not None and thickness is None
    foot = _place(surface).round(1) - [5.0, 5.0, 1.0]
    text = starts.start_from(
        "ground_depth" if in_plan else "ground", name=name, file=file, ground=ground.name, kind=kind,
        path=starts.quoted(_relative(ground, file)), extent=words, found=where, region=region,
        top='"file"' if from_file else f"{thick:g}", dx=f"{dx:g}",
        end_time=f"{end:.1f}", friction=f"{FRICTION:g}", interval=f"{_interval(end):g}",
        unit=f"\nelevation_unit = {starts.quoted(unit)}" if unit else "", house=_vector(foot),
        roof=_vector(foot + np.array([10.0, 10.0, 9.0])))
    return text, told


def outlook(scene):
    """What is known once a first scene is built: {key: value} to be set in it, and a line that says how large it is.

    A depth-averaged flow gets an end time at which it has stopped: LATER times that of blocks which slide down without
    pressure. Raises InputError for a scene that cannot be built.
    """
    model = build(scene)
    solver, values = model.solver(), {}
    blocks = course(solver, LONGEST, scene.output.interval)
    if blocks is not None:
        end = max(20.0, 10.0 * math.ceil(0.1 * LATER * blocks.rests))
        values = {"end_time": end, "output.interval": _interval(end)}
    many = solver.particles.count if scene.solver.in_volumes else len(model.population.volumes)
    return values, f"dx = {scene.solver.dx:g} m, {many} {scene.solver.pieces}"


def _interval(end):
    return next(step for step in (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0) if end / step <= FRAMES)


def _given_thickness(polygons, release, thickness):
    """Thickness [m] that a file gives, the mean over its area, None where it gives none, and why some have none.
    Raises InputError where some polygons have one and others do not, or a value is none, unless another thickness [m]
    is given."""
    given = [(polygon.area(), polygon.thickness) for polygon in polygons if polygon.thickness is not None]
    flaw = next((polygon.flaw for polygon in polygons if polygon.thickness is None), "")
    if thickness is None and flaw and not flaw.startswith(ABSENT):
        others = f"; others have {', '.join(f'{value:g}' for _, value in given[:3])} m" if given else ""
        raise InputError(f"--release {release}: {flaw}{others}: complete the file, or give --thickness for all")
    areas, thicknesses = zip(*given, strict=True) if given else ((), ())
    return float(np.average(thicknesses, weights=areas)) if given else None, flaw and f": {release.name} {flaw}"


def _stretch(surface, polygons):
    """Area on the ground over that in plan, of polygons."""
    lower, upper = (np.array(ends) for ends in ([p.lower for p in polygons], [p.upper for p in polygons]))
    lower, upper = lower.min(axis=0), upper.max(axis=0)
    places = np.stack(np.meshgrid(*np.linspace(lower, upper, SAMPLES).T, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = np.logical_or.reduce([polygon.polygons.contains(places) for polygon in polygons])
    gradient = surface.gradient(places[inside], float((upper - lower).min()) / SAMPLES)
    gradient = gradient[np.isfinite(gradient).all(axis=1)]
    return float(np.sqrt(1.0 + (gradient**2).sum(axis=1)).mean()) if len(gradient) else 1.2


def _cell_in_plan(surface, side):
    """Side [m] of a cell in plan: the raster's if that is a usual one, else about 5 m; at least `ACROSS` lie across a
    release of this side [m]."""
    own = surface.lattice[1] if surface.lattice is not None else None
    if own is not None and LEAST_CELL <= own <= min(MOST_CELL, side / ACROSS):
        return own
    return _rounded(min(USUAL_CELL, side / ACROSS))


def _usual(extent):
    """Thickness [m] of snow that suits the size of a slope."""
    return min(max(0.02 * float(extent[:2].max()), 0.3), 1.5)


def _place(surface):
    """A point (3,) [m] on the lower part of the terrain, as the site of a house."""
    heights = surface.vertices[:, 2]
    middle = surface.vertices[heights <= np.quantile(heights, 0.3), :2].mean(axis=0)
    x, y = surface.vertices[np.linalg.norm(surface.vertices[:, :2] - middle, axis=1).argmin(), :2]
    return np.array([x, y, surface.height(np.array([[x, y]]))[0]])


def load_ground(ground, unit=None):
    """(`TerrainSurface`, "mesh" or "dem") of a file. unit: of a raster's elevations. InputError: no such file, or kind.
    """
    kind = {**dict.fromkeys(MESHES, "mesh"), **dict.fromkeys(RASTERS, "dem")}.get(ground.suffix.lower())
    if kind is None:
        raise InputError(f"--terrain {ground}: must end in {', '.join(MESHES)} (a mesh), .asc or .tif (a raster)")
    if not ground.is_file():
        raise InputError(f"--terrain {ground}: no such file{nearest_file(ground)}")
    if unit and kind != "dem":
        raise InputError(f"--elevation-unit {unit}: goes with a raster, .asc or .tif; a mesh is in metres")
    table = (Dem if kind == "dem" else Mesh).model_construct(kind=kind, file=str(ground.resolve()), elevation_unit=unit)
    return load_terrain(table, dimension=3), kind


def _relative(path, file):
    """`path` as a scene in `file` names it: relative where it lies below the scene's folder."""
    path, folder = path.resolve(), file.resolve().parent
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else os.fspath(path)


def _vector(values):
    return f"[{', '.join(f'{value:.12g}' for value in values)}]"


def _pair(bounds):
    return f"[{bounds[0]:.12g}, {bounds[1]:.12g}]"


def _rounded(value):
    """Rounded down to 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    steps = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
    return float(f"{max(step for step in steps if step * power <= value * 1.001) * power:.6g}")
