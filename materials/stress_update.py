"""Many stress updates at once: a law applied to arrays of states, outside any solver."""

import functools
from dataclasses import dataclass

import numpy as np
import taichi as ti

from .precision import working_precision
from .symmetric import size


@functools.cache
def _update_kernel(update, dimension, precision, n_parameters, n_state):
    """One kernel per law, dimension and precision; shapes and parameters are run-time values."""
    n = size(dimension)

    @ti.kernel
    def update_all(
        parameters: ti.types.ndarray(),
        h: ti.types.ndarray(),
        state: ti.types.ndarray(),
        increments: ti.types.ndarray(),
        dt: float,
        h_path: ti.types.ndarray(),
        stress: ti.types.ndarray(),
        state_path: ti.types.ndarray(),
        dissipation: ti.types.ndarray(),
        iterations: ti.types.ndarray(),
    ):
        for i in range(increments.shape[0]):
            prm = ti.Vector([parameters[k] for k in ti.static(range(n_parameters))])
            h_i = ti.Vector([h[i, k] for k in ti.static(range(n))])
            state_i = ti.Vector([state[i, k] for k in ti.static(range(n_state))])
            for step in range(increments.shape[1]):
                A = ti.Matrix.zero(float, dimension, dimension)
                for j, k in ti.static(ti.ndrange(dimension, dimension)):
                    A[j, k] = increments[i, step, j, k]
                h_i, tau, state_i, work, count = update(prm, h_i, state_i, A, dt)
                for k in ti.static(range(n)):
                    h_path[i, step, k] = h_i[k]
                    stress[i, step, k] = tau[k]
                for k in ti.static(range(n_state)):
                    state_path[i, step, k] = state_i[k]
                dissipation[i, step] = work
                iterations[i, step] = count

    return update_all


@dataclass(frozen=True)
class Updated:
    """Results of n updates: h (n, 6 or 4), stress τ (n, 6 or 4) [Pa], state (n, n_state), dissipation (n,) [J/m³],
    iterations (n,); with an axis of steps after the first one where a path was followed."""

    h: np.ndarray
    stress: np.ndarray
    state: np.ndarray
    dissipation: np.ndarray
    iterations: np.ndarray


class StressUpdate:
    """`law.update` for arrays. dimension 2 is plane strain; precision "f32" or "f64". Taichi must be running."""

    def __init__(self, law, dimension=3, precision="f64"):
        self.law, self.dimension, self.precision = law, dimension, precision
        self.n_state = max(1, len(law.STATE))  # Taichi has no empty vectors: a law without state gets one idle number
        self._parameters = law.parameters()

    def initial_state(self, n):
        """(n, n_state) initial states."""
        state = np.zeros((n, self.n_state))
        state[:, : len(self.law.STATE)] = self.law.initial_state()
        return state

    def prepare(self, h, state, increments, dt=1.0):
        """The update of `follow` as a function without arguments, to be called (and timed) as often as wanted."""
        with working_precision(self.precision) as (_, dtype):
            inputs = [np.ascontiguousarray(a, dtype) for a in (self._parameters, h, state, increments)]
        n, m = inputs[3].shape[:2]
        entries = size(self.dimension)
        result = Updated(
            *(np.zeros((n, m, k), dtype) for k in (entries, entries, self.n_state)),
            np.zeros((n, m), dtype),
            np.zeros((n, m), np.int32),
        )
        kernel = _update_kernel(
            type(self.law).update, self.dimension, self.precision, len(self._parameters), self.n_state
        )

        def run():
            with working_precision(self.precision):
                kernel(*inputs, dt, result.h, result.stress, result.state, result.dissipation, result.iterations)
            return result

        return run

    def follow(self, h, state, increments, dt=1.0):
        """Apply m successive increments A = f − I, (n, m, d, d), to n points with h (n, 6 or 4), state (n, n_state)."""
        return self.prepare(h, state, increments, dt)()

    def __call__(self, h, state, increments, dt=1.0):
        """Apply one increment, (n, d, d), to each of n points."""
        path = self.follow(h, state, np.asarray(increments)[:, None], dt)
        return Updated(path.h[:, 0], path.stress[:, 0], path.state[:, 0], path.dissipation[:, 0], path.iterations[:, 0])
