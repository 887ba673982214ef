"""Refusal of scenes that ask for more than their method can do, from its capabilities."""

from collections.abc import Collection
from typing import Any

from snowmpm import components
from snowmpm.errors import InputError
from snowmpm.methods import METHODS, has, who_can
from snowmpm.saw_test.weak_layer import weak_layer_of
from snowmpm.scenes.depth_scheme import for_columns
from snowmpm.scenes.friction_cards import possible_laws
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.shapes import ThicknessRaster
from snowmpm.scenes.switch import BROKEN, parts
from snowmpm.scenes.zone import within
from snowmpm.schemes import BASES


def demands(scene, later=False):
    """(capability, required value or member, key, value) of each request of a scene; later: of the part of a method
    that takes over, when the start and the events are over."""
    able = METHODS[scene.solver.method].capabilities
    yield "dimensions", scene.dimension, "dimension", scene.dimension
    yield "precisions", scene.solver.precision, "solver.precision", scene.solver.precision
    if BASES[scene.solver.kernel].box:
        yield "averaged_hats", True, "solver.kernel", scene.solver.kernel
    if scene.saw_test:
        yield "saw_test", True, "solver.method", scene.solver.method
    if scene.terrain:
        yield "terrain", True, "terrain.kind", scene.terrain.kind
        yield "contacts", scene.terrain.contact, "terrain.contact", scene.terrain.contact
        yield from _of_friction(scene.terrain)
    if scene.obstacles:
        yield "obstacles", True, "obstacles.0.name", scene.obstacles[0].name
    for i, obstacle in enumerate(scene.obstacles):
        if obstacle.motion:
            yield "moving_obstacles", True, f"obstacles.{i}.motion", "a table"
    for i, body in enumerate(scene.bodies):
        if body.start_time > 0.0:
            yield "delays", True, f"bodies.{i}.start_time", body.start_time
        if isinstance(raster := body.shape.get("top"), ThicknessRaster):
            yield "thickness_rasters", True, f"bodies.{i}.shape.top.file", raster.file
    for name, boundary in (scene.domain.sides(scene.dimension) if scene.domain else {}).items():
        yield "sides", boundary, f"domain.boundary.{name}", boundary
    if scene.domain and "periodic" in scene.domain.sides(scene.dimension).values():
        yield "periodic", True, "domain.boundary", "periodic"
    if scene.initial.stress != "none" and not later:
        yield "initial_stress", scene.initial.stress, "initial.stress", scene.initial.stress
    if scene.initial.stress == "settle" and not later:
        yield "settling", True, "initial.stress", scene.initial.stress
    for i, event in enumerate(scene.events):
        if later and not (event.kind == "load" and event.stop is None):
            continue
        if event.NEEDS:
            yield event.NEEDS, True, f"events.{i}.kind", event.kind
    for component in components.used(scene):
        for key, value in component.asked(scene):
            if not (later and able.plan and key.startswith("materials.")):  # columns have no strength
                yield component.name, True, key, value


def _of_friction(terrain):
    """Demands of the friction of the ground, a number or a law."""
    friction = terrain.friction
    if isinstance(friction, int | float):
        if friction and terrain.contact != "stick":
            yield "ground_friction", "coulomb", "terrain.friction", friction
        return
    for law in possible_laws(friction):
        yield "ground_friction", law.law, "terrain.friction.law", law.law
        for name in ("tau0", "cohesion"):
            if law.get(name, 0.0) != 0.0:
                yield "ground_cohesion", True, f"terrain.friction.{name}", law[name]
        for name, raster in law.rasters.items():
            yield "ground_rasters", True, f"terrain.friction.{name}.file", raster.file


def refuse_beyond(scene):
    """Raise InputError for a scene that asks for something its method cannot do, or one that takes over.

    Obstacles need one method that has them: until it takes over, and after it, the snow must be elsewhere.
    """
    scenes = parts(scene)
    obstacles = any(METHODS[part.solver.method].capabilities.obstacles for part in scenes)
    for i, part in enumerate(scenes):
        for capability, wanted, key, value in demands(part, later=i > 0):
            if capability == "obstacles" and obstacles:
                continue
            try:
                require(part, capability, key, value, wanted)
            except InputError as error:
                if i == 0:
                    raise
                raise InputError(f"{error}; switch.{i - 1} hands over to it") from None
    for refusals in (_volumes, _switches, _zone, _uncomputed, _cuts, _cracks, _averaged_hats, _beside_components,
                     _narrow_bins):
        for key, value, allowed in refusals(scene):
            raise InputError.at(key, value, allowed, scene.source)


