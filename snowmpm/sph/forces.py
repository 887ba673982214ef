"""The sum of forces as a scheme wants it: its kernel, and the sums of what surfaces and loads give in it."""

import math
from typing import Any

from snowmpm.sph.momentum import Factors, Step, Terms
from snowmpm.sph.smoothing import KERNELS
from snowmpm.sph.tallies import Tallies


def power(scheme, dim):
    """n of the artificial stress; "kernel": W(0) / W(dx), as published (Bui & Nguyen 2021, section 3.4)."""
    chosen, kernel = scheme.artificial_stress_power, KERNELS[scheme.kernel]
    if chosen != "kernel":
        return float(chosen)
    radius = kernel.reach * scheme.smoothing
    return float(kernel.weight(0.0, radius, dim) / kernel.weight(1.0, radius, dim))


def terms_of(scheme, layout):
    """`momentum.Terms` of a scheme for a `RowLayout`."""
    return Terms(scheme.momentum, power(scheme, layout.dim) if layout.tension else 1.0, scheme.walls, scheme.barrier,
                 scheme.confining_pressure > 0.0, scheme.quadratic_viscosity > 0.0)


class Forces:
    """On the particles of one solver."""

    def __init__(self, rows, near, boundary, scheme, kernel, *, gravity, dx):
        """rows: `Rows`; near: `Neighbourhood`; boundary: `Boundary`; scheme: `snowmpm.scenes.Sph`; kernel: of the
        momentum sum; gravity: array (dim,) [m/s2]."""
        self._rows, self._near, self._boundary = rows, near, boundary
        self._gravity, self._dx, self._kick = gravity, dx, kernel
        self._factors = Factors(
            scheme.viscosity, scheme.quadratic_viscosity, scheme.disorder_damping, scheme.confining_pressure,
            scheme.surface_coverage if scheme.surface_coverage < 1.0 else math.inf)
        self._tallies: Any = None

    def begin(self, blocks, loaded):
        """Room for the sums of new packs. blocks: `BlockMap` of the particles; loaded: whether there are loads."""
        self._tallies = Tallies(blocks, self._near.packs, self._near.lists, len(self._boundary.surfaces), loaded)

    def kick(self, dt, damping_factor, loads, n_loads):
        """Velocities after dt [s], times `damping_factor`; -> totals of what surfaces and loads gave, as `Boundary.add`
        takes them, None where they met no particle. loads: array of which n_loads rows count."""
        near, tallies, packs = self._near, self._tallies.begin(), self._near.packs
        self._kick(near.of_particles, self._rows.tables, self._boundary.walls, tallies,
                   Step(self._gravity, loads, n_loads, self._dx, dt, damping_factor), self._factors, packs.n,
                   packs.chunk_bounds)
        return tallies.total if tallies.n else None
