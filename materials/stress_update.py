"""Many stress updates at once: a law applied to arrays of states, outside any solver."""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowmpm.compiler import ti

from .arrays import Array, Precision, Whole
from .law import REDO, Law
from .packs import LANES, held_numbers, read_lane, update_lane, update_pack, write_lane, write_matrix_lane
from .parameters import named
from .precision import DTYPES, working_precision
from .symmetric import size

STRETCH = 32
"""Consecutive points that one iteration of the parallel loop takes."""


@functools.cache
def _update_kernel(update, vector_update, names, dimension, precision, n_state):
    """One kernel per law, dimension and precision; shapes and parameters are run-time values.

    lanes: straight-line form of `update`, with which points are taken in packs, or None. names: class of the law's
    parameters.
    """
    real = DTYPES[precision][0]
    # Vector entries, not longer shapes: their strides are then known when the kernel is compiled
    tensor = ti.types.vector(size(dimension), real)
    internal = ti.types.vector(n_state, real)
    gradient = ti.types.matrix(dimension, dimension, real)
    columns = (("h", size(dimension)), ("tau", size(dimension)), ("state", n_state), ("A", dimension**2),
               ("held", held_numbers(vector_update, size(dimension))))

    @ti.kernel
    def update_all(
        parameters: ti.types.ndarray(),
        h: ti.types.ndarray(dtype=tensor, ndim=1),
        state: ti.types.ndarray(dtype=internal, ndim=1),
        increments: ti.types.ndarray(dtype=gradient, ndim=2),
        dt: float,
        h_path: ti.types.ndarray(dtype=tensor, ndim=2),
        stress: ti.types.ndarray(dtype=tensor, ndim=2),
        state_path: ti.types.ndarray(dtype=internal, ndim=2),
        dissipation: ti.types.ndarray(dtype=real, ndim=2),
        iterations: ti.types.ndarray(dtype=ti.i32, ndim=2),
    ):
        # A stretch of points an iteration: Taichi calls a function for each, which costs as much as a simple law
        for stretch in range((increments.shape[0] + STRETCH - 1) // STRETCH):
            numbers = ti.Vector([parameters[k] for k in ti.static(range(len(names._fields)))])
            for i in range(stretch * STRETCH, ti.min(increments.shape[0], (stretch + 1) * STRETCH)):
                h_i, state_i = h[i], state[i]
                for step in range(increments.shape[1]):
                    h_i, tau, state_i, work, count = update(
                        named(names, numbers), h_i, state_i, increments[i, step], dt
                    )
                    h_path[i, step] = h_i
                    stress[i, step] = tau
                    state_path[i, step] = state_i
                    dissipation[i, step] = work
                    iterations[i, step] = count

    @ti.kernel
    def update_packs(
        parameters: ti.types.ndarray(),
        h: ti.types.ndarray(dtype=tensor, ndim=1),
        state: ti.types.ndarray(dtype=internal, ndim=1),
        increments: ti.types.ndarray(dtype=gradient, ndim=2),
        dt: float,
        h_path: ti.types.ndarray(dtype=tensor, ndim=2),
        stress: ti.types.ndarray(dtype=tensor, ndim=2),
        state_path: ti.types.ndarray(dtype=internal, ndim=2),
        dissipation: ti.types.ndarray(dtype=real, ndim=2),
        iterations: ti.types.ndarray(dtype=ti.i32, ndim=2),
    ):
        for pack in range((increments.shape[0] + LANES - 1) // LANES):
            numbers = ti.Vector([parameters[k] for k in ti.static(range(len(names._fields)))])
            first = pack * LANES
            count = ti.min(increments.shape[0] - first, LANES)
            blank, count_blank = ti.Vector.zero(real, LANES), ti.Vector.zero(ti.i32, LANES)
            states = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)} | {
                "work": blank, "iterations": count_blank}
            for lane in range(count):
                write_lane(states["h"], lane, h[first + lane])
                write_lane(states["state"], lane, state[first + lane])
            for step in range(increments.shape[1]):
                for lane in range(count):
                    write_matrix_lane(states["A"], lane, increments[first + lane, step])
                update_pack(vector_update, named(names, numbers), dt, states)
                for lane in range(count):
                    if states["iterations"][lane] == REDO:
                        update_lane(update, lane, named(names, numbers), dt, states)
                for lane in range(count):
                    h_path[first + lane, step] = read_lane(states["h"], lane)
                    stress[first + lane, step] = read_lane(states["tau"], lane)
                    state_path[first + lane, step] = read_lane(states["state"], lane)
                    dissipation[first + lane, step] = states["work"][lane]
                    iterations[first + lane, step] = states["iterations"][lane]

    return update_all if vector_update is None else update_packs


