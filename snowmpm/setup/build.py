"""From a scene to its model: particles on their terrain, obstacles, initial stress."""

from typing import Any

import numpy as np

from snowmpm import components
from snowmpm.compiler import runtime
from snowmpm.errors import InputError
from snowmpm.particles.population import Population
from snowmpm.scenes.shapes import ThicknessRaster
from snowmpm.scenes.space import AXES
from snowmpm.seeding import seed_body
from snowmpm.setup.initial_state import stress_from_weight, uniform_pressure
from snowmpm.setup.model import TERRAIN_REACH, Model, course_of
from snowmpm.setup.obstacle_reach import refuse_unreachable
from snowmpm.setup.refusals import refuse_beyond
from snowmpm.setup.taken_state import TakenState, take
from snowmpm.solids import Obstacle, inside_any
from snowmpm.stages import counted, stage
from snowmpm.terrain import load_terrain


def build(scene, kept=None):
    """Check what depends on geometry, and make the model of a scene. Raises InputError.

    kept: run folder that holds the state from another run, if the scene was built before.
    """
    refuse_beyond(scene)
    if scene.domain and scene.domain.min is None and "periodic" in scene.domain.sides(scene.dimension).values():
        raise InputError.at("domain.boundary", "periodic", "needs domain.min and domain.max", scene.source)
    runtime.start()
    with stage("reading the terrain"):
        surface = _surface(scene)
    made, segments = components.standing(scene)
    obstacles = [*_obstacles(scene, surface), *segments]
    taken = None
    if scene.initial.from_run is not None:
        taken = take(scene, surface) if kept is None else TakenState.kept(kept)
    seeds, starts, shares = _seed(scene, surface, obstacles, taken)
    lower, upper = _domain(scene, surface, seeds)
    outside = ~((seeds.positions >= lower) & (seeds.positions < upper)).all(axis=1)
    if outside.any():
        i = np.searchsorted(starts, np.flatnonzero(outside)[0], side="right") - 1
        raise InputError(f"{scene.source}: bodies.{i} ({scene.bodies[i].name}): reaches outside the domain"
                         f" {np.round(lower, 3).tolist()} to {np.round(upper, 3).tolist()}")
    model = Model(scene, surface, lower, upper, seeds, starts, obstacles, shares, taken, made)
    refuse_unreachable(model)
    if scene.dimension == 3:
        model.map_grid  # noqa: B018 (refuses a cell that cannot be, before anything is computed)
    with stage("initial stress"):
        if scene.initial.stress == "isotropic":
            uniform_pressure(model)
        elif scene.initial.stress != "none" and taken is None and not scene.solver.in_plan:
            stress_from_weight(model)
    return model


def _surface(scene):
    if scene.terrain is None:
        return None
    extent = _extent(scene)
    if extent is None and (scene.terrain.kind == "plane" or (scene.terrain.kind, scene.dimension) == ("profile", 3)):
        raise InputError(f"{scene.source}: domain: a {scene.terrain.kind} needs domain.min and domain.max, to know how"
                         " far it reaches")
    try:
        return load_terrain(scene.terrain, scene.base_dir, dimension=scene.dimension, extent=extent)
    except InputError as error:
        raise InputError(f"{scene.source}: {error}") from None


def _extent(scene):
    """Plan box [m] of the terrain that is used: of the domain and of the raster's region; None for all of it."""
    boxes: list[tuple[Any, ...]] = []
    if scene.domain and scene.domain.min:
        boxes.append((scene.domain.min[: scene.dimension - 1], scene.domain.max[: scene.dimension - 1]))
    region = scene.terrain and scene.terrain.get("region")
    if region is not None:
        free = (-np.inf, np.inf)
        boxes.append(tuple(zip(region.x or free, region.y or free, strict=True)))
    if not boxes:
        return None
    return np.max([lower for lower, _ in boxes], axis=0), np.min([upper for _, upper in boxes], axis=0)


def _obstacles(scene, surface):
    try:
        return [Obstacle.of(spec, scene.dimension, scene.base_dir, f"obstacles.{i} ({spec.name})",
                            TERRAIN_REACH * scene.solver.dx, components.motion_of(scene, i), surface)
                for i, spec in enumerate(scene.obstacles)]
    except InputError as error:
        raise InputError(f"{scene.source}: {error}") from None


