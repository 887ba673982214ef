"""Rungs for flows: models without a flow, depth-averaged ones, and methods that resolve the depth."""

import numpy as np

from snowmpm.ladder.rung import CELLS, IN_3D, Rung, in_cells, nearest_cells, spacing
from snowmpm.methods import METHODS
from snowmpm.runout.alpha_beta import alpha_beta
from snowmpm.runout.block import GRAVITY, energy_line
from snowmpm.runout.ground import ground_of, ignored_parts
from snowmpm.runout.models import block_friction, blocks_of, way_of
from snowmpm.runout.profile import profile_of
from snowmpm.runout.routing import USUAL, route
from snowmpm.scenes.loader import with_overrides
from snowmpm.terrain.reference_system import ReferenceSystem

PLAN_CELLS = (20.0, 10.0, 5.0, 2.5)
"""Cells of depth-averaged rungs [m]."""
LEAST_CELLS = 12
"""Cells that a release has at least on such a rung."""
RESOLVED = {"card": "li_cold_dense", "critical_slope": 0.8}
"""Snow of a depth-averaged scene once its depth is resolved: that of the library's avalanche_on_raster."""
STATISTICS, LINE, BLOCK, ROUTING = "alpha-beta", "energy line", "block", "routing"
IN_PROFILE = "block in profile"
"""The same block: but of short slopes with much pressure in the snow, so that its errors are others."""
DEPTH, MPM, SPH = "depth", "mpm", "sph"
SHEET = 0.75
"""Cells below which the middle of the topmost particle lies where there is one sheet of them."""
ALONG = ("run-out", "peak-pressure")
TOLD = {STATISTICS: ("run-out",), LINE: ALONG, BLOCK: ALONG, ROUTING: (*ALONG, "affected-area")}
"""Questions that models without a flow answer."""
ZONE, SWITCH = "zone", "mpm, then depth"
ZONE_CELL, ZONE_CELLS = 5.0, (1, 2)
"""Cells of its columns at most [m], and of its particles over the depth of the snow."""
AROUND = 8.0
"""Cells of columns between an obstacle and the border of a zone."""
BLIND = {
    STATISTICS: "this avalanche: it knows the profile of the path alone, and the longest avalanches of other paths",
    LINE: "friction, volume and width: one angle for all avalanches (25 degrees)",
    BLOCK: "width, spreading and volume: one block with the friction of the ground",
    ROUTING: "friction, volume and time: one angle, spread over the raster",
    DEPTH: "what happens within the depth, the laws of the snow, flow round obstacles",
    ZONE: "what happens within the depth of the flow far from the obstacles",
    SWITCH: "what happens within the depth of the flow once half of the snow is faster than 5 m/s",
    MPM: "the air, and what is smaller than a cell",
    SPH: "the air, what is smaller than a particle, and the ground's friction but Coulomb's",
}


def rungs(facts, ask):
    """`Rung`s for a question about a flow, from the simplest model to the finest grid. facts: `SceneFacts`."""
    scene = facts.scene
    on_terrain = is_on_terrain(scene)
    if on_terrain:
        if not scene.events:  # what must break first does not flow from the start
            yield from _without_flow(facts, ask)
        yield from _in_plan(facts)
        yield from _in_two_methods(facts)
    elif scene.dimension == 2 and scene.terrain is not None and scene.terrain.kind == "profile":
        yield from _block_in_profile(facts, ask)
    for method in (MPM,) if on_terrain else (MPM, SPH):  # SPH fills the ground of a whole valley with particles
        yield from _resolved(facts, method)


def own_name(facts, group):
    """Name of the rung that a scene stands on, or is nearest to."""
    solver = facts.scene.solver
    if METHODS[solver.method].capabilities.plan:
        return _plan_name(min(PLAN_CELLS, key=lambda cell: max(cell / solver.dx, solver.dx / cell)))
    return _resolved_name(facts.scene, solver.method, nearest_cells(snow_depth(facts), solver.dx))


