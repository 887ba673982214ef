"""The model of a scene: arrays and objects from which a solver is built."""

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from snowmpm import components, memory
from snowmpm.errors import InputError
from snowmpm.ground import Coulomb
from snowmpm.ground.friction import GroundFriction
from snowmpm.methods import METHODS
from snowmpm.particles.population import Population
from snowmpm.prescribed.course import Course
from snowmpm.registry import resolved
from snowmpm.results.map_grid import grid_for
from snowmpm.results.maps import cell_for
from snowmpm.scenes.friction import ByVolume
from snowmpm.scenes.friction_cards import friction_card, law_for_volume
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.switch import parts
from snowmpm.setup.basal import friction_under_particles
from snowmpm.stages import stage
from snowmpm.terrain import DistanceField
from snowmpm.terrain.topology import facet_normals

TERRAIN_REACH = 5.0
"""Least distance [cells] from the ground within which the distance field is exact; more if the snow is thicker."""


@dataclass
class Model:
    """The model of a scene, from which a solver is built.

    laws: by material index; body_starts: first particle number of each body; direction: unit vector in plan along
    which the front is measured (the mean dip under the snow, +x on the flat); obstacles: `solids.Obstacle`s.
    shares: of each body by name, the share of its volume that symmetric sides of the domain left. taken:
    `TakenState`, None for a scene that starts from no other run. made: what components made whose parts are the last
    obstacles (`components.contract.Component.obstacles`).
    """

    scene: Any
    surface: Any
    lower: np.ndarray
    upper: np.ndarray
    population: Population
    body_starts: np.ndarray
    obstacles: list
    shares: dict = field(default_factory=dict)
    taken: Any = None
    made: dict = field(default_factory=dict)
    expected: int = 0
    """particles to come, of a method that receives them while the scene runs"""

    @cached_property
    def laws(self):
        dx, test, found = self.scene.solver.dx, self.scene.saw_test, []
        rows = METHODS[self.scene.solver.method].capabilities.rows_of_jump
        for name, law in self.scene.materials.items():
            if (changed := components.law_of(self.scene, name)) is not None:
                found.append(changed)
                continue
            if test and test.weak_layer.cells and test.weak_layer.material == name:
                law = law.thickened_to(test.weak_layer.thickness, test.drawn(dx).weak_layer.thickness)
            try:
                found.append(law.on_grid(dx, rows))
            except ValueError as error:
                raise InputError(f"{self.scene.source}: materials.{name}: {error}") from None
        return found

    @property
    def all_laws(self):
        """`laws`, and then those of the particles that components add."""
        return [*self.laws, *components.more_laws(self)]

    @cached_property
    def map_grid(self):
        """Cells of the maps of a run in three dimensions (`snowmpm.results.map_grid`).

        InputError for an invalid cell size.
        """
        snow, scene = self.population, self.scene
        least = max(self._least_map_cell(part, snow, later=i > 0) for i, part in enumerate(parts(scene)))
        try:
            grid = grid_for(self.lower, self.upper, least, scene.output.map_cell,
                            self.surface.lattice if self.surface else None)
            memory.require(grid.memory, f"output.map_cell: maps of {grid.shape[0]} x {grid.shape[1]} cells of"
                           f" {grid.cell:g} m over the domain", "larger cells or a smaller domain need less")
            return grid
        except InputError as error:
            raise InputError(f"{scene.source}: {error}") from None

    @staticmethod
    def _least_map_cell(part, snow, later):
        """Least side of a map cell [m] for the method of a part of the scene, which may have particles of its own."""
        dx = part.solver.dx
        if part.solver.in_plan:
            return dx
        return cell_for(snow.positions, snow.volumes, dx, part.solver.spacing(3) ** 3 if later else None)

    @cached_property
    def depth(self):
        """Largest height of a particle vertically above the ground [m]; without terrain, height of the bodies."""
        x = self.population.positions
        if self.surface is None:
            return float(np.ptp(x[:, -1]))
        return float(np.nanmax(x[:, -1] - self.surface.height(x[:, :-1]), initial=0.0))

    @cached_property
    def distance(self):
        """Distance field of the ground, exact as far as the grid and the snow need it; None without terrain."""
        if self.surface is None:
            return None
        with stage("distances to the terrain"):
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
        facet, _ = self.surface.locate(self.population.positions[:, :-1])
        normals = facet_normals(self.surface.vertices, self.surface.facets[facet[facet >= 0]])
        dip = normals[:, :-1].sum(axis=0)
        size = np.linalg.norm(dip)
        return dip / size if size > 1e-3 * len(normals) else flat

    @cached_property
    def gravity(self):
        """`Course` of gravity that changes with time; None for constant gravity."""
        return course_of(self.scene)

    @cached_property
    def release_volume(self):
        """Volume of all bodies that flow at time zero, with what symmetric sides of the domain left out (m2 in 2-D)
        [m3]."""
        takes_room = np.array([not law.IN_PORES for law in self.all_laws])
        own = takes_room[self.population.material]
        volumes = np.bincount(self.body_of[own], self.population.volumes[own], len(self.scene.bodies))
        return float(sum(volume / self.shares.get(body.name, 1.0)
                         for volume, body in zip(volumes, self.scene.bodies, strict=True)
                         if not components.lies(self.scene, body)))

    @cached_property
    def friction(self):
        """`GroundFriction` of the terrain: its law, of the class for the volume of the release if the scene leaves the
        choice to it."""
        scene = self.scene
        given = scene.terrain.friction
        if isinstance(given, int | float):
            most = Coulomb.limits()["mu"].most
            if given > most:
                raise InputError.at("terrain.friction", given, f"must be <= {most:g}", scene.source)
            law = Coulomb(mu=given)
        elif isinstance(given, ByVolume):
            law = law_for_volume(friction_card(given.card), self.release_volume)
        else:
            law = given
        return GroundFriction(law, scene.base_dir, self.surface.system, scene.source)

    @property
    def first_gravity(self):
        """Gravity at time zero (dim,) [m/s2]."""
        return np.asarray(self.scene.gravity_vector) if self.gravity is None else self.gravity.at(0.0)

    def at_rest(self):
        """The particles in balance with their weight, by the static solver of the method (`MethodEntry.relax`); None
        where there is none, or no balance is found."""
        chosen = self.scene.solver
        relax = resolved(METHODS[chosen.method].relax)
        if relax is None:
            return None
        return relax(self.population, self.laws, chosen, tolerance=self.scene.initial.tolerance,
                     adapters=partial(components.adapters, self), **self._setting())

    def solver(self, population=None):
        """The solver of this scene at time zero. population: in place of its particles."""
        if self.scene.zone:
            return resolved("snowmpm.handover.nesting:nested")(self, population)
        chosen = self.scene.solver
        entry = METHODS[chosen.method]
        # By name: methods are slow to import, and a run has one of them
        build = resolved(components.builder(self.scene, chosen.method) or entry.builder)
        options = chosen[entry.options] if entry.options else chosen
        seeds = self.population if population is None else population
        adapters = components.adapters(self, chosen.adapted)
        acting = {"adapters": adapters} if adapters else {}
        return build(seeds, self.all_laws, options, **self._setting(), **acting)

    def _setting(self):
        """What a method is built with, by name (`MethodEntry`)."""
        scene = self.scene
        names = scene.domain.sides(scene.dimension) if scene.domain else {}
        axes = "xz" if scene.dimension == 2 else "xyz"
        sides = [[names.get(f"{axis}_{end}", "open") for end in ("min", "max")] for axis in axes]
        chosen = scene.solver
        entry = METHODS[chosen.method]
        contact = {}
        if scene.terrain:
            friction = scene.terrain.friction
            if entry.capabilities.ground_friction != ("coulomb",):
                friction = friction_under_particles(self) if entry.capabilities.grid else self.friction
            elif not isinstance(friction, int | float):
                friction = friction.mu
            contact = {"terrain_contact": scene.terrain.contact, "terrain_friction": friction}
        if self.expected:
            contact["expected"] = self.expected
        return {"dx": chosen.dx, "precision": chosen.precision, "origin": self.lower, "lower": self.lower,
                "upper": self.upper, "gravity": self.first_gravity, "cfl": chosen.cfl,
                "terrain": self.surface if chosen.in_plan else self.distance, "sides": sides,
                "obstacles": self.obstacles, **contact}


def course_of(scene):
    """`Course` of a scene's gravity; None where it is constant. Raises InputError for a wrong file."""
    if not isinstance(scene.gravity, Gravity):
        return None
    try:
        return Course.of(scene.gravity, scene.dimension, scene.base_dir)
    except InputError as error:
        raise InputError(f"{scene.source}: {error}") from None
