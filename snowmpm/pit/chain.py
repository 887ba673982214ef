"""From a snow pit to hazard maps: profile, stability, release on the local slope, flow, and what the result depends on.

Every step writes files that the next one reads, and that a user may replace and go on from: `saw_test.toml`,
`release.toml`, `release.gpkg`, `flow.toml`.
"""

import json
import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import snowmpm
from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.gis.outlines import outline
from snowmpm.io.ground_maps import Map
from snowmpm.pit import mechanics, record, release_scenes, released, scenes
from snowmpm.pit.column import Column, column_of
from snowmpm.pit.profile import SnowProfile
from snowmpm.pit.stability import Stability, stability_of
from snowmpm.scenes import load_scene
from snowmpm.scenes.edited import edited
from snowmpm.setup import first_scene

SIZE = 28.0
"""Side of the square of weak layer [thicknesses of the slab], if nobody gives one: 40 to 60 thousand particles."""
LONGEST = 400.0
"""Of that side [m]: beyond, the release takes days."""
FRICTION = "samos_at_auto"
OTHER_FRICTIONS = "voellmy_avaframe", "voellmy_buser_frutiger"
"""Cards of published classes that the flow is computed with besides."""
THICKER, LARGER = 1.25, 2.0
"""Factors by which the thickness and the area of the release are varied, up and down: chosen, as one pit does not tell
how either changes across the slope."""
HIGHER, STEEPER = 100.0, 5.0
"""Differences of elevation [m] and slope [degrees] between pit and terrain that are told."""
STEEP, STEEPEST, WHOLE = 30.0, 55.0, 200.0
"""Slopes [degrees] on which slabs release, and how far from the pit [m] the weak layer may go on: chosen."""
NAMES = ("profile.png", "saw_test.toml", "release.toml", "release.gpkg", "release.tif", "flow.toml",
         "chain.json", "report.html")
FOLDERS = "release", "flow", "variations", "maps", "pictures"
WHOLE_SLOPE = "whole_slope"
NUMBERS = ("runout", "affected_area", "area_above_1_kPa", "largest_flow_speed", "largest_flow_pressure")


@dataclass(frozen=True)
class Slope:
    """surface: of the terrain; place (2,), map coordinates [m]; angle [degrees] and down (2,), unit vector in plan, of
    the ground over `width` [m] around it; file: of the terrain."""

    surface: Any
    place: np.ndarray
    angle: float
    down: np.ndarray
    width: float
    file: Path


@dataclass(frozen=True)
class Variation:
    """A flow with one thing changed: what; step: of the chain that it belongs to; numbers by name."""

    name: str
    what: str
    step: str
    numbers: dict[str, float | None]


@dataclass
class Chain:
    """All that was found. texts: of the scenes, by file; notes: where pit and terrain do not agree; released, flow:
    None where the slab did not go, and why."""

    profile: SnowProfile
    candidates: list
    index: int
    column: Column
    stability: Stability
    slope: Slope
    side: float
    folder: Path
    texts: dict[str, str]
    notes: tuple[str, ...] = ()
    released: Any = None
    why: str = ""
    flow: Any = None
    variations: tuple[Variation, ...] = ()

    @property
    def base(self) -> dict[str, float | None]:
        return self.variations[0].numbers if self.variations else {}

    def spread(self, name: str = "runout") -> dict[str, tuple[float, float]]:
        """{step: (least, largest) change of a number} over the variations of each step, the area being about that of
        the square that was computed."""
        found: dict[str, tuple[float, float]] = {}
        reference = self.base.get(name)
        for one in self.variations[1:]:
            value = one.numbers.get(name)
            if value is not None and reference is not None and one.name != WHOLE_SLOPE:
                low, high = found.get(one.step, (0.0, 0.0))
                found[one.step] = min(low, value - reference), max(high, value - reference)
        return found

    @property
    def dominant(self) -> tuple[str, float, float] | None:
        """(step, least, largest change of the run-out [m]) of the step on which the run-out depends most, once the area
        is known."""
        spread = self.spread()
        if not spread:
            return None
        step = max(spread, key=lambda one: spread[one][1] - spread[one][0])
        return step, *spread[step]

    @property
    def whole(self) -> Variation | None:
        """The flow of all steep ground around the pit."""
        return next((one for one in self.variations if one.name == WHOLE_SLOPE), None)

    def dependence(self) -> list[str]:
        """What the result depends on, in sentences."""
        said = []
        if self.whole is not None and self.whole.numbers.get("runout") is not None:
            said.append(f"The run-out depends most on how large the release is, which a pit does not tell:"
                        f" {self.base['runout']:.0f} m from the square that was computed,"
                        f" {self.whole.numbers['runout']:.0f} m from {self.whole.what}.")
        if self.dominant is not None:
            step, low, high = self.dominant
            said.append(f"With the area of the release known about, it depends most on {step}: {low:+.0f} to"
                        f" {high:+.0f} m.")
        if self.stability.dominant:
            theory, name, share = self.stability.dominant
            said.append(f"The critical cut length ({record.NAMES[theory]}) depends most on {name}: {100 * share:.0f} %"
                        " of its variance. It is no part of the release, which takes the strength of the weak layer.")
        return said


