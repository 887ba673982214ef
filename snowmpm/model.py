"""A scene made of numbers: what a solver is built from."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from snowmpm.errors import InputError
from snowmpm.events import make_event
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from snowmpm.saw_test.saw import Saw
from snowmpm.terrain import DistanceField
from snowmpm.velocity_fields import body_friction

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
            from snowmpm.sph.solver import SphSolver  # slow to import, like the other method, of which a run has one

            return SphSolver(self.population, self.laws, scheme=chosen.sph, **common)
        return MpmSolver(self.population, self.laws, kernel=chosen.kernel, gradient=chosen.gradient,
                         transfer=chosen.transfer, flip_ratio=chosen.flip_ratio, body_friction=body_friction(scene),
                         **common)

    def events(self):
        """The scene's events, ready to be applied; last the saw of a saw test."""
        names = [body.name for body in self.scene.bodies]
        events = [make_event(spec, names.index(spec.body), self.scene.solver.dx) for spec in self.scene.events]
        test = self.scene.saw_test
        if test:
            events.append(Saw(names.index("weak_layer"), test.notch, test.cut_length, test.saw_speed, test.saw_start))
        return events
