"""From a scene to a solver: the one place that knows both."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from snowmpm import memory, runtime
from snowmpm.blocks import MOST_FIELDS
from snowmpm.errors import InputError
from snowmpm.events import make_event
from snowmpm.initial_stress import geostatic_stress, overburden
from snowmpm.io import layout
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from snowmpm.saw_test.saw import Saw
from snowmpm.seeding import seed_body
from snowmpm.solids import Obstacle, inside_any
from snowmpm.sph.solver import SphSolver
from snowmpm.terrain import DistanceField, load_terrain

TERRAIN_REACH = 5.0
"""Cells around the ground in which its distance is exact, at least; through the snow that lies on it in any case."""


@dataclass
class Model:
    """A scene made of numbers: what a solver is built from.

    laws: by material index; body_starts: first particle number of each body; direction: unit vector in plan along
    which the front is measured (the mean dip under the snow, +x on the flat); obstacles: `solids.Obstacle`s.
    """

    scene: object
    surface: object
    lower: np.ndarray
    upper: np.ndarray
    population: Population
    body_starts: np.ndarray
    obstacles: list

    @cached_property
    def laws(self):
        dx, test, found = self.scene.solver.dx, self.scene.saw_test, []
        for name, law in self.scene.materials.items():
            if test and test.weak_layer.cells and test.weak_layer.material == name:
                law = law.drawn(test.weak_layer.thickness, test.drawn(dx).weak_layer.thickness)
            try:
                found.append(law.on_grid(dx))
            except ValueError as error:
                raise InputError(f"{self.scene.source}: materials.{name}: {error}") from None
        return found

    @cached_property
    def depth(self):
        """Largest height of a particle straight above the ground [m]; without terrain, of the bodies."""
        x = self.population.positions
        if self.surface is None:
            return float(np.ptp(x[:, -1]))
        return float(np.nanmax(x[:, -1] - self.surface.height(x[:, :-1]), initial=0.0))

    @cached_property
    def distance(self):
        """Distance field of the ground, exact as far as the grid and the snow need it; None without terrain."""
        if self.surface is None:
            return None
        return DistanceField(self.surface, max(TERRAIN_REACH * self.scene.solver.dx, self.depth))

    @cached_property
    def body_of(self):
        return np.searchsorted(self.body_starts, np.arange(len(self.population.volumes)), side="right") - 1

    @cached_property
    def direction(self):
        dim = self.scene.dimension
        flat = np.eye(dim - 1)[0]
        if self.surface is None:
            return flat
        normals = self.surface.normal(self.population.positions[:, :-1])
        dip = np.nansum(normals[:, :-1], axis=0)
        size = np.linalg.norm(dip)
        return dip / size if size > 1e-3 * len(normals) else flat

    def solver(self):
        """The solver of this scene at time zero."""
        scene = self.scene
        names = scene.domain.sides(scene.dimension) if scene.domain else {}
        axes = "xz" if scene.dimension == 2 else "xyz"
        sides = [[names.get(f"{axis}_{end}", "open") for end in ("min", "max")] for axis in axes]
        terrain = scene.terrain
        contact = {"terrain_contact": terrain.contact, "terrain_friction": terrain.friction} if terrain else {}
        chosen = scene.solver
        common = {"dx": chosen.dx, "precision": chosen.precision, "origin": self.lower, "lower": self.lower,
                  "upper": self.upper, "gravity": scene.gravity_vector, "cfl": chosen.cfl, "terrain": self.distance,
                  "sides": sides, "obstacles": self.obstacles, **contact}
        if chosen.method == "sph":
            return SphSolver(self.population, self.laws, scheme=chosen.sph, **common)
        return MpmSolver(self.population, self.laws, kernel=chosen.kernel, gradient=chosen.gradient,
                         transfer=chosen.transfer, flip_ratio=chosen.flip_ratio, body_friction=_body_friction(scene),
                         **common)

    def events(self):
        """The scene's events, ready to be applied; last the saw of a saw test."""
        names = [body.name for body in self.scene.bodies]
        events = [make_event(spec, names.index(spec.body), self.scene.solver.dx) for spec in self.scene.events]
        test = self.scene.saw_test
        if test:
            events.append(Saw(names.index("weak_layer"), test.notch, test.cut_length, test.saw_speed, test.saw_start))
        return events