def _seed(scene, surface, obstacles, taken):
    """Particles of all bodies, none inside an obstacle, including those from another run; the first particle number of
    each body; by name, the share of each body inside the sides of the domain."""
    solver, parts, shares = scene.solver, [], {}
    rim = solver.depth.rim if solver.in_plan else 0.0
    if rim and not any(body.shape.kind == "layer" and not isinstance(body.shape.top, ThicknessRaster)
                       for body in scene.bodies):
        raise InputError.at("solver.depth.rim", rim, "acts on layers of one thickness, and no body is one",
                            scene.source)
    materials = list(scene.materials)
    rng = np.random.default_rng(scene.seed)
    cut = _cut(scene)
    bodies = list(zip(scene.bodies, components.velocity_fields(scene), strict=True))
    for i, (body, field) in enumerate(counted(bodies, "filling bodies with particles", "bodies")):
        material = materials.index(body.material)
        if taken and body.name in taken.bodies:
            parts.append(_as_left(taken.bodies[body.name], material, field))
            continue
        try:
            if (part := components.seeds(scene, i, surface, material)) is not None:
                parts.append(part)
                shares[body.name] = 1.0
                continue
            seeds = seed_body(body.shape, surface, dim=scene.dimension, dx=solver.dx, rng=rng,
                              particles_per_cell=solver.filling, sampling=solver.sampling,
                              base_dir=scene.base_dir, cut=cut, columns=solver.in_plan,
                              rim=rim)
        except InputError as error:
            raise InputError(f"{scene.source}: bodies.{i} ({body.name}): {error}") from None
        if not solver.in_plan:  # columns of snow do not feel obstacles
            seeds = seeds.chosen(~inside_any(obstacles, seeds.positions))
        if len(seeds.volumes) == 0:
            raise InputError(f"{scene.source}: bodies.{i} ({body.name}): lies wholly inside obstacles")
        shares[body.name] = seeds.share
        part = Population(seeds.positions, seeds.volumes, material,
                          np.broadcast_to(body.velocity, seeds.positions.shape), field=field, starts=body.start_time)
        parts.append(components.filled(scene, body, part))
    population = Population.joined(parts)
    if len(population.volumes) == 0:
        raise InputError(f"{scene.source}: bodies: no particles at all; refine solver.dx or enlarge a body")
    return population, np.cumsum([0, *(len(part.volumes) for part in parts[:-1])]), shares


def _as_left(columns, material, field):
    """Particles of a body from the end of another run (`TakenState`)."""
    return Population(columns["position"], columns["volume"][:, 0], material, columns["velocity"], columns["elastic"],
                      columns["stress"], columns["volume_ratio"][:, 0], columns["affine"], columns["state"], field)


def _cut(scene):
    """Corners at which frictionless sides of the domain, "slip" and "symmetric", cut bodies; None without such
    sides."""
    if scene.domain is None or scene.domain.min is None:
        return None
    sides = scene.domain.sides(scene.dimension)
    names = [[sides[f"{axis}_{end}"] for axis in AXES[scene.dimension]] for end in ("min", "max")]
    free = np.isin(names, ("slip", "symmetric"))
    if not free.any():
        return None
    return np.where(free[0], scene.domain.min, -np.inf), np.where(free[1], scene.domain.max, np.inf)


def _domain(scene, surface, seeds):
    """The computed box: as given, else what the scene can reach."""
    if scene.domain and scene.domain.min:
        return np.asarray(scene.domain.min, float), np.asarray(scene.domain.max, float)
    dx, x = scene.solver.dx, seeds.positions
    lower, upper = x.min(axis=0), x.max(axis=0)
    if surface is not None:
        lower, upper = np.minimum(lower, surface.lower), np.maximum(upper, surface.upper)
        upper[-1] += 0.5 * (upper[-1] - lower[-1]) + 20 * dx
        lower[-1] -= 4 * dx
        return lower, upper + 1e-9 * np.abs(upper)
    course = course_of(scene)
    strongest = np.abs(np.asarray(scene.gravity_vector)) if course is None else course.strongest
    fall = strongest * scene.end_time**2 / 2.0
    flight = np.abs(seeds.velocities).max(axis=0) * scene.end_time
    margin = fall + flight + 0.5 * (upper - lower) + 4 * dx
    return lower - margin, upper + margin
