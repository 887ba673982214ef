"""Ground, release and friction of a depth-averaged scene, for models that need no flow."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm import components
from snowmpm.depth.plan_grid import PlanGrid
from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.setup.build import build


@dataclass(frozen=True)
class Ground:
    """z (nx, ny) [m]: heights at the middles of cells, NaN off the ground; lower (2,) [m]: their corner; cell [m];
    release (k, 2): cells with snow, the highest first; thickness [m]: as given, or the median of it, normal to the
    ground; friction: its law; crs: well-known text, None where there is none; source: of the scene; ignored: what it
    has that these models have not, in words."""

    z: np.ndarray
    lower: np.ndarray
    cell: float
    release: np.ndarray
    thickness: float
    friction: Any
    crs: str | None
    source: str
    ignored: tuple[str, ...]

    @property
    def top(self):
        """Place (2,) [m] of the highest cell of the release."""
        return self.places(self.release[:1])[0]

    def places(self, cells):
        """Middles (k, 2) [m] of cells."""
        return self.lower + self.cell * (np.asarray(cells) + 0.5)

    def height(self, plan):
        """Height (k,) [m] at places, linear between the middles of cells; NaN off the ground."""
        from scipy.interpolate import RegularGridInterpolator  # half a second, which a formula needs not

        axes = [self.lower[a] + self.cell * (np.arange(self.z.shape[a]) + 0.5) for a in (0, 1)]
        return RegularGridInterpolator(axes, self.z, bounds_error=False)(plan)


def ground_of(scene):
    """`Ground` of a depth-averaged scene. InputError for another."""
    if not METHODS[scene.solver.method].capabilities.plan or scene.dimension != 3:
        raise InputError.at("solver.method", scene.solver.method, 'must be "depth": add --set solver.method="depth" and'
                            " --set solver.dx with the cells of the terrain", scene.source)
    model = build(scene)
    grid = PlanGrid(model.lower[:2], model.upper[:2], scene.solver.dx)
    z = model.surface.height(grid.places().reshape(-1, 2)).reshape(grid.shape)
    snow = model.population
    cells = np.unique(np.floor((snow.positions[:, :2] - grid.lower) / grid.dx).astype(int), axis=0)
    cells = cells[np.isfinite(z[tuple(cells.T)])]
    if not len(cells):
        raise InputError(f"{scene.source}: bodies: no snow lies on the ground")
    order = np.argsort(-z[tuple(cells.T)], kind="stable")
    slopes = np.stack([np.nan_to_num(part) for part in np.gradient(z, grid.dx)])
    depth = np.zeros(z.shape)
    np.add.at(depth, tuple(np.floor((snow.positions[:, :2] - grid.lower) / grid.dx).astype(int).T), snow.volumes)
    tops = [top for body in scene.bodies if isinstance(top := body.shape.get("top"), float)]
    over = depth / (grid.dx**2 * np.sqrt(1.0 + (slopes**2).sum(axis=0)))
    thickness = float(np.mean(tops)) if len(tops) == len(scene.bodies) else float(np.median(over[tuple(cells.T)]))
    system = model.surface.system
    return Ground(z, np.asarray(grid.lower, float), float(grid.dx), cells[order], thickness, model.friction.law,
                  system.wkt if system is not None else None, scene.source, ignored_parts(scene))


def ignored_parts(scene):
    """What a scene has that models without a flow have not, in words."""
    parts = {"water": scene.water, "obstacles": scene.obstacles,
             "velocities of bodies": any(np.any(body.get("velocity")) for body in scene.bodies)}
    return (*(one.words for one in components.used(scene)), *(name for name, there in parts.items() if there))