def snow_depth(facts):
    """Depth of the snow at the start [m]; columns, and particles of a single sheet, have their place in the middle of
    it."""
    sheet = METHODS[facts.scene.solver.method].capabilities.plan or facts.model.depth < SHEET * facts.dx
    return facts.model.depth * (2.0 if sheet else 1.0)


def is_on_terrain(scene):
    """Whether a scene is one in three dimensions on a raster or a mesh."""
    return scene.dimension == 3 and scene.terrain is not None and scene.terrain.kind in ("dem", "mesh")


def _resolved_name(scene, method, cells):
    """On a terrain a few cells over the depth do, where the way is a thousand times as long: rungs of their own."""
    return (IN_3D if is_on_terrain(scene) else "") + in_cells(method, cells)


def _plan_name(cell):
    return f"{DEPTH}, {cell:g} m"


def _in_plan(facts):
    extents = np.ptp(facts.model.population.positions[:, :2], axis=0)
    for cell in PLAN_CELLS:
        if np.prod(extents) >= LEAST_CELLS * cell**2:
            yield Rung(_plan_name(cell), BLIND[DEPTH], in_plan(facts.scene, cell))


def _in_two_methods(facts):
    """Columns with particles around the obstacles, and particles first with columns once they flow."""
    scene, extents = facts.scene, np.ptp(facts.model.population.positions[:, :2], axis=0)
    columns = METHODS[scene.solver.method].capabilities.plan
    cells = [cell for cell in PLAN_CELLS if np.prod(extents) >= LEAST_CELLS * cell**2]
    if not columns and not scene.obstacles:
        for cell in cells:
            yield Rung(f"{SWITCH}, {cell:g} m", BLIND[SWITCH], {
                "switch": [{"to": DEPTH, "solver": {"dx": cell, **kept(scene)}}]})
    if scene.obstacles and cells:
        cell = next((one for one in cells if one <= ZONE_CELL), cells[-1])
        bounds = np.array([one.bounds_at(0.0) for one in facts.model.obstacles])[:, :, :2]
        low, high = bounds[:, 0].min(axis=0) - AROUND * cell, bounds[:, 1].max(axis=0) + AROUND * cell
        region = {axis: [float(low[i]), float(high[i])] for i, axis in enumerate("xy")}
        for over in ZONE_CELLS:
            near = {"dx": spacing(snow_depth(facts), over), **kept(scene)}
            given = {"solver.depth.scheme": "columns"} if columns else {}
            yield Rung(in_cells(ZONE, over), BLIND[ZONE], {
                **in_plan(scene, cell), **given, **_resolved_snow(scene), "zone": {"region": region, "solver": near}})


def _resolved_snow(scene):
    """Changes that give the snow of a depth-averaged scene a law, by which it resists within its depth."""
    if not METHODS[scene.solver.method].capabilities.plan:
        return {}
    return {f"materials.{name}": {**RESOLVED, "density": law.density} for name, law in scene.materials.items()}


def in_plan(scene, cell):
    """Changes that make a scene depth-averaged on cells of this side [m]."""
    if METHODS[scene.solver.method].capabilities.plan:
        return {"solver.dx": cell}
    return {"solver": {"method": DEPTH, "dx": cell, **kept(scene)}, "initial": {}}


def kept(scene):
    """Of [solver], what holds for every method, where the scene gives it."""
    return {"precision": scene.solver.precision} if "precision" in scene.solver.model_fields_set else {}


def _resolved(facts, method):
    scene, depth = facts.scene, snow_depth(facts)
    in_plan = METHODS[scene.solver.method].capabilities.plan
    snow = {"initial.stress": "geostatic", **_resolved_snow(scene)} if in_plan else {}
    for cells in CELLS:
        dx = spacing(depth, cells)
        own = {"solver.dx": dx} if scene.solver.method == method else {
            "solver": {"method": method, "dx": dx, **kept(scene)}}
        yield Rung(_resolved_name(scene, method, cells), BLIND[method], {**own, **snow})


