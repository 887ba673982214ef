"""Slow flow of a fluid through pores by the lattice Boltzmann method with two relaxation times.

    f_i(x + e_i, t + 1) = f_i - w+ (f_i+ - e_i+) - w- (f_i- - e_i-) + (1 - w- / 2) 3 w_i e_i . F
    e_i+ = w_i rho,   e_i- = 3 w_i e_i . u,   rho = sum_i f_i,   u = sum_i e_i f_i + F / 2

in lattice units, with density deviations for rho, so that float32 is enough; + and - are halves of the sum and of the
difference with the opposite velocity. The equilibrium is linear: this is Stokes' equation whatever the speed, with the
viscosity nu = (1 / w+ - 1/2) / 3. With (1 / w+ - 1/2) (1 / w- - 1/2) = 3/16 a wall lies half-way between nodes, at any
viscosity (Ginzburg et al. 2008, doi:10.4208/cicp.2008.3.427); with one relaxation time (w- = w+) it moves with it.
"""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.micro.lattice import PAIRS, VELOCITIES, WEIGHTS

MAGIC = 3.0 / 16.0


@functools.cache
def step_kernel(real, places, odd):
    """Kernel of one step. numbers (19 n,), table (18 n,) (`pore_lattice`), rates w+ and w-, force F (3,) [1]."""
    weights = WEIGHTS.tolist()
    velocities = VELOCITIES.tolist()

    @taichi_kernel
    def step(numbers: ti.types.ndarray(dtype=real, ndim=1), table: ti.types.ndarray(dtype=places, ndim=1),
             even_rate: real, odd_rate: real, fx: real, fy: real, fz: real, n: int):
        for p in range(n):
            f = ti.Vector.zero(real, 19)
            f[0] = numbers[p]
            rho = f[0]
            u = ti.Vector([0.5 * fx, 0.5 * fy, 0.5 * fz])
            for k in ti.static(range(PAIRS)):
                a, b = ti.static(2 * k + 1, 2 * k + 2)
                if ti.static(odd):
                    f[a], f[b] = numbers[table[(b - 1) * n + p]], numbers[table[(a - 1) * n + p]]
                else:
                    f[a], f[b] = numbers[a * n + p], numbers[b * n + p]
                rho += f[a] + f[b]
                for d in ti.static(range(3)):
                    if ti.static(velocities[a][d] > 0):
                        u[d] += f[a] - f[b]
                    elif ti.static(velocities[a][d] < 0):
                        u[d] -= f[a] - f[b]
            numbers[p] = f[0] - even_rate * (f[0] - ti.static(weights[0]) * rho)
            for k in ti.static(range(PAIRS)):
                a, b = ti.static(2 * k + 1, 2 * k + 2)
                along, push = ti.cast(0.0, real), ti.cast(0.0, real)
                for d in ti.static(range(3)):
                    if ti.static(velocities[a][d] != 0):
                        along += ti.static(float(velocities[a][d])) * u[d]
                        push += ti.static(float(velocities[a][d])) * ti.Vector([fx, fy, fz])[d]
                w3 = ti.static(3.0 * weights[a])
                even = even_rate * (0.5 * (f[a] + f[b]) - ti.static(weights[a]) * rho)
                uneven = odd_rate * (0.5 * (f[a] - f[b]) - w3 * along) - (1.0 - 0.5 * odd_rate) * w3 * push
                if ti.static(odd):
                    numbers[table[(a - 1) * n + p]] = f[a] - even - uneven
                    numbers[table[(b - 1) * n + p]] = f[b] - even + uneven
                else:  # to where the opposite one was: the odd step takes it from there
                    numbers[b * n + p] = f[a] - even - uneven
                    numbers[a * n + p] = f[b] - even + uneven

    return step


class StokesFlow:
    """Flow through a `PoreLattice`, driven by a force per volume F (3,) in lattice units.

    tau: relaxation time of the even part; magic: product of both times less one half (`MAGIC`), None for one relaxation
    time. precision: "f32" or "f64".
    """

    def __init__(self, lattice, force, tau=1.0, magic=MAGIC, precision="f32"):
        runtime.start()
        self.lattice, self.force, self.steps = lattice, np.asarray(force, float), 0
        self.viscosity = (tau - 0.5) / 3.0
        self._rates = 1.0 / tau, 1.0 / (tau if magic is None else 0.5 + magic / (tau - 0.5))
        self._precision, self._real = precision, runtime.DTYPES[precision][0]
        self._places = ti.i32 if lattice.table.dtype == np.int32 else ti.i64
        self._numbers = ti.ndarray(self._real, 19 * lattice.count)
        self._numbers.fill(0.0)
        self._table = ti.ndarray(self._places, 18 * lattice.count)
        self._table.from_numpy(lattice.table.ravel())

    def advance(self, pairs):
        """So many times two steps."""
        with runtime.precision(self._precision):
            for _ in range(pairs):
                for odd in (False, True):
                    step_kernel(self._real, self._places, odd)(self._numbers, self._table, *self._rates,
                                                               *self.force.tolist(), self.lattice.count)
        self.steps += 2 * pairs

    def velocity(self):
        """u (n, 3) at the nodes, after an even number of steps."""
        numbers = self._numbers.to_numpy().reshape(19, -1)
        u = np.empty((self.lattice.count, 3))
        for d in range(3):
            plus, minus = VELOCITIES[:, d] > 0, VELOCITIES[:, d] < 0
            u[:, d] = numbers[plus].sum(axis=0, dtype=float) - numbers[minus].sum(axis=0, dtype=float)
        return u + 0.5 * self.force

    def flux(self):
        """Mean of u over all of the volume, ice included (3,)."""
        return self.velocity().sum(axis=0) / float(np.prod(self.lattice.shape))
