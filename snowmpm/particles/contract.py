"""The contract of a method's particles: what fields, audit, maps, probes, events and advice read of them."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from snowmpm.annotations import Floats

if TYPE_CHECKING:
    from snowmpm.particles.material_table import MaterialTable
    from snowmpm.particles.probe import Probe
    from snowmpm.particles.snapshot import Snapshot


class Particles(ABC):
    """Material points in rows, whose order a step may change; each has a number for life.

    A particle carries the columns of `sizes` (`particles.store.Layout` says what they mean).
    """

    count: int
    """how many there are now"""
    mass: float
    """of all [kg]"""
    materials: "MaterialTable"
    """laws, densities, wave speed, elastic energy"""
    removed: dict[str, Any]
    """of those that are gone: count, mass [kg], momentum (dim,) [kg m/s], energy [J]; taken: the mass [kg] of those
    that did not leave the domain but were taken out; carried: the mass [kg] that went with them in a column of its own
    (`store.Layout.mass_column`); entrained, of methods that entrain: mass [kg] that came in, whose energy is
    subtracted; laid, of methods with deposition: mass [kg] that was laid down and is ground now"""
    still_column: str = ""
    """column whose first number is above 0 for snow that is no part of the flow, "" without one"""
    waiting: int = 0
    """of them, the last rows, those that may not move yet"""
    repeats: NDArray[np.bool_]
    """(dim,) whether the domain is periodic along each axis"""
    constants: dict[str, float]
    """numbers of components that fields of particles read, by name"""
    sorts: int
    """how often their order changed"""
    bodies: NDArray[np.intp] | None = None
    """index of the body by number, where numbers are given out while the scene runs; None where those of a body follow
    each other"""
    origins: Floats | None = None
    """where the snow of each number was at time zero (numbers, dim) [m], where numbers are given out; else None"""

    @property
    def moves(self) -> int:
        """How many the last step moved, each as often as it did."""
        return self.count

    @property
    @abstractmethod
    def sizes(self) -> dict[str, int]:
        """Numbers that a particle carries, {column: how many}."""

    @property
    @abstractmethod
    def number_bytes(self) -> int:
        """Bytes of a number."""

    @property
    @abstractmethod
    def bytes_per_particle(self) -> float:
        """Memory of a particle, all arrays and room for a sort included."""

    @property
    @abstractmethod
    def n_blocks(self) -> int:
        """Blocks of cells that hold particles."""

    @abstractmethod
    def snapshot(self) -> "Snapshot":
        """Copy of all particles as they are now (`particles.snapshot.Snapshot`): labels (n, 2) of material index and
        number, `column(name)` (n, size) in float64 and `positions()` (n, dim) [m]."""

    @abstractmethod
    def column(self, name: str) -> Floats:
        """Copy of one column, float64, (n, size)."""

    @abstractmethod
    def positions(self) -> Floats:
        """Scene coordinates [m], (n, dim)."""

    @abstractmethod
    def probe(self, chosen: NDArray[np.integer[Any]], total: int) -> "Probe":
        """`particles.probe.Probe` of the particles with the numbers `chosen` (k,) of `total`."""

    @abstractmethod
    def sums_in_plan(self, lower: Floats, cell: float, shape: tuple[int, int]) -> tuple[tuple[slice, slice], Floats]:
        """Sums over plan cells: -> (window, sums).

        lower (2,) [m]: corner of the first cell; cell: side [m]; shape: cells along x and y. window: slices of those
        that may hold particles; sums (columns along x, rows along y, 6): initial volume, mass, mass times speed, mass
        times speed squared, volume times velocity along x and along y. Of snow that may flow: see `resting_in_plan`.
        """

    def resting_in_plan(self, lower: Floats, cell: float, shape: tuple[int, int]) -> Floats | None:
        """Volume [m3] over each plan cell (columns along x, rows along y) of snow that is no part of the flow: not
        released yet, or laid down; None where there is none."""
        return None