def _without_flow(facts, ask):
    """Models of `snowmpm.runout` over the ground of a scene."""
    def ground():
        cell = min(PLAN_CELLS, key=lambda one: abs(np.log(one / _raster_cell(facts))))
        return ground_of(with_overrides(facts.scene, in_plan(facts.scene, cell)))

    def profile(over):
        if ask.path is not None:
            system = ReferenceSystem.of_text(over.crs, "the terrain") if over.crs else None
            return profile_of(ask.path(system), over.height, "--path")
        return profile_of(way_of(over), over.height, "the way of most snow")

    def statistics():
        return _known({"run-out": alpha_beta(profile(ground())).runouts[0]})

    def line():
        path = profile(ground())
        return along(path, energy_line(path, USUAL.angle))

    def slides():
        over = ground()
        path = profile(over)
        slide, = blocks_of(path, over.friction, over.thickness).values()
        return along(path, slide)

    def along(path, slide):
        values = _known({"run-out": slide.runout})
        if ask.place is not None:
            away = np.linalg.norm(path.plan - ask.place, axis=1)
            wide = 0.5 * np.sqrt(np.prod(np.ptp(facts.model.population.positions[:, :2], axis=0)))
            if away.min() <= wide:  # a point has no width: half of that of the release
                values["peak-pressure"] = _density(facts) * float(slide.speed[away.argmin()]) ** 2
        return values

    def routed():
        over = ground()
        found = route(over.z, over.cell, over.release, USUAL)
        values = {"run-out": float(np.nanmax(found.length)),
                  "affected-area": float(np.isfinite(found.energy).sum() * over.cell**2)}
        if ask.place is not None:
            cell = tuple(np.floor((ask.place - over.lower) / over.cell).astype(int))
            inside = all(0 <= i < n for i, n in zip(cell, found.energy.shape, strict=True))
            height = np.nan_to_num(found.energy[cell]) if inside else 0.0
            values["peak-pressure"] = float(_density(facts) * 2.0 * GRAVITY * height)
        return values

    ignored = ignored_parts(facts.scene)
    for name, answers in ((STATISTICS, statistics), (LINE, line), (BLOCK, slides), (ROUTING, routed)):
        if ask.question.name not in TOLD[name] or (
                name == BLOCK and block_friction(facts.model.friction.law) is None):
            continue
        blind = f"{BLIND[name]}; of this scene {', '.join(ignored)}" if ignored else BLIND[name]
        yield Rung(name, blind, answers=answers, unlike=bool(ignored))


def _known(values):
    """Those that are not None."""
    return {name: value for name, value in values.items() if value is not None}


def _raster_cell(facts):
    lattice = facts.model.surface.lattice
    return lattice[1] if lattice is not None else 5.0


def _density(facts):
    scene = facts.scene
    return float(np.mean([scene.materials[body.material].density for body in scene.bodies]))


def _block_in_profile(facts, ask):
    """A block on the ground of a scene in profile: where it stops, and the load of a stream as deep as the release."""
    def answers():
        scene, surface = facts.scene, facts.model.surface
        x = facts.model.population.positions[:, 0]
        heights = surface.height(np.array([[x.min()], [x.max()]]))
        ground = surface.vertices[:, 0]
        first, end = (x.min(), ground.max()) if heights[0] > heights[1] else (x.max(), ground.min())
        line = [[first, 0.0], [first + (1.0 - 1e-6) * (end - first), 0.0]]
        profile = profile_of(line, lambda plan: surface.height(plan[:, :1]), scene.source, spacing=facts.dx)
        slide, = blocks_of(profile, facts.model.friction.law, facts.model.depth).values()
        values = _known({"run-out": slide.runout})
        chosen = [one for one in facts.model.obstacles if ask.obstacle in (None, one.name)]
        if chosen:
            near = min(abs(bound[0] - first) for one in chosen for bound in one.bounds_at(0.0))
            speed = float(np.interp(near, profile.s, slide.speed))
            values["load"] = _density(facts) * speed**2 * facts.model.depth
        return values

    if block_friction(facts.model.friction.law) is not None:
        yield Rung(IN_PROFILE, BLIND[BLOCK], answers=answers)