@dataclass(frozen=True)
class Updated:
    """Results of n updates: h (n, 6 or 4), stress τ (n, 6 or 4) [Pa], state (n, n_state), dissipation (n,) [J/m³],
    iterations (n,); with an axis of steps after the first one where a path was followed."""

    h: Array
    stress: Array
    state: Array
    dissipation: Array
    iterations: Whole


class StressUpdate:
    """`law.update` for arrays. dimension 2 is plane strain; precision "f32" or "f64". Taichi must be running.

    packed: take points in packs where the law has a `vector_update`, as a solver does; otherwise one by one, to the
    same results but for round-off.
    """

    law: Law
    dimension: int
    precision: Precision
    n_state: int

    def __init__(self, law: Law, dimension: int = 3, precision: Precision = "f64", packed: bool = True) -> None:
        self.law, self.dimension, self.precision = law, dimension, precision
        self._vector_update = law.vector_update if packed else None
        self.n_state = max(1, len(law.STATE))  # Taichi has no empty vectors: a law without state gets one idle number
        self._parameters = law.parameters()

    def initial_state(self, n: int) -> NDArray[np.float64]:
        """(n, n_state) initial states."""
        state = np.zeros((n, self.n_state))
        state[:, : len(self.law.STATE)] = self.law.initial_state()
        return state

    def prepare(self, h: ArrayLike, state: ArrayLike, increments: ArrayLike, dt: float = 1.0) -> Callable[[], Updated]:
        """The update of `integrate` as a function without arguments, to be called (and timed) as often as wanted."""
        with working_precision(self.precision) as (_, dtype):
            inputs = [np.ascontiguousarray(a, dtype) for a in (self._parameters, h, state, increments)]
        n, m = inputs[3].shape[:2]
        tensors = (n, m, size(self.dimension))
        result = Updated(
            h=np.zeros(tensors, dtype),
            stress=np.zeros(tensors, dtype),
            state=np.zeros((n, m, self.n_state), dtype),
            dissipation=np.zeros((n, m), dtype),
            iterations=np.zeros((n, m), np.int32),
        )
        kernel = _update_kernel(
            self.law.update, self._vector_update, type(self._parameters), self.dimension, self.precision, self.n_state
        )

        def run():
            with working_precision(self.precision):
                kernel(*inputs, dt, result.h, result.stress, result.state, result.dissipation, result.iterations)
            return result

        return run

    def integrate(self, h: ArrayLike, state: ArrayLike, increments: ArrayLike, dt: float = 1.0) -> Updated:
        """Apply m successive increments A = f − I, (n, m, d, d), to n points with h (n, 6 or 4), state (n, n_state)."""
        return self.prepare(h, state, increments, dt)()

    def __call__(self, h: ArrayLike, state: ArrayLike, increments: ArrayLike, dt: float = 1.0) -> Updated:
        """Apply one increment, (n, d, d), to each of n points."""
        path = self.integrate(h, state, np.asarray(increments)[:, None], dt)
        return Updated(path.h[:, 0], path.stress[:, 0], path.state[:, 0], path.dissipation[:, 0], path.iterations[:, 0])