def slope_at(file: Path, place: Any, width: float) -> Slope:
    """`Slope` of a terrain at a place in map coordinates [m]. Raises InputError where the terrain does not know it."""
    surface, kind = first_scene.load_ground(file)
    if kind != "dem":
        raise InputError(f"--terrain {file}: must be an elevation raster, .asc or .tif: maps are made on it")
    place = np.asarray(place, float)
    low, high = surface.lower[:2], surface.upper[:2]
    if not np.isfinite(surface.height(place[None])).all():
        raise InputError(f"--at {place[0]:.10g},{place[1]:.10g}: not on the terrain, which knows x from {low[0]:.10g}"
                         f" to {high[0]:.10g} and y from {low[1]:.10g} to {high[1]:.10g}, less its holes")
    gradient = surface.gradient(place[None], width)[0]
    steep = float(np.hypot(*gradient))
    if not steep > 0.0:
        raise InputError(f"--at {place[0]:.10g},{place[1]:.10g}: the ground is level there: no slab slides")
    return Slope(surface, place, math.degrees(math.atan(steep)), -gradient / steep, width, file)


def release_of(chain: Chain, say: Any) -> None:
    """Compute the release on the local slope, and write it as polygon and raster; `why` where nothing goes."""
    for name, text in chain.texts.items():
        write_text(chain.folder / name, text)
    say(f"release: {chain.side:.0f} m of weak layer on {chain.slope.angle:.0f} degrees")
    run = snowmpm.run(load_scene(chain.folder / "release.toml"), chain.folder / "release")
    try:
        chain.released = released.released_by(run)
    except InputError as error:
        chain.why = str(error).partition(": ")[2]
        return
    released.write(chain.released, run, chain.folder)


def flow_of(chain: Chain, say: Any) -> None:
    """Compute the flow from the release, and the variations of `Variation`s."""
    found, folder = chain.released, chain.folder
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        text, _ = first_scene.scene_on_ground(
            "flow", folder / "flow.toml", chain.slope.file, folder / "release.gpkg", found.thickness, None, True)
    file = write_text(folder / "flow.toml", text)
    values, _ = first_scene.outlook(load_scene(file))
    text = edited(text, values)
    write_text(file, text)
    scene = load_scene(file)
    area = found.outline(_origin(chain)).buffer(0.0)
    changes = {
        "as found": ("-", "", {}),
        **{card: (f"friction {card} for {FRICTION}", "flow: friction", {"terrain.friction": {"card": card}})
           for card in OTHER_FRICTIONS},
        "thicker": (f"thickness of the release x {THICKER:g}", "release: thickness",
                    {"bodies.0.shape.top": THICKER * found.thickness}),
        "thinner": (f"thickness of the release / {THICKER:g}", "release: thickness",
                    {"bodies.0.shape.top": found.thickness / THICKER}),
        "larger": (f"area of the release x {LARGER:g}", "release: area", resized(area, LARGER)),
        **_whole_slope(chain),
        "smaller": (f"area of the release / {LARGER:g}", "release: area", resized(area, 1.0 / LARGER)),
    }
    done = []
    for name, (what, step, change) in changes.items():
        say(f"flow: {what if change else name}")
        target = folder / ("flow" if not change else f"variations/{name}")
        try:
            run = snowmpm.run(load_scene(file, change) if change else scene, target)
        except (InputError, SimulationError) as error:
            if not change:
                raise
            say(f"warning: {what}: not computed: {error}")
            continue
        chain.flow = chain.flow or run
        numbers = (run.hazard or {}).get("numbers", {})
        done.append(Variation(name, what, step, {key: numbers.get(key) for key in NUMBERS}))
    chain.variations = tuple(done)


