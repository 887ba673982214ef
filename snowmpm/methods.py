"""The methods by which a scene can be computed, as data: what each can do, who builds it, where its options stand.

The scene schema, the composition root, refusals, costs, cautions and advice take their keys from `METHODS`. A test asks
each of them for a row of every name.
"""

import inspect
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import ClassVar

from snowmpm.registry import COMPONENTS, GROUND_LAWS, Registry, resolved
from snowmpm.registry import METHODS as METHODS

CONTRACTS = {name: f"snowmpm.stepping.contract:{contract}" for name, contract in {
    "loads": "TakesLoads", "cuts": "Severs", "removal": "Removes", "settling": "Settles", "around_zone": "Around",
    "within_zone": "Within"}.items()}
"""Capabilities that follow from what the solver of a method derives from: events that push particles, take their bonds
or take them out, initial.stress = "settle", and the two methods of a scene with a zone."""


@dataclass(frozen=True)
class Capabilities:
    """What of a scene a method computes; what it does not is refused by `setup.refusals`.

    dimensions, precisions: values that a scene may choose; filling: particles in a full cell at the start, None where
    the scene chooses; the others say whether a table or a choice of the scene is computed at all.
    """

    dimensions: tuple[int, ...] = (2, 3)
    precisions: tuple[str, ...] = ("f32", "f64")
    filling: int | None = None
    terrain: bool = True
    ground_friction: Collection[str] = ("coulomb",)
    """laws of terrain.friction"""
    ground_cohesion: bool = False
    """tau0 and cohesion of these laws, shear stress of the ground beside the friction"""
    ground_rasters: bool = False
    """rasters as numbers of these laws"""
    thickness_rasters: bool = False
    """layers whose thickness is a raster"""
    delays: bool = False
    """bodies that lie still until their start_time"""
    obstacles: bool = True
    moving_obstacles: bool = True
    contacts: tuple[str, ...] = ("stick", "slip", "separate")
    """values of terrain.contact"""
    sides: tuple[str, ...] = ("open", "slip", "symmetric", "stick", "separate", "periodic")
    """boundaries of the domain"""
    periodic: bool = True
    initial_stress: tuple[str, ...] = ("geostatic", "isotropic", "settle")
    """values of initial.stress beside "none" """
    averaged_hats: bool = False
    """bases of `schemes.BASES` with a box, for comparison"""
    rows_of_jump: int = 1
    """rows of cells or particles that a jump takes at least, of which a law with a crack has its length: two where
    strains are sums over neighbours, which do not see a zigzag of the rows and so cannot open one row alone"""
    saw_test: bool = False
    grid: bool = False
    """a background grid: kernel, gradient, transfer and particles_per_cell of the scene's solver table choose it"""
    plan: bool = False
    """particles are columns in plan, over a ground that the builder gets as it is; they fill a cell in plan, and maps
    are as fine as the grid, since each column counts in all the cells that it covers"""
    usual_filling: int | None = None
    """particles in a full cell of a scene that does not choose"""
    solves: bool = False
    """each step solves for the displacements of all nodes: its cost is that of the equations"""
    presets: bool = False
    """--fast and --accurate were measured for it"""


@dataclass(frozen=True)
class MethodEntry:
    """A row of `METHODS`.

    builder: "module:name" of a callable, or the callable itself, that is given (population, laws, options) and by name
    dx, precision, origin, lower, upper, gravity, cfl, terrain, terrain_contact, terrain_friction, sides and obstacles,
    and returns a `stepping.contract.Method`; options: name of the method's own table within the scene's
    solver table, whose contents the builder gets; None for one that reads the solver table itself.
    terrain_friction is a coefficient for a method whose only `ground_friction` is "coulomb", for one with a `grid`
    a coefficient or a `stepping.basal_friction.BasalFriction`, else a `ground.friction.GroundFriction`.
    """

    REGISTRIES: ClassVar[tuple[Registry, ...]] = (METHODS,)

    name: str
    builder: str | Callable
    capabilities: Capabilities
    options: str | None = None
    relax: str | Callable | None = None
    """"module:name" of a callable, or the callable itself, that brings particles to rest without time: it is given what
    `builder` is, and tolerance, and returns an object with `population`, or None where it cannot"""
    words: str = ""
    """name in captions; the name in capitals when missing"""

    def can(self, capability: str, wanted: object = True) -> bool:
        """Whether it has one of CONTRACTS or of `Capabilities`; of dimensions and the like, whether `wanted` is among
        them."""
        if capability in CONTRACTS:
            made = resolved(self.builder)
            solver = made.__self__ if inspect.ismethod(made) else made
            return isinstance(solver, type) and issubclass(solver, resolved(CONTRACTS[capability]))
        value = vars(self.capabilities)[capability]
        return wanted in value if isinstance(value, Collection) else bool(value)

    @property
    def title(self) -> str:
        """Name in captions."""
        return self.words or self.name.upper()

    @property
    def particles(self) -> str:
        """What its particles are called."""
        return "columns" if self.capabilities.plan else "particles"


for entry in (
    MethodEntry("mpm", "snowmpm.mpm.solver:MpmSolver.of", Capabilities(
        averaged_hats=True, saw_test=True, grid=True, presets=True,
        ground_friction=GROUND_LAWS, ground_cohesion=True, ground_rasters=True),
        relax="snowmpm.implicit.settled:settle"),
    MethodEntry("sph", "snowmpm.sph.solver:SphSolver.of", Capabilities(
        filling=1, rows_of_jump=2), options="sph"),
    MethodEntry("depth", "snowmpm.depth.solver:DepthSolver.of", Capabilities(
        dimensions=(3,), ground_friction=GROUND_LAWS, ground_cohesion=True, ground_rasters=True,
        thickness_rasters=True, delays=True,
        contacts=("slip", "separate"), sides=("open", "slip", "symmetric", "periodic"), moving_obstacles=False,
        initial_stress=("geostatic",), plan=True, usual_filling=4), options="depth", words="depth-averaged"),
    MethodEntry("implicit", "snowmpm.implicit.solver:ImplicitSolver.of", Capabilities(
        precisions=("f64",), moving_obstacles=False, initial_stress=("geostatic", "isotropic"),
        saw_test=True, grid=True, solves=True),
        words="implicit MPM"),
):
    METHODS.add(entry)


def who_can(capability, wanted=True):
    """Names of the methods with a capability, or an adapter for the component of this name; of dimensions and
    precisions, those that have `wanted` among them."""
    return [name for name in METHODS if has(name, capability, wanted)]


def has(name, capability, wanted=True):
    """Whether the method of this name has a capability, or an adapter for the component of this name."""
    if capability in COMPONENTS:
        return COMPONENTS[capability].supports(name)
    return METHODS[name].can(capability, wanted)
