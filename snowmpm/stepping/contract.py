"""The contract of a method: all that the program asks of a way to compute a scene.

Run loop, events, audit, maps, probes, settling, recorder, description and advice use the members of `Method` and of
`particles.contract.Particles`, and nothing else of a method (tests/test_method_contract.py). What a method can do at
all is a row of `snowmpm.methods.METHODS`.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowmpm.annotations import Floats
from snowmpm.stepping.component import NONE, Adapters

if TYPE_CHECKING:
    from snowmpm.particles.contract import Particles
    from snowmpm.particles.coordinates import Frame
    from snowmpm.stepping.time_step import Extremes


@dataclass(frozen=True)
class Totals:
    """What has been added up since time zero, for the audit.

    impulse: of terrain, sides, obstacles and loads, (dim,) [N s]; weight_impulse: of gravity (dim,) [N s];
    momentum_gain: time integral of all momentum that came in (dim,) [N s2], needed where the domain is periodic;
    plastic_work and contact_work: energy taken by the laws and by contact [J]; handover_energy [J]: lost where snow
    went from one method to another, of two that work at the same time; yielding: number of particles that yielded in
    the last step;
    contact_lines: lines of nodes that touched a surface in steps that are solved for, added up over the steps, and
    contact_spared of them, which a rule settled; None where states of contact are not sought.
    """

    impulse: Floats
    weight_impulse: Floats
    momentum_gain: Floats
    plastic_work: float = 0.0
    contact_work: float = 0.0
    yielding: int = 0
    handover_energy: float = 0.0
    contact_lines: int | None = None
    contact_spared: int = 0


@dataclass(frozen=True)
class StepLimits:
    """cfl: share of a cell that a wave or a particle may cross in a step; critical_cfl: the largest that is stable;
    scheme: name of the scheme in messages; usual_cfl: of a scene that gives none, where it is not cfl."""

    cfl: float
    critical_cfl: float
    scheme: str
    usual_cfl: float | None = None


@dataclass(frozen=True)
class Workload:
    """What a step has to do beside its particles, for the forecast of its cost.

    blocks: owner blocks of particles; node_blocks: blocks of grid nodes; contact_blocks: those near a surface;
    surfaces: terrain, sides and obstacles; moving: obstacles that move; serial: whether one thread does it all;
    components: what a step has to do for each (`component.Adapter.work`), by its name; shortened: the step with each
    that limits it over that without.
    """

    blocks: int
    node_blocks: int = 0
    contact_blocks: int = 0
    surfaces: int = 0
    moving: int = 0
    serial: bool = False
    components: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    shortened: Mapping[str, float] = field(default_factory=dict)


class Method(ABC):
    """Particles with a clock, and a step of both. SI units, scene coordinates; per metre of width in 2-D."""

    frame: "Frame"
    """dim, dx [m], origin (dim,) [m], precision"""
    particles: "Particles"
    time: float
    """[s]; the run loop sets it to the time of a frame that a step has reached but for round-off"""
    steps: int
    """taken since time zero"""
    gravity: Floats
    """of the next step (dim,) [m/s2]"""
    extremes: "Extremes"
    """of the last step"""
    unconverged: int
    """return maps that failed since time zero"""
    adapters: Adapters = NONE
    """of the components at work"""

    # ---- the step ---------------------------------------------------------------------------------------------

    @abstractmethod
    def step(self, dt: float) -> None:
        """Advance by dt [s]. Raises SimulationError, with what `stable_dt` then says unchanged, when it fails."""

    @abstractmethod
    def stable_dt(self) -> tuple[float, str]:
        """-> (step for now [s], what limits it)."""

    @abstractmethod
    def critical_dt(self) -> tuple[float, str]:
        """-> (longest step that is not unstable now [s], what limits it)."""

    @property
    @abstractmethod
    def limits(self) -> StepLimits:
        """`StepLimits`."""

    @abstractmethod
    def restart_clock(self) -> None:
        """Time zero is now: totals start again."""

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    @abstractmethod
    def totals(self) -> Totals:
        """`Totals` as they are now."""

    @property
    @abstractmethod
    def memory(self) -> int:
        """Bytes of everything but the particles."""

    # ---- checkpoint -------------------------------------------------------------------------------------------

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """All that a bitwise continuation needs, by name: numbers, arrays, lists and dictionaries of them."""

    @abstractmethod
    def restore(self, state: Mapping[str, Any]) -> None:
        """Take over the `state()` of a method of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """


# ---- what some methods do more: a method derives from what it can (`snowmpm.methods.CONTRACTS`) ----------------------

class TakesLoads(ABC):
    """Events push its particles."""

    @abstractmethod
    def set_loads(self, loads: Sequence[tuple[ArrayLike, float, ArrayLike]]) -> None:
        """loads: [(centre (dim,) [m], radius [m], acceleration (dim,) [m/s2])] that act within their radius from now
        on, in place of those before."""

    @abstractmethod
    def push(self, numbers: tuple[int, int], gain: Floats, mass: float) -> None:
        """Add `gain` (dim,) [m/s] to the velocity of the particles numbers[0] <= number < numbers[1], whose mass is
        `mass` [kg]; counts as a load."""


class Severs(ABC):
    """Events cut the bonds of its particles."""

    @abstractmethod
    def sever(self, line: Floats, radius: float, numbers: tuple[int, int], state: Sequence[float]) -> int:
        """Cut the bonds of the particles numbers[0] <= number < numbers[1] within `radius` [m] of a line in plan
        (k, dim - 1) [m]: no stress, and the law's severed `state`; -> how many."""