def _origin(chain):
    from snowmpm.io import Run

    return Run(chain.folder / "release").origin


def resized(area, factor):
    """Change of the scene that makes the release `factor` times as large, by a border all round."""
    low, high = -0.5 * math.sqrt(area.area), 2.0 * math.sqrt(area.area)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if area.buffer(middle).area < factor * area.area else (low, middle)
    grown = area.buffer(0.5 * (low + high))
    if grown.geom_type != "Polygon":
        grown = max(grown.geoms, key=lambda part: part.area)
    return _corners(grown.simplify(0.5))


def _corners(polygon):
    corners = np.array(polygon.exterior.coords)[:-1]
    return {"bodies.0.shape.region": {"polygon": [[float(x), float(y)] for x, y in corners]}}


def _whole_slope(chain):
    """The change that releases all ground steeper than STEEP around the place, within WHOLE on either side: what the
    avalanche may be where the weak layer goes on. Nothing where that is no larger than what was found."""
    from scipy import ndimage

    surface, cell = chain.slope.surface, max(chain.slope.surface.lattice[1], 2.0)
    n = int(WHOLE / cell)
    lower = chain.slope.place - (n + 0.5) * cell
    axes = [lower[k] + cell * (np.arange(2 * n + 1) + 0.5) for k in (0, 1)]
    plan = np.stack(np.meshgrid(*axes, indexing="xy"), axis=-1).reshape(-1, 2)
    steep = np.degrees(np.arctan(np.hypot(*surface.gradient(plan, cell).T))).reshape(2 * n + 1, 2 * n + 1)
    mask = (steep >= STEEP) & (steep <= STEEPEST)
    mask[n, n] = True
    parts, _ = ndimage.label(mask)
    whole = outline(parts == parts[n, n], Map(steep, 0.5 * cell, 0.5 * cell, cell, "degrees"), lower)
    polygon = max(whole.geoms, key=lambda part: part.area)
    if polygon.area <= LARGER * chain.released.area:
        return {}
    return {WHOLE_SLOPE: (f"all ground from {STEEP:g} to {STEEPEST:g} degrees there, {polygon.area:.0f} m2",
                            "release: area", _corners(polygon))}


def assumptions(chain: Chain) -> list[tuple[str, str, str]]:
    """(step, what is assumed, source) of all that no file says."""
    column, found = chain.column, [("profile", text, "the file") for text in chain.profile.notes]
    found += [("profile", text, "Geldsetzer & Jamieson (2000)" if "Geldsetzer" in text else "chosen")
              for text in column.assumed]
    found += [
        ("profile", "the snow of the pit lies all over the slope, with the same layers and thickness normal to it",
         "chosen"),
        ("stability", "moduli from densities", mechanics.MODULI[column.law][0]),
        ("stability", "shear strength from form and density", "Jamieson & Johnston (2001)"),
        ("stability", f"collapse energy {column.weak.energy:g} J/m2, known to a factor of"
                      f" {math.exp(mechanics.COLLAPSE_SCATTER):.1f}", "WEAC; van Herwijnen et al. (2016)"),
        ("release", f"the area: a square of weak layer of {chain.side:.0f} m, firm snow beyond: the pit does not say"
                    " how far the weak layer goes", "chosen; --size"),
        ("release", f"the shear strength of the weak layer is at least {scenes.BEARS:g} times the shear stress of the"
                    " slab, as the slope stands", "chosen"),
        ("release", f"friction coefficient of a crushed weak layer {release_scenes.FRICTION:.2f}", "chosen"),
        ("release", "tensile strength of the slab from its density", "Sigrist (2006)"),
        ("release", f"moduli are at most {1e-6 * release_scenes.STIFFEST:g} MPa, for shorter computing", "chosen"),
        ("flow", f"friction {FRICTION}, by the volume of the release; calibrated with the entrainment and the numbers"
                 " of its own program", "AvaFrame com1DFA (SamosAT)"),
        ("flow", "density of 200 kg/m3, for which that friction is; no entrainment, no forest", "chosen"),
    ]
    return found


