"""Components at work in a method: what a solver calls around its step, and knows no more of.

A component has an adapter for each method that supports it (`snowmpm.components`). A solver calls the hooks of its
adapters in their order, and only those that an adapter overrides.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from snowmpm.annotations import Floats


class Adapter:
    """A component in a run of one method. Subclasses override the hooks that they need.

    name: of the component. Hooks are called by a solver that has them, in the order in which they stand here; dt [s]:
    of the step; pushed [s]: the time for which forces act in it. An adapter books the impulses that it gives by
    `Solver.add_impulse`.
    """

    name = ""
    columns: Mapping[str, int] = {}
    """numbers that a particle carries for it, by the name of their column: kept in checkpoints, 0 at the start where
    `components.contract.Component.fills` gives none"""
    mass_column = ""
    """of these columns, the one whose first number is a mass per reference volume [kg/m3] that particles have beside
    that of their material"""
    still_column = ""
    """of these columns, the one whose first number is above 0 for snow that is no part of the flow (yet)"""
    wave_speed = 0.0
    """of waves through it and the snow together, where they are faster than those of the laws [m/s]"""
    moves_ground = False
    """whether the ground of a depth-averaged flow rises or sinks by it"""
    changes_mass = False
    """whether snow came to a flow by finite volumes, or left it, by what it did last"""
    load: Any = None
    """of a depth-averaged flow: what it makes of the columns (`depth.kernel_api.ColumnLoad`)"""
    inlined: Any = None
    """what the kernels of a step contain of it, as its method says (`mpm.kernel_api.Inlined`)"""

    def begin(self, solver: Any) -> None:
        """The solver has its particles and grid, and its clock is at zero.

        A component reads `solver.dim`, `dx`, `precision`, `gravity`, `time`, `particles`, `damping_factor` (below 1
        while an initial state settles). What particles carry: `table = particles.table()`, `columns =
        particles.layout.columns(name)`, `particles.overwrite(table)`; a kernel that writes `particles.reals` itself
        ends with `particles.changes += 1`, so that what was derived from the particles is derived anew.
        """

    def before_step(self, dt: float, pushed: float) -> float:
        """Nothing of a step of dt [s] is done; -> the time for which forces act in it [s], in place of `pushed`."""
        return pushed

    def around(self) -> Any:
        """Of steps that are solved for: pressure around the particles (n,) [Pa], and what books its work, work [J] ->
        None; None without."""

    def field_pairs(self, solver: Any, population: Any) -> Any:
        """What passes between the velocity fields of a `Population` where they meet (`mpm.kernel_api.FieldPairs`); the
        solver has its particles, and no grid yet."""

    def friction(self, law: Any, numbers: Any, grid: Any) -> tuple[Any, Any]:
        """Of a depth-averaged flow: class of the law of ground friction and its numbers, a row or one a node of the
        `depth.plan_grid.PlanGrid`, in place of these."""
        return law, numbers

    def intake(self, solver: Any) -> Any:
        """Of a depth-averaged flow: `depth.kernel_api.Intake`, what it may take up from the ground."""

    def before_scatter(self, pushed: float) -> None:
        """The particles have what acted on them before the step, and nodes are still empty."""

    def after_scatter(self, dt: float, pushed: float) -> None:
        """The nodes have what the particles gave them."""

    def terms(self, matter: Any, time: float) -> Any:
        """Of steps that are solved for: `implicit.kernel_api.Term` of the equations of one that ends at `time` [s]."""

    def strain(self, mesh: Any, matter: Any) -> Any:
        """Of steps that are solved for: `implicit.kernel_api.Strain`, what laws see of the deformation of the nodes."""

    def meet_surfaces(self, dt: float) -> bool:
        """Let bodies and surfaces act on the nodes in place of the solver; -> whether it did."""
        return False

    def before_ground(self, grid: Any) -> None:
        """Ground and sides meet the nodes next; bodies have met each other, obstacles have not."""

    def after_ground(self, grid: Any) -> None:
        """Ground and sides have met the nodes; obstacles are next."""

    def before_obstacle(self, grid: Any, surface: Any) -> None:
        """An obstacle meets the nodes next."""

    def after_obstacle(self, grid: Any, surface: Any) -> None:
        """It has."""

    def after_surfaces(self, write_back: Callable[[], None]) -> None:
        """Bodies and surfaces have met the nodes; write_back: brings those near surfaces to where particles read them,
        which comes next."""

    def before_gather(self, dt: float) -> None:
        """The nodes have their new velocities."""

    def after_gather(self, dt: float) -> None:
        """The particles have moved."""

    def after_step(self, dt: float) -> None:
        """All forces have acted, and nothing of the step is booked yet: the last moment for a force."""

    def end_step(self, dt: float) -> None:
        """All else of the step is done, and the clock has not advanced yet: the moment for what changes with time."""

    def limit_dt(self, dt: float, critical: float, elastic: float) -> float:
        """A step of dt [s], made short enough; critical, elastic: the cfl at which waves grow, and that of dt."""
        return dt

    def restart(self) -> None:
        """Time zero is now: totals start again."""

    def to_come(self, time: float) -> bool:
        """Whether it will change by itself after `time` [s], so that snow at rest may move again."""
        return False

    def work(self) -> Mapping[str, float]:
        """What a step has to do for it, by the names of the rows of its cost (`measured/costs.csv`)."""
        return {}

    @property
    def bytes(self) -> int:
        """Of its arrays."""
        return 0

    def force_work(self) -> float:
        """Energy that it gave the snow since time zero [J]."""
        return 0.0

    def given(self, lift: float) -> Mapping[str, float]:
        """Energies that it gave the snow since time zero [J], beside that of `force_work`: columns of the history, by
        name. lift [J/kg]: potential energy that the history counts of mass that is gone."""
        return {}

    def damping_work(self) -> float:
        """Energy that it took by damping since time zero [J]."""
        return 0.0

    def potential_energy(self) -> float | None:
        """What stands in for -m g.x of the snow where gravity changes [J]; None: nothing does."""
        return None

    def entrained(self) -> float:
        """Mass that lay still and has become part of the flow since time zero [kg] (`still_column`)."""
        return 0.0

    def apart(self) -> tuple[float, float]:
        """Mass of snow of the scene that is no particle, and that of which left the model [kg]."""
        return 0.0, 0.0

    def impulses(self) -> list[Floats]:
        """Impulses (dim,) [N s] that it gave, each for itself, since they may cancel."""
        return []

    def row(self) -> Mapping[str, float]:
        """Its columns of the history, by name."""
        return {}

    def units(self) -> Mapping[str, str]:
        """Their units."""
        return {}

    def take_series(self) -> Mapping[str, Mapping[str, tuple[Mapping[str, Any], Mapping[str, tuple[Any, str]]]]]:
        """What it recorded since the last call, finer than the frames: by kind and name, what the record is about
        (anything JSON can hold, always the same) and {column: (values (k, ...), unit)}, with a column "time". The run
        file keeps them (`snowmpm.io.series`)."""
        return {}

    def maps(self, grid: Any) -> Mapping[str, tuple[Floats, str]]:
        """Rasters of its own at the end of a run in three dimensions: name -> values (columns along x, rows along y),
        NaN where there is nothing, over the cells of a `results.map_grid.MapGrid`, and unit."""
        return {}

    def choices(self) -> Mapping[str, str]:
        """What stands beside the maps of a run, label -> text, where results hang on what it was told."""
        return {}

    def numbers(self, grid: Any) -> Mapping[str, float]:
        """Numbers of its own beside those of hazard mapping, at the end of a run that has maps."""
        return {}

    def state(self) -> dict[str, Any]:
        """All that a bitwise continuation needs, by name."""
        return {}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take over what `state()` gave."""