def build(scene):
    """Validate what only geometry can tell and make the model of a scene. Raises InputError."""
    _refuse_unbuilt(scene)
    runtime.start()
    surface = _surface(scene)
    obstacles = _obstacles(scene)
    seeds, starts = _seed(scene, surface, obstacles)
    lower, upper = _domain(scene, surface, seeds)
    outside = ~((seeds.positions >= lower) & (seeds.positions < upper)).all(axis=1)
    if outside.any():
        i = np.searchsorted(starts, np.flatnonzero(outside)[0], side="right") - 1
        raise InputError(f"{scene.source}: bodies.{i} ({scene.bodies[i].name}): reaches outside the domain"
                         f" {np.round(lower, 3).tolist()} to {np.round(upper, 3).tolist()}")
    model = Model(scene, surface, lower, upper, seeds, starts, obstacles)
    if scene.initial.stress == "isotropic":
        _uniform_pressure(model)
    elif scene.initial.stress != "none":
        _stress_from_weight(model)
    return model


def _refuse_unbuilt(scene):
    """Choices of the schema that this version does not compute."""
    if scene.solver.method == "sph":
        _refuse_beyond_sph(scene)
    if scene.domain and scene.domain.min is None and "periodic" in scene.domain.sides(scene.dimension).values():
        raise InputError.at("domain.boundary", "periodic", "needs domain.min and domain.max", scene.source)


def _refuse_beyond_sph(scene):
    """What only the grid can do."""
    if scene.saw_test:
        raise InputError.at("solver.method", "sph", 'must be "mpm" beside saw_test', scene.source)
    for i, body in enumerate(scene.bodies):
        if body.contact == "separate":
            raise InputError.at(f"bodies.{i}.contact", body.contact, 'needs solver.method = "mpm": in SPH bodies are'
                                ' one continuum, contact = "shared"', scene.source)


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
    boxes = []
    if scene.domain and scene.domain.min:
        boxes.append((scene.domain.min[: scene.dimension - 1], scene.domain.max[: scene.dimension - 1]))
    region = getattr(scene.terrain, "region", None)
    if region is not None:
        free = (-np.inf, np.inf)
        boxes.append(tuple(zip(region.x or free, region.y or free, strict=True)))
    if not boxes:
        return None
    return np.max([lower for lower, _ in boxes], axis=0), np.min([upper for _, upper in boxes], axis=0)


def _obstacles(scene):
    try:
        return [Obstacle.of(spec, scene.dimension, scene.base_dir, f"obstacles.{i} ({spec.name})",
                            TERRAIN_REACH * scene.solver.dx)
                for i, spec in enumerate(scene.obstacles)]
    except InputError as error:
        raise InputError(f"{scene.source}: {error}") from None


def _seed(scene, surface, obstacles):
    """Particles of all bodies, none inside an obstacle, and the first number of each body."""
    solver, parts = scene.solver, []
    materials = list(scene.materials)
    rng = np.random.default_rng(scene.seed)
    for i, body in enumerate(scene.bodies):
        try:
            seeds = seed_body(body.shape, surface, dim=scene.dimension, dx=solver.dx, rng=rng,
                              particles_per_cell=solver.filling, sampling=solver.sampling,
                              base_dir=scene.base_dir)
        except InputError as error:
            raise InputError(f"{scene.source}: bodies.{i} ({body.name}): {error}") from None
        seeds = seeds.chosen(~inside_any(obstacles, seeds.positions))
        if len(seeds.volumes) == 0:
            raise InputError(f"{scene.source}: bodies.{i} ({body.name}): lies wholly inside obstacles")
        parts.append((seeds, materials.index(body.material), np.broadcast_to(body.velocity, seeds.positions.shape)))
    fields = velocity_fields(scene)
    counts = [len(seeds.volumes) for seeds, _, _ in parts]
    if sum(counts) == 0:
        raise InputError(f"{scene.source}: bodies: no particles at all; refine solver.dx or enlarge a body")
    population = Population(
        positions=np.concatenate([seeds.positions for seeds, _, _ in parts]),
        volumes=np.concatenate([seeds.volumes for seeds, _, _ in parts]),
        material=np.concatenate([np.full(n, m) for n, (_, m, _) in zip(counts, parts, strict=True)]),
        velocities=np.concatenate([velocity for _, _, velocity in parts]), field=np.repeat(fields, counts))
    return population, np.concatenate([[0], np.cumsum(counts)[:-1]])


