"""Depth-averaged flows made by hand: columns on a lattice, a bed as a function, a friction law."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from snowmpm.components.flow_water.depth import wet_columns
from snowmpm.components.flow_water.one_phase import FlowWater
from snowmpm.depth.snapshot import depth_at_nodes
from snowmpm.depth.solver import DepthSolver
from snowmpm.ground import Coulomb, FrictionLaw
from snowmpm.materials import LAWS
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Depth

G = 9.81
DENSITY = 250.0
OPEN, WALL, PERIODIC = ["open"] * 2, ["slip"] * 2, ["periodic"] * 2


def flat(plan):
    """Ground at z = 0, at plan positions (n, 2)."""
    return np.zeros(len(plan))


def slope(angle):
    """Plane that falls by `angle` [degrees] along x, through z = 0 at x = 0."""
    return lambda plan: -np.tan(np.radians(angle)) * plan[:, 0]


def coulomb(angle):
    """Friction of the ground at `angle` [degrees]."""
    return Coulomb(mu=float(np.tan(np.radians(angle))))


@dataclass(frozen=True)
class Ground:
    """bed: heights [m] at plan positions (n, 2), NaN in a hole; lower, upper: plan corners [m]; sides: boundaries at
    both ends of x and of y."""

    bed: Callable
    lower: tuple[float, float]
    upper: tuple[float, float]
    friction: FrictionLaw = field(default_factory=lambda: coulomb(0.0))
    sides: tuple[list, list] = (OPEN, OPEN)

    def height(self, plan):
        return np.asarray(self.bed(np.asarray(plan, float)), float)


@dataclass(frozen=True)
class Options:
    """What a scene's solver table says; as a scene has it when missing."""

    damping: float = Depth().damping
    mixing: float = Depth().mixing
    centrifugal: bool = True
    cfl: float | None = None
    precision: str = "f64"


USUAL = Options()
UNDAMPED = Options(damping=0.0, mixing=0.0)


def lattice(lower, upper, spacing):
    """Plan positions (n, 2) [m] in the middles of equal rectangles, near `spacing` (a number, or one of each axis)
    wide, that fill a box, and the area of one [m2]."""
    size = np.subtract(upper, lower)
    n = np.maximum(1, np.round(size / spacing)).astype(int)
    axes = [lower[a] + (np.arange(n[a]) + 0.5) * size[a] / n[a] for a in (0, 1)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2), float(np.prod(size / n))


def graded(start, edge, spacing, reach, least=1.0 / 64.0):
    """Middles and widths [m] of intervals from `start` to `edge`: `spacing` wide, falling in proportion to the distance
    from the edge within `reach` of it, down to the share `least`.

    An edge that falls to nothing stretches there without bound, and with it the distances of columns: equal ones part.
    """
    ends = [edge]
    while ends[-1] > start + 1e-9:
        width = spacing * min(1.0, max(least, (edge - ends[-1]) / reach))
        ends.append(max(start, ends[-1] - width))
    ends = np.array(ends[::-1])
    return 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)


def front(x, depth, threshold):
    """Furthest x at which a depth profile falls below a threshold, by interpolation."""
    last = int(np.flatnonzero(depth > threshold).max())
    share = (depth[last] - threshold) / (depth[last] - depth[last + 1])
    return x[last] + share * (x[last + 1] - x[last])


def flow(plan, volumes, ground, dx, *, velocities=None, options=USUAL, densities=(DENSITY,), starts=0.0,
         water=None, adapters=()):
    """`DepthSolver` of columns at plan positions (n, 2) with volumes (n,) and velocities in plan (n, 2); densities
    [kg/m3]: of one column after the other, in turn; starts (n,) [s]; water: `FlowWater`; adapters: of `DepthSolver`."""
    upright = np.zeros((len(plan), 1))
    still = np.zeros_like(plan) if velocities is None else velocities
    population = Population(np.hstack([plan, upright]), np.broadcast_to(volumes, len(plan)).astype(float),
                            np.arange(len(plan)) % len(densities), np.hstack([still, upright]),
                            starts=starts)
    laws = [LAWS["elastic"](density=density, youngs_modulus=1e6, poisson_ratio=0.3) for density in densities]
    return DepthSolver(population, laws, options, dx=dx, precision=options.precision,
                       lower=np.array([*ground.lower, -1e3]), upper=np.array([*ground.upper, 1e3]),
                       gravity=[0.0, 0.0, -G], cfl=options.cfl, terrain=ground, friction=ground.friction,
                       sides=[*ground.sides, OPEN], adapters=[*([wet_columns(water)] if water else []), *adapters])


def pore_water(*, porosity=0.3, grains=2500.0, level=1.0, consolidation=0.0, excess=0.0, layers=16, drained=False):
    """`FlowWater` of one material with grains of a density [kg/m3] and that of its dry skeleton [kg/m3]; drained: plan
    places (n, 2) -> bool (n,), or one for all."""
    dry = (1.0 - porosity) * grains
    water = FlowWater(np.array([porosity * level * 1000.0]), np.array([1.0 - porosity]), np.array([dry]), 1000.0,
                      level, consolidation, excess, layers,
                      drained if callable(drained) else lambda plan: np.full(len(plan), drained), G)
    return water, dry


def run_to(solver, time, dt=None):
    """Step until `time` [s]; dt: of every step but the last, as long as is stable when missing."""
    while solver.time < time - 1e-12:
        solver.step(min(dt or solver.stable_dt()[0], time - solver.time))
    return solver


def depths(solver):
    """Plan positions (nx, ny, 2) and vertical depths (nx, ny) [m] of the nodes."""
    grid, store = solver.grid, solver.particles
    cells, reals = store.cells.to_numpy()[: store.count], store.reals.to_numpy()[: store.count]
    (i, j), part = depth_at_nodes(grid, cells.astype(int), reals.astype(float))
    depth = np.zeros(grid.shape)
    depth[i : i + part.shape[0], j : j + part.shape[1]] = part
    return grid.places(), depth


def profile(solver):
    """x (nx,) and vertical depth (nx,) [m] averaged over y."""
    places, depth = depths(solver)
    return places[:, 0, 0], depth.mean(axis=1)


def energy(solver):
    """Kinetic and potential energy [J] of all columns."""
    store = solver.particles
    mass, velocity = store.masses(), store.column("velocity")
    return float(mass @ (0.5 * (velocity**2).sum(axis=1) + G * store.positions()[:, 2]))


def momentum(solver):
    """Of all columns, in plan [N s]."""
    return solver.particles.masses() @ solver.particles.column("velocity")[:, :2]


def order(errors, ratio=2.0):
    """Observed orders between errors at spacings that fall by `ratio`."""
    return np.log(np.divide(errors[:-1], errors[1:])) / np.log(ratio)