HOOKS = ("before_step", "after_step", "around", "field_pairs", "friction", "intake", "before_scatter", "after_scatter",
         "terms", "strain", "meet_surfaces", "before_ground", "after_ground", "before_obstacle", "after_obstacle",
         "after_surfaces", "before_gather", "after_gather", "end_step", "limit_dt")


class Adapters:
    """Adapters of a solver, in the order in which they act; for each hook, by its name, the list of those that have
    it."""

    before_step: list[Callable[..., float]]
    after_step: list[Callable[..., None]]
    around: list[Callable[..., Any]]
    field_pairs: list[Callable[..., Any]]
    friction: list[Callable[..., tuple[Any, Any]]]
    intake: list[Callable[..., Any]]
    before_scatter: list[Callable[..., None]]
    after_scatter: list[Callable[..., None]]
    terms: list[Callable[..., Any]]
    strain: list[Callable[..., Any]]
    meet_surfaces: list[Callable[..., bool]]
    before_ground: list[Callable[..., None]]
    after_ground: list[Callable[..., None]]
    before_obstacle: list[Callable[..., None]]
    after_obstacle: list[Callable[..., None]]
    after_surfaces: list[Callable[..., None]]
    before_gather: list[Callable[..., None]]
    after_gather: list[Callable[..., None]]
    end_step: list[Callable[..., None]]
    limit_dt: list[Callable[..., float]]

    def __init__(self, adapters: Iterable[Adapter] = ()) -> None:
        self._all = tuple(adapters)
        self._find_hooks()

    def add(self, adapter: Adapter, solver: Any) -> None:
        """Let one more act in a solver that runs, after the others."""
        self._all = (*self._all, adapter)
        self._find_hooks()
        adapter.begin(solver)

    def _find_hooks(self) -> None:
        for hook in HOOKS:
            setattr(self, hook, [getattr(one, hook) for one in self._all
                                 if getattr(type(one), hook) is not getattr(Adapter, hook)])

    def begin(self, solver: Any) -> None:
        """The solver has all else that it needs."""
        for one in self._all:
            one.begin(solver)

    def shortened(self, dt: float, critical: float, elastic: float) -> dict[str, float]:
        """A step with each that limits it over one of dt [s] without, by name."""
        return {one.name: one.limit_dt(dt, critical, elastic) / dt for one in self._all
                if type(one).limit_dt is not Adapter.limit_dt}

    @property
    def of_particles(self) -> dict[str, Any]:
        """columns (name, numbers) of all, mass_column and still_column, as
        `particles.sorted_particles.SortedParticles` takes them."""
        return {"columns": tuple(column for one in self._all for column in one.columns.items()),
                "mass_column": next((one.mass_column for one in self._all if one.mass_column), ""),
                "still_column": next((one.still_column for one in self._all if one.still_column), "")}

    @property
    def wave_speed(self) -> float:
        """The fastest of all [m/s]."""
        return max((one.wave_speed for one in self._all), default=0.0)

    @property
    def inlined(self) -> tuple[Any, ...]:
        """What the kernels of a step contain of each that has something."""
        return tuple(one.inlined for one in self._all if one.inlined is not None)

    @property
    def move_ground(self) -> bool:
        """Whether one of them does."""
        return any(one.moves_ground for one in self._all)

    @property
    def changed_mass(self) -> bool:
        """Whether one of them did, or moves ground, which goes with it."""
        return any(one.changes_mass or one.moves_ground for one in self._all)

    def work(self) -> dict[str, Mapping[str, float]]:
        """What a step has to do for each, by name."""
        return {one.name: one.work() for one in self._all}

    @property
    def bytes(self) -> int:
        """Of the arrays of all."""
        return sum(one.bytes for one in self._all)

    def take_series(self) -> dict[str, Mapping[str, Any]]:
        """What all recorded since the last call, by kind."""
        return {kind: records for one in self._all for kind, records in one.take_series().items()}

    def __iter__(self) -> Iterator[Adapter]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __getitem__(self, name: str) -> Adapter:
        return {one.name: one for one in self._all}[name]

    def state(self) -> dict[str, Any]:
        """State of each, by name."""
        return {one.name: one.state() for one in self._all}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take over what `state()` gave."""
        for one in self._all:
            one.restore(state[one.name])


NONE = Adapters()