def velocity_fields(scene):
    """Number of the velocity field of each body: 0 for those that share one. Raises InputError for too many."""
    separate = [body.contact == "separate" for body in scene.bodies]
    if sum(separate) >= MOST_FIELDS:
        raise InputError(f'{scene.source}: bodies: at most {MOST_FIELDS - 1} may have contact = "separate"')
    return np.where(separate, np.cumsum(separate), 0)


def _body_friction(scene):
    """Coulomb coefficient between velocity fields (n, n)."""
    friction = np.full(1 + sum(body.contact == "separate" for body in scene.bodies), np.inf)
    for body, field in zip(scene.bodies, velocity_fields(scene), strict=True):
        if field > 0:
            friction[field] = body.friction
    return np.minimum(friction[:, None], friction)


def _domain(scene, surface, seeds):
    """Box that is followed: as given, else what the scene can reach."""
    if scene.domain and scene.domain.min:
        return np.asarray(scene.domain.min, float), np.asarray(scene.domain.max, float)
    dx, x = scene.solver.dx, seeds.positions
    lower, upper = x.min(axis=0), x.max(axis=0)
    if surface is not None:
        lower, upper = np.minimum(lower, surface.lower), np.maximum(upper, surface.upper)
        upper[-1] += 0.5 * (upper[-1] - lower[-1]) + 20 * dx
        lower[-1] -= 4 * dx
        return lower, upper + 1e-9 * np.abs(upper)
    fall = np.abs(np.asarray(scene.gravity_vector)) * scene.end_time**2 / 2.0
    flight = np.abs(seeds.velocities).max(axis=0) * scene.end_time
    margin = fall + flight + 0.5 * (upper - lower) + 4 * dx
    return lower - margin, upper + margin


def _stress_from_weight(model):
    """Geostatic stress, and the elastic strain that carries it, for every particle."""
    scene, population = model.scene, model.population
    shapes = [(body.shape if body.shape.kind == "layer" else None, scene.materials[body.material].density)
              for body in scene.bodies]
    query = model.distance.query if model.distance else None
    spacing = scene.solver.spacing(scene.dimension)
    if scene.saw_test:
        load, normals = _load_in_column(scene, population.positions)
    else:
        load, normals = overburden(shapes, population.positions, model.body_of, query, scene.gravity_vector,
                                   scene.solver.dx, spacing)
    given = scene.initial.lateral_pressure
    k0 = np.array([law.lateral_pressure if given is None else given for law in model.laws])[population.material]
    tau = geostatic_stress(population.positions, load, normals, scene.gravity_vector, k0)
    _give_stress(model, tau)


def _uniform_pressure(model):
    """The same isotropic pressure everywhere."""
    n = len(model.population.volumes)
    _give_stress(model, np.tile(-model.scene.initial.pressure * np.eye(3), (n, 1, 1)))