def record_of(chain: Chain) -> dict[str, Any]:
    """All numbers of a chain."""
    found = chain.released
    return {
        "profile": chain.profile.source, "terrain": str(chain.slope.file), "at": chain.slope.place.tolist(),
        "local_slope": chain.slope.angle, "size": chain.side,
        "stability": record.record_of(chain.profile, chain.candidates, chain.index, chain.column, chain.stability),
        "release": None if found is None else {
            "area": found.area, "thickness": found.thickness, "volume": found.volume, "border_on_patch": found.edge},
        "no_release": chain.why or None,
        "variations": [{"name": one.name, "what": one.what, "step": one.step, **one.numbers}
                       for one in chain.variations],
        "runout_depends_on": None if chain.dominant is None else dict(
            zip(("step", "least", "largest"), chain.dominant, strict=True)),
        "critical_length_depends_on": None if chain.stability.dominant is None else dict(
            zip(("theory", "input", "share"), chain.stability.dominant, strict=True)),
        "dependence": chain.dependence(), "notes": chain.notes,
        "assumptions": [dict(zip(("step", "what", "source"), one, strict=True)) for one in assumptions(chain)],
    }


def begin(profile: SnowProfile, candidates: list, index: int, terrain: Path, place: Any, folder: Path,
          modulus: str = mechanics.USUAL_MODULUS, size: float | None = None, depth: float | None = None) -> Chain:
    """`Chain` up to stability, with the angle of the local slope; nothing is written. size: of the weak layer [m];
    depth: at which it fails [m]. Needs a running Taichi. Raises InputError for what no slab can be released from.
    """
    width = 0.5 * size if size else 0.5 * SIZE * profile.layers[index].top
    slope = slope_at(terrain, place, width)
    column = column_of(profile, index, slope.angle, modulus, depth)
    tearing = release_scenes.tearing_length(column)  # refuses a slope on which no slab slides
    side = size or max(SIZE * column.thickness, 2.0 * tearing)
    if side > LONGEST:
        raise InputError(f"the slab tears only where it is {0.5 * side:.0f} m long, and a release of {side:.0f} m takes"
                         f" too long; --size, at most {LONGEST:g} m, gives another")
    stability = stability_of(column)
    try:
        texts = _scenes(profile, column, stability, slope, side)
    except InputError as error:
        raise InputError(f"{profile.source}: weak layer at {100 * profile.layers[index].top:.4g} cm, --at"
                         f" {place[0]:.10g},{place[1]:.10g}: {error}") from None
    return Chain(profile, candidates, index, column, stability, slope, side, folder, texts,
                 tuple(_disagreements(profile, slope)))


def _scenes(profile, column, stability, slope, side):
    """{file: text} of the saw test and of the release."""
    soft = release_scenes.of_release(column)
    return {
        "saw_test.toml": scenes.saw_test_scene(column, scenes.weak_law(column), "saw_test", profile.name,
                                               stability.expected),
        "release.toml": release_scenes.release_on_terrain(
            soft, scenes.weak_law(soft, release_scenes.RUBS), "release", profile.name, surface=slope.surface,
            file=str(slope.file.resolve()), place=slope.place, side=side, down=slope.down)}


def _disagreements(profile, slope):
    """Where pit and terrain do not agree."""
    height = float(slope.surface.height(slope.place[None])[0])
    if profile.elevation is not None and abs(profile.elevation - height) > HIGHER:
        yield f"the pit was at {profile.elevation:.0f} m, and the terrain there is at {height:.0f} m"
    if profile.slope_angle is not None and abs(profile.slope_angle - slope.angle) > STEEPER:
        yield f"the pit was on {profile.slope_angle:.0f} degrees, and the terrain there has {slope.angle:.0f}"


def write_numbers(chain: Chain) -> Path:
    """Write chain.json."""
    return write_text(chain.folder / "chain.json", json.dumps(record_of(chain), indent=1, ensure_ascii=False) + "\n")