OF_THE_RELEASE = ("delays", "thickness_rasters")
"""Capabilities that a zone's method need not have: its snow comes from the columns."""


def _zone(scene):
    """Refusals of a region in three dimensions that cannot be."""
    if not scene.zone:
        return
    for capability, key, name, where in (
            ("around_zone", "solver.method", scene.solver.method, " around a zone"),
            ("within_zone", "zone.solver.method", scene.zone.solver.method, "")):
        if not has(name, capability):
            allowed = " or ".join(f'"{other}"' for other in who_can(capability))
            yield key, name, f"must be {allowed}{where}"
    beside = {"switch.0.to": scene.switch and scene.switch[0].to, "initial.from": scene.initial.from_run}
    for key, value in beside.items():
        if value:
            yield key, value, "does not go with zone, which hands over all the time"
    if scene.domain and "periodic" in scene.domain.sides(scene.dimension).values():
        yield "domain.boundary", "periodic", "does not go with zone"
    part = within(scene)
    for capability, wanted, key, value in demands(part, later=True):
        if capability not in OF_THE_RELEASE:
            try:
                require(part, capability, key, value, wanted)
            except InputError as error:
                raise InputError(f"{error}; zone computes with it") from None


def _uncomputed(scene):
    """Refusals of keys that a component computes, where there is no such component."""
    asked = {key for component in components.used(scene) for key, _ in component.asked(scene)}
    if isinstance(scene.gravity, Gravity) and "gravity" not in asked:
        yield "gravity", "a table", "needs a component that is not installed"
    for name, law in scene.materials.items():
        for key, value in law.of_components.items():
            if f"materials.{name}.{key}" not in asked:
                yield f"materials.{name}.{key}", value, "needs a component that is not installed"
    if scene.water is not None and not any(key.startswith("water.") for key in asked):
        yield "water.scheme", scene.water.scheme, "needs a component that is not installed"


def _cuts(scene):
    """Refusals of saw cuts of what has no bonds that a cut could sever."""
    materials = {body.name: scene.materials[body.material] for body in scene.bodies}
    for i, event in enumerate(scene.events):
        if event.kind == "cut" and materials[event.body].severed_state() is None:
            yield (f"events.{i}.body", event.body,
                   f"cannot be cut: {materials[event.body].kind} has no bonds to lose")


def _narrow_bins(scene):
    """Refusals of a record of a saw test that is finer than the grid or the interface points."""
    test = scene.saw_test
    if test and test.resolution is not None and test.resolution < (least := weak_layer_of(scene).finest):
        yield ("saw_test.resolution", test.resolution,
               f"must be at least {least:g}, the spacing of the grid nodes or of the interface points")


def _cracks(scene):
    """Refusals of material that cracks in steps that are solved for."""
    if METHODS[scene.solver.method].capabilities.solves:
        for name, law in scene.materials.items():
            if law.kind == "cohesive_crack":
                yield (f"materials.{name}.kind", law.kind,
                       'does not go with "implicit", where the particles of a cell do not deform as one: take "mpm"')


def _averaged_hats(scene):
    """Refusals of a kernel of comparison beside what nothing was compared for."""
    solvers = {"solver": scene.solver, **{f"switch.{i}.solver": one.solver for i, one in enumerate(scene.switch)},
               **({"zone.solver": scene.zone.solver} if scene.zone else {})}
    for key, solver in solvers.items():
        if BASES[solver.kernel].box:
            beside = {"switch": scene.switch, "zone": scene.zone,
                      'initial.relaxation = "static"': scene.initial.relaxation == "static"}
            if found := [name for name, there in beside.items() if there]:
                yield (f"{key}.kernel", solver.kernel,
                       f'must be "quadratic" or "cubic" beside {" and ".join(found)}')


FEATURES = {
    "periodic sides of the domain": lambda scene: scene.domain and "periodic" in scene.domain.sides(
        scene.dimension).values(),
    "initial.from": lambda scene: scene.initial.from_run is not None,
    "solver.kernel": lambda scene: BASES[scene.solver.kernel].box,
}
"""Parts of a scene that no key alone tells, and that not all components go with."""


