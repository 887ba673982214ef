"""The sum of forces as a scheme wants it: its kernel, and the sums of what surfaces and loads give in it."""

import math
from typing import Any

from snowmpm.compiler.runtime import DTYPES
from snowmpm.sph.momentum import momentum_kernel
from snowmpm.sph.smoothing import KERNELS
from snowmpm.sph.tallies import Tallies


def power(scheme, dim):
    """n of the artificial stress; "kernel": W(0) / W(dx), as published (Bui & Nguyen 2021, section 3.4)."""
    chosen, kernel = scheme.artificial_stress_power, KERNELS[scheme.kernel]
    if chosen != "kernel":
        return float(chosen)
    radius = kernel.reach * scheme.smoothing
    return float(kernel.weight(0.0, radius, dim) / kernel.weight(1.0, radius, dim))


class Forces:
    """On the particles of one solver."""

    def __init__(self, rows, near, boundary, scheme, *, gravity, dx, precision, width, serial):
        """rows: `Rows`; near: `Neighbourhood`; boundary: `Boundary`; scheme: `snowmpm.scenes.Sph`; gravity: array
        (dim,) [m/s2]; width: lanes of a pack; serial: by one thread."""
        self._rows, self._near, self._boundary = rows, near, boundary
        self._scheme, self._gravity, self._dx = scheme, gravity, dx
        layout = rows.layout
        self._kick = momentum_kernel(
            layout, DTYPES[precision][0], width, scheme.kernel,
            KERNELS[scheme.kernel].reach * scheme.smoothing, scheme.lengths, scheme.momentum,
            power(scheme, layout.dim) if layout.tension else 1.0, scheme.walls, scheme.barrier,
            scheme.confining_pressure > 0.0, scheme.quadratic_viscosity > 0.0, serial)
        self._tallies: Any = None

    def begin(self, blocks, loaded):
        """Room for the sums of new packs. blocks: `BlockMap` of the particles; loaded: whether there are loads."""
        self._tallies = Tallies(blocks, self._near.packs, self._near.lists, len(self._boundary.surfaces), loaded)

    def kick(self, dt, damping_factor, loads, n_loads):
        """Velocities after dt [s], times `damping_factor`; -> totals of what surfaces and loads gave, as `Boundary.add`
        takes them, None where they met no particle. loads: array of which n_loads rows count."""
        near, rows, dummies, tallies, scheme = (
            self._near, self._rows, self._boundary.dummies, self._tallies, self._scheme)
        packs, totals = near.packs, tallies.none()
        covered = scheme.surface_coverage if scheme.surface_coverage < 1.0 else math.inf
        self._kick(packs.table, rows.source, rows.moved, *near.of_particles, near.lists.ints, dummies.frames,
                   dummies.first_row, self._boundary.table, tallies.corners, loads, n_loads, tallies.sums, tallies.of,
                   self._gravity, self._dx, dt, damping_factor, scheme.viscosity, scheme.quadratic_viscosity,
                   scheme.disorder_damping, scheme.confining_pressure, covered, tallies.n, totals, packs.n,
                   packs.chunk_bounds)
        return totals if tallies.n else None