def _give_stress(model, tau):
    """Kirchhoff stress (n, 3, 3) [Pa] of every particle, and the elastic strain that belongs to it.

    Raises InputError for a material that cannot carry it.
    """
    scene, population = model.scene, model.population
    if scene.dimension == 2:
        # Scene axes (x, z) are tensor axes 0, 1; the out-of-plane stress is tensor axis 2.
        components = [(0, 0), (1, 1), (2, 2), (0, 1)]
    else:
        components = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]
    for m, law in enumerate(model.laws):
        own = population.material == m
        elastic = law.h_from_stress(tau[own])
        if not np.isfinite(elastic).all():
            name, load = list(scene.materials)[m], np.abs(tau[own]).max()
            raise InputError(f"{scene.source}: materials.{name}: too soft for initial.stress ="
                             f' "{scene.initial.stress}": it cannot carry {load:.3g} Pa')
        for c, (i, j) in enumerate(components):
            population.stress[own, c], population.elastic[own, c] = tau[own][:, i, j], elastic[:, i, j]


def _load_in_column(scene, positions):
    """Mass per area above each particle of a saw test [kg/m2], and the normal of its slope."""
    load, bottom = np.zeros(len(positions)), 0.0
    for _, layer in scene.saw_test.drawn(scene.solver.dx).layers:
        above = np.clip(bottom + layer.thickness - positions[:, -1], 0.0, layer.thickness)
        load += scene.materials[layer.material].density * above
        bottom += layer.thickness
    return load, np.tile(np.eye(scene.dimension)[-1], (len(positions), 1))


def check_step(scene, solver):
    """Refuse a cfl beyond the critical one of the scheme, and a fixed step that is unstable from the start."""
    chosen = scene.solver
    if chosen.cfl and chosen.cfl > solver.critical_cfl:
        allowed = f"unstable: must be at most {rounded_down(solver.critical_cfl)} for {solver.scheme_name}"
        raise InputError.at("solver.cfl", chosen.cfl, allowed, scene.source)
    fixed, (limit, cause) = chosen.dt, solver.critical_dt()
    if not limit > 0.0:
        raise InputError(f"{scene.source}: no time step is stable ({cause} limit: {limit} s): the numbers of a material"
                         " or a velocity are out of reach")
    if fixed and fixed > limit:
        allowed = (f"unstable: must be at most {rounded_down(limit)} s here ({cause} limit);"
                   " leave it out for an adaptive step")
        raise InputError.at("solver.dt", fixed, allowed, scene.source)


def rounded_down(limit):
    """A limit in three digits that keeps to itself."""
    scale = 10.0 ** (np.floor(np.log10(limit)) - 2)
    return f"{np.floor(limit / scale * (1.0 + 1e-12)) * scale:.3g}"


def _run_file(scene, particles):
    """Expected size of the run file [bytes]."""
    frames = 1 + max(1, round(scene.end_time / scene.output.interval))
    components = 3 + sum({"velocity": 3, "stress": 6}.get(name, 1) for name in scene.output.fields)
    return layout.expected_size(scene.dimension, frames, particles, components)


def describe(model, solver):
    """What will be modelled: {"dimension", "particles": {body: n}, "blocks", "memory": most of a run, "run_file" and
    "checkpoint": sizes [bytes], "bytes_per_particle", "fields", "dt" [s], "dt_cause", "steps", "domain"}."""
    scene, store = model.scene, solver.particles
    counts = np.diff([*model.body_starts, len(model.population.volumes)])
    dt, cause = solver.stable_dt()
    dt = scene.solver.dt or dt
    steps = int(np.ceil(scene.end_time / dt))
    particles = int(counts.sum())
    return {
        "dimension": scene.dimension,
        "particles": {body.name: int(n) for body, n in zip(scene.bodies, counts, strict=True)},
        "mass": solver.particles.mass,
        "blocks": len(solver.particles.blocks),
        "memory": memory.of_run(scene.dimension, particles, store.bytes_per_particle, store.layout.width,
                                solver.bytes),
        "run_file": _run_file(scene, particles),
        "checkpoint": particles * store.layout.width * store.numpy_dtype().itemsize + 8 * particles,
        "bytes_per_particle": solver.particles.bytes_per_particle,
        "fields": dict(solver.particles.layout.sizes),
        "dt": dt,
        "dt_cause": "fixed" if scene.solver.dt else cause,
        "steps": steps,
        "domain": (model.lower.tolist(), model.upper.tolist()),
    }