def _has(scene, name):
    """Whether a scene has one of FEATURES, a table of this name, or a key with a value, 'table.key = "value"'."""
    if name in FEATURES:
        return FEATURES[name](scene)
    key, _, value = name.partition(" = ")
    for part in key.split("."):
        scene = scene and scene.get(part)
    return f'"{scene}"' == value if value else bool(scene)


def _beside_components(scene):
    """Refusals of a component beside what does not know it, and beside one that has what it needs."""
    owners: dict[str, Any] = {}
    used = components.used(scene)
    for component in used:
        found = [f'{name} = "{scene.solver.kernel}"' if name == "solver.kernel" else name
                 for name in component.beside if _has(scene, name)]
        key, value = next(iter(component.asked(scene)))
        if not component.alone:
            found += [_named(other, scene) for other in used if other.alone]
        if found:
            yield key, value, f"does not go with {' and '.join(found)}"
        for needed in component.owns:
            if (first := owners.setdefault(needed, component)) is not component:
                yield key, value, f"does not go with {next(iter(first.asked(scene)))[0]}: both act on {needed}"
        if component.double and scene.solver.precision != "f64":
            yield "solver.precision", scene.solver.precision, f'must be "f64" {component.double}'
        if component.refuse:
            component.refuse(scene)
    yield from _events(scene, used)


def _named(component, scene):
    """A component by the first key that asks for it, and its value."""
    key, value = next(iter(component.asked(scene)))
    return f'{key} = "{value}"'


def _events(scene, used):
    """Refusals of an event of a component that does not know it."""
    taken = {kind for component in used for kind in component.events}
    for i, event in enumerate(scene.events):
        if event.OF and event.kind not in taken:
            of = next(_named(component, scene) for component in used
                      if next(iter(component.asked(scene)))[0].startswith(f"{event.OF}."))
            yield f"events.{i}.kind", event.kind, f"does not go with {of}"


def _volumes(scene):
    """Refusals of what needs columns, where the scene asks for volumes."""
    for i, part in enumerate(parts(scene)):
        if part.solver.in_volumes:
            for key, value, why in for_columns(part, last=i == len(scene.switch)):
                yield key, value, f'{why}, and the scene has solver.depth.scheme = "volumes"'


def _switches(scene):
    """Refusals of hand-overs that cannot be."""
    methods = [part.solver.method for part in parts(scene)]
    for i, switch in enumerate(scene.switch):
        yield from _switch(scene, i, switch, *methods[i : i + 2])


def _switch(scene, i, switch, first, second):
    """Refusals of a hand-over from the method `first` to `second`."""
    key, before, after = f"switch.{i}.to", METHODS[first].capabilities, METHODS[second].capabilities
    if before.solves:
        yield "solver.method", first, "does not hand over: leave switch out"
    if before.plan == after.plan:
        allowed = " or ".join(f'"{name}"' for name, entry in METHODS.items()
                              if entry.capabilities.plan != before.plan and not entry.capabilities.solves)
        yield key, switch.to, f'must be {allowed} after "{first}"'
    if scene.terrain is None:
        yield key, switch.to, "needs a terrain"
    if any(scene.gravity_vector[:-1]):
        yield key, switch.to, "needs gravity that points down"
    if scene.domain and "periodic" in scene.domain.sides(scene.dimension).values():
        yield key, switch.to, "needs sides of the domain that are not periodic"
    bonds = any(law.BONDS is not None and law.bonds_last_below > 0.0 for law in scene.materials.values())
    if switch.when == BROKEN and (before.plan or not bonds):
        yield (f"switch.{i}.when", switch.when,
               "needs a material with bonds, such as anticrack_cam_clay, and particles in space")


def require(scene, capability, key, value, wanted=True, what=""):
    """Raise InputError for `key` = `value` if the scene's method lacks a capability.

    what: text of the message, if the key is not enough.
    """
    name = scene.solver.method
    if has(name, capability, wanted):
        return
    others = " or ".join(f'"{other}"' for other in who_can(capability, wanted)) or "another one"
    own = vars(METHODS[name].capabilities).get(capability)
    bound = f", which has {' and '.join(map(str, own))} only" if isinstance(own, Collection) else ""
    if key == "solver.method":
        allowed = f"must be {others} {what or f'beside {capability}'}"
    else:
        allowed = f'needs solver.method = {others} in place of "{name}"{bound}'
    raise InputError.at(key, value, allowed, scene.source)
