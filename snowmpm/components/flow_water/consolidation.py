"""Excess pore pressure over the depth of each column: what load adds, and what drains away.

With eta = x3 / d over the saturated part of a column, d deep, of which the mesh moves with the snow,

    d p/dt = l(eta) dW/dt + (c_v / d^2) d2p/d eta2,   p = 0 at eta = 1,   dp/d eta = 0 or, drained, p = 0 at the ground

(Pastor et al. 2020, Coupled depth integrated two phase SPH models for fast landslides, ALERT Doctoral School 2020, eqs.
49 and 58, for a constant porosity). W is the weight that the skeleton bears at the ground without p, so that p = W
there is liquefaction, and l = u + (1 - u) (1 - eta), u the share of W that lies above the water. P-58 has u = 0 and the
change of thickness only; W changes with slope and curvature as well. In coarse snow pores hold no suction: p is at
least minus the hydrostatic pressure.

Second differences at eta = k / layers, with an imaginary node below a sealed ground; in time the second-order method of
two implicit stages that damps what is too fast for a step, gamma = 1 - 1 / sqrt 2 (Alexander 1977,
doi:10.1137/0714068).
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.components.flow_water.bearing import BUOYANT, DRAINED, EFFECTIVE, LOAD, NOW, OVERBURDEN, WATER
from snowmpm.depth.kernel_api import LEAST_DEPTH, MARGIN

GAMMA = 1.0 - 0.5**0.5


@ti.func
def factorise(excess: ti.template(), p, layers, z, sealed):
    """Write what one over the pivots of 1 + z T is into the last third of a row, T the negative second difference;
    sealed: 1, or 0 where the pressure at the ground is given."""
    over = 1.0 / (1.0 + 2.0 * z * sealed)
    excess[p, 2 * layers] = over
    left = 2.0 * z * z * sealed
    for k in range(1, layers):
        over = 1.0 / (1.0 + 2.0 * z - left * over)
        excess[p, 2 * layers + k] = over
        left = z * z


@ti.func
def solve(excess: ti.template(), p, first, layers, z, sealed):
    """(1 + z T) x = b in place, from place `first` on, after `factorise`."""
    last = excess[p, first] * excess[p, 2 * layers]
    excess[p, first] = last
    for k in range(1, layers):
        last = (excess[p, first + k] + z * last) * excess[p, 2 * layers + k]
        excess[p, first + k] = last
    for back in range(1, layers - 1):
        k = layers - 1 - back
        last = excess[p, first + k] + z * excess[p, 2 * layers + k] * last
        excess[p, first + k] = last
    excess[p, first] = excess[p, first] + 2.0 * sealed * z * excess[p, 2 * layers] * last


@functools.cache
def consolidate_kernel(real, serial):
    """Kernel that takes the pressures of all columns through a step, after the columns have moved.

    excess (n, 3 layers): p at eta = k / layers and room for two more; pores (n,): `bearing`; drains (n_nodes,): 1
    where the ground is drained; rate: c_v dt (h / d)^2 [m2]."""

    @taichi_kernel
    def consolidate(excess: ti.types.ndarray(), pores: ti.types.ndarray(), reals: ti.types.ndarray(),
                    cells: ti.types.ndarray(), lookup: ti.types.ndarray(), drains: ti.types.ndarray(), rate: real,
                    n: int):
        ti.loop_config(serialize=serial)
        for p in range(n):
            layers = excess.shape[1] // 3
            pore = pores[p]
            load, above = pore[NOW], pore[OVERBURDEN]
            gain, kept = load - pore[LOAD], 1.0 + 0.0 * load
            if pore[LOAD] < 0.0:  # its first step: in a straight line to nothing at the water
                gain, above, kept = load * (1.0 - pore[EFFECTIVE]), 0.0 * load, 0.0 * load
            least = -load * pore[WATER] / pore[BUOYANT]
            for k in range(layers):
                down = 1.0 - ti.cast(k, real) / layers
                raised = kept * excess[p, k] + gain * (above + (1.0 - above) * down)
                excess[p, k] = ti.max(least * down, raised)
            here = lookup[0, cells[p][0] + MARGIN] + lookup[1, cells[p][1] + MARGIN]
            pore[DRAINED] = ti.cast(drains[here], real)
            if pore[DRAINED] > 0.0:
                excess[p, 0] = 0.0
            z = ti.static(GAMMA) * rate * (layers / ti.max(LEAST_DEPTH, reals[p][5])) ** 2
            sealed = 1.0 - pore[DRAINED]
            factorise(excess, p, layers, z, sealed)
            for k in range(layers):
                excess[p, layers + k] = excess[p, k]
            solve(excess, p, layers, layers, z, sealed)
            for k in range(layers):
                stage = excess[p, layers + k] - excess[p, k]
                excess[p, k] = excess[p, k] + ti.static((1.0 - GAMMA) / GAMMA) * stage
            solve(excess, p, 0, layers, z, sealed)
            pore[LOAD], pore[EFFECTIVE] = load, load - excess[p, 0]
            pores[p] = pore

    return consolidate