class Removes(ABC):
    """Its particles can be taken out."""

    @abstractmethod
    def remove(self, gone: NDArray[np.bool_]) -> None:
        """Take particles out, `gone` (n,) true in the order of their rows; they count as removed."""


class Settles(ABC):
    """Damped steps bring it to rest."""

    @abstractmethod
    def damp(self, kept: float) -> float:
        """Keep the share `kept` of all velocities in each step from now on, while an initial state settles: 1 ends it.
        -> the share of the impulses of terrain and sides that `totals` counts meanwhile: `kept` where damping takes its
        part of them, else 1."""


class Receives(Removes):
    """Snow comes in while it runs."""

    @abstractmethod
    def receive(self, population: Any, numbers: NDArray[np.integer[Any]]) -> None:
        """Take in a `particles.population.Population`, with numbers (n,) that no particle has yet."""


class Around(Receives):
    """It can be the method around a zone."""

    @abstractmethod
    def invite(self, population: Any) -> None:
        """Let the snow of another method, a `particles.population.Population`, press on that of this one in the next
        step, in which it moves on at its velocity: it is no part of what this method holds."""

    @abstractmethod
    def pull(self, plan: Floats) -> Floats:
        """Acceleration (k, dim) [m/s2] that the pressure of this method's snow gives other snow at places in plan
        (k, dim - 1) [m]."""


class Within(Receives):
    """It can be the method within a zone."""

    @abstractmethod
    def accelerate(self, gain: Floats) -> None:
        """Add `gain` (n, dim) [m/s] to the velocities, in the order of the rows; counts as a load."""


class PushesObstacles(ABC):
    """It knows what its snow gives obstacles."""

    @property
    @abstractmethod
    def obstacle_totals(self) -> Floats:
        """Impulse [N s], its moment about the centre of rotation [N s m] (1 number in 2-D, 3 in 3-D) and work [J] that
        the snow gave each obstacle, (n, dim + 1 or 3 + 1)."""


class Affine(ABC):
    """Its particles carry an affine motion, part of which its grid may not see."""

    @abstractmethod
    def second_moment(self) -> float:
        """D [m2] of the kinetic energy m D C:C / 2 of the affine motion of a particle; 0 where it carries none."""

    @abstractmethod
    def null_space_noise(self, energy: float) -> float:
        """Share of the kinetic energy [J] of the particles that the method cannot see."""


class Forecasts(ABC):
    """It knows more of its run than its next step."""

    @abstractmethod
    def expected_dt(self, breaking: bool = False) -> tuple[float, str]:
        """-> (step that a run takes about [s], what limits it); breaking: while bonds of a weak layer break."""

    def course(self, end_time: float, interval: float) -> Any:
        """How a run from now to end_time [s], with a frame every interval [s], will go (`depth.blocks.Course`); None
        where no more is known than its first steps."""
        return None

    @property
    @abstractmethod
    def workload(self) -> Workload:
        """`Workload` of a step."""
