"""Accelerations and pressures as functions of place and time.

A pressure p gives each particle of volume V the force -V grad p. That is all for water in the pores of the snow. Around
the snow, a pressure acts on the free surface S by the traction -p n, and for any smooth continuation of p into the snow

    - int_S p n . w dS = - int (p div w + grad p . w) dV

for every virtual motion w: beside the forces, the stress that pushes particles apart is sigma + p I. A uniform p is
then a confining stress, one that grows with depth is buoyancy; walls feel what exceeds p.
"""

import math

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.prescribed.field import Field
from snowmpm.reading.named_files import existing
from snowmpm.seeding.polygons import Polygons
from snowmpm.seeding.regions import read_regions

REACH = 0.01
"""Half the distance [dx] over which a pressure is differenced for its gradient."""


class Acceleration(Field):
    """A force in proportion to mass."""

    def __init__(self, spec, dim, base_dir, key, formula_of, numbers=None, system=None):
        super().__init__(spec, dim, base_dir, key, formula_of, numbers)
        self._regions = None if spec.region is None else _plan(spec.region, dim, base_dir, f"{key}.region", system)

    @staticmethod
    def columns(dim):
        return ("ax", "az") if dim == 2 else ("ax", "ay", "az")

    def acceleration(self, x, v, time):
        """(n, dim) [m/s2]; 0 beyond its place."""
        inside = self._inside(x)
        if inside is None:
            return self.values(x, v, time)
        result = np.zeros(x.shape)
        if inside.any():
            result[inside] = self.values(x[inside], v[inside], time)
        return result

    def refuse_infinite(self, points, end_time):
        """Raise InputError for a formula that gives no finite number where it acts."""
        inside = self._inside(points)
        super().refuse_infinite(points if inside is None else points[inside], end_time)

    def _inside(self, x):
        block = self.spec.within
        if block is None and self._regions is None:
            return None
        inside = np.ones(len(x), bool)
        if block is not None:
            inside &= ((x >= np.asarray(block.min)) & (x < np.asarray(block.max))).all(axis=1)
        if self._regions is not None:
            inside[inside] = np.any([region(x[inside, :-1]) for region in self._regions], axis=0)
        return inside


class Pressure(Field):
    """The pressure of a fluid."""

    def __init__(self, spec, dim, base_dir, key, formula_of, numbers=None, system=None):
        super().__init__(spec, dim, base_dir, key, formula_of, numbers)
        self.on_surface = spec.acts_on == "surface"

    @staticmethod
    def columns(dim):
        return ("pressure",)

    def pressure(self, x, time):
        """(n,) [Pa]."""
        return self.values(x, np.zeros(x.shape), time)[:, 0]

    def gradient(self, x, time, dx):
        """(n, dim) [Pa/m]."""
        result, reach = np.empty(x.shape), REACH * dx
        for a, axis in enumerate(np.eye(self.dim)):
            result[:, a] = self.pressure(x + reach * axis, time) - self.pressure(x - reach * axis, time)
        return result / (2.0 * reach)


class AccelerationBy:
    """An acceleration that a function gives: function(x (n, dim) [m], v (n, dim) [m/s], time [s]) -> (n, dim) or (dim,)
    [m/s2]."""

    numbers, until = None, math.inf

    def __init__(self, function):
        self._function = function

    def share(self, time, dt):
        """It always acts."""
        return 1.0

    def acceleration(self, x, v, time):
        """(n, dim) [m/s2]. Raises SimulationError for what is no number."""
        values = np.array(np.broadcast_to(np.asarray(self._function(x, v, time), float), x.shape))
        if not np.isfinite(values).all():
            raise SimulationError(f"the function of an acceleration gives no finite number at t = {time:.6g} s")
        return values


def _plan(spec, dim, base_dir, key, system):
    """Functions plan points (n, dim - 1) -> (n,) bool, of a scene's region."""
    if spec.get("file") is not None:
        path = existing(spec.file, base_dir, f"{key}.file")
        return [region.polygons.contains for region in read_regions(path, f"{key}.file", system)]
    if spec.get("polygon") is not None:
        return [Polygons.of([[spec.polygon]], f"{key}.polygon").contains]
    free = (-np.inf, np.inf)
    lower, upper = np.array([spec[axis] or free for axis in "xy"[: dim - 1]]).T
    return [lambda points: ((points >= lower) & (points < upper)).all(axis=1)]
