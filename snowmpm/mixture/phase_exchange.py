"""What grains and water, each in a velocity field of its own, give each other at the nodes.

At a node with the masses m_s, m_w and the volumes S = m_s / rho_g of grains, W = m_w / rho_w of water and B of the snow
whose skeleton the grains are (pores included), with F the force that the water's particles put on it by their pressure,

    n = 1 - S / max(B, S + W)             share of the water in what both fill, 1 in water without grains
    m_w dw/dt = n F + D (v - w),   m_s dv/dt = F_s + (1 - n) F + D (w - v)

so that the water gets -n grad p, the grains -(1 - n) grad p, wherever n changes (Bandara and Soga 2015,
doi:10.1016/j.compgeo.2014.09.009). D = C(n_g) min(B, W / n_g), n_g = 1 - S / B the porosity of the skeleton and C that
of a law of `water.drag`; it is integrated exactly (`water.drag.relaxed`), with C at the slip of the start of the step,
so that drag sets no step. What both fill changes by the volume that flows through the node,

    q = n w + (1 - n) v

whose divergence gives the pressure: the work of F is that of p on div q, to the last bit of the scheme.
"""

import functools

import numpy as np
import taichi as ti

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunk_bounds, chunks, in_order, is_worker
from snowmpm.mpm.contact.field_pairs import FieldPairs
from snowmpm.mpm.node import MASS, SECOND, block_nodes, node_vector

LEAST_POROSITY = 0.02
"""Of pores that are nearly closed; the water in them would be stiffer without bound."""

DT, PUSHED, GRAINS, WATER, GRAVITY = range(5)
"""Numbers of a step: dt, dt of forces [s], densities of grains and water [kg/m3], gravity along each axis [m/s2]."""

TABLE = 257
"""Entries of the drag by porosity, 0 to 1."""


def drag_table(law):
    """(TABLE, 2) of a law of `water.drag`: ln C [Pa s/m2] without slip, and C's growth with the slip [Pa s2/m3]."""
    porosity = np.clip(np.linspace(0.0, 1.0, TABLE), 0.5 * LEAST_POROSITY, 1.0 - 1e-3)
    still = law.coefficient(porosity, np.zeros(TABLE))
    return np.stack([np.log(still), law.coefficient(porosity, np.ones(TABLE)) - still], axis=1)


class PhaseExchange(FieldPairs):
    """Nodes of grains (field 0) and water (field 1).

    densities: of grains and water [kg/m3]; law: of `water.drag`. Totals have what drag took and what the grains gave
    the water.
    """

    everywhere = (1,)

    def __init__(self, dim, real, densities, law, serial):
        super().__init__(dim, 2)
        self._numbers = np.zeros(GRAVITY + dim)
        self._numbers[[GRAINS, WATER]] = densities
        self._drag = real_array(drag_table(law))
        self._exchange, self._mix = exchange_kernels(dim, real, serial)

    def rebuild(self, keys, fields, index):
        super().rebuild(keys, fields, index)
        wet = np.flatnonzero(fields == 1)
        partner = dict(zip(keys[fields == 0].tolist(), index[fields == 0].tolist(), strict=True))
        rows = np.array([[index[i], partner.get(int(keys[i]), -1)] for i in wet]).reshape(-1, 2)
        self._wet, self._wet_cut, self._n_wet = int_array(rows), int_array(chunk_bounds(np.ones(len(wet)))), len(wet)

    def begin(self, dt, pushed, gravity):
        """Of a step of dt [s] in which forces and gravity (dim,) [m/s2] act for the time `pushed` [s]."""
        self._numbers[DT], self._numbers[PUSHED], self._numbers[GRAVITY:] = dt, pushed, gravity

    def apply_contact(self, grid, dx):
        """Pressure and drag of a step."""
        for total, rows, part, cut, _ in self._groups:
            self._exchange(grid.nodes, grid.contact_offset, rows, self._drag, self._numbers, part, total, cut)

    def mix(self, grid):
        """Put q in the place of w at the nodes of water, and n in that of their volume."""
        if self._n_wet:
            self._mix(grid.nodes, grid.contact_offset, self._wet, self._numbers, self._wet_cut)


@functools.cache
def exchange_kernels(dim, real, serial):
    """Kernels: `exchange`, rows (k, 4) of contact blocks of grains and water, and `mix`, rows (k, 2) of those of water
    and of grains there, -1 for none."""
    n_nodes, of_node = block_nodes(dim), node_vector(real, True)
    volume = SECOND + MASS

    @ti.func
    def share_of_water(grains, water, numbers: ti.template()):
        """n"""
        solid, liquid = grains[MASS] / numbers[GRAINS], water[MASS] / numbers[WATER]
        return ti.max(LEAST_POROSITY, 1.0 - solid / ti.max(grains[volume], solid + liquid))

    @ti.func
    def drag_of(grains, water, slip, drag: ti.template(), numbers: ti.template()):
        """D [kg/s]"""
        bulk = grains[volume]
        pores = ti.min(1.0, ti.max(LEAST_POROSITY, 1.0 - grains[MASS] / numbers[GRAINS] / bulk))
        place = pores * ti.static(TABLE - 1.0)
        low = ti.min(ti.cast(place, ti.i32), TABLE - 2)
        on = place - low
        still = ti.exp((1.0 - on) * drag[low, 0] + on * drag[low + 1, 0])
        more = (1.0 - on) * drag[low, 1] + on * drag[low + 1, 1]
        return (still + more * slip) * ti.min(bulk, water[MASS] / numbers[WATER] / pores)

    @taichi_kernel
    def exchange(nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int, rows: ti.types.ndarray(),
                 drag: ti.types.ndarray(), numbers: ti.types.ndarray(), part: ti.types.ndarray(),
                 total: ti.types.ndarray(), cut: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for k in range(chunks(cut)):
            if is_worker(k):
                begin, end = chunk(k, cut)
                for i in range(begin, end):
                    taken = ti.Vector.zero(ti.f64, 1 + dim)
                    for q in range(n_nodes):
                        first = contact_offset + rows[i, 0] * n_nodes + q
                        second = contact_offset + rows[i, 1] * n_nodes + q
                        one, two = nodes[first], nodes[second]
                        m_s, m_w = one[MASS], two[MASS]
                        if m_s > 0.0 and m_w > 0.0 and one[volume] > 0.0:
                            v, w, u = ti.Vector.zero(real, dim), ti.Vector.zero(real, dim), ti.Vector.zero(real, dim)
                            given = ti.Vector.zero(real, dim)
                            for a in ti.static(range(dim)):
                                v[a], w[a] = one[a], two[a]
                                u[a] = two[SECOND + a] - one[SECOND + a]
                                # Contact blocks keep the velocity before the forces in their second half
                                given[a] = -m_w * (two[a] - two[SECOND + a] - numbers[PUSHED] * numbers[GRAVITY + a])
                            given *= 1.0 - share_of_water(one, two, numbers)
                            v, w = v - given / m_s, w + given / m_w
                            rate = numbers[DT] * drag_of(one, two, u.norm(), drag, numbers) * (1.0 / m_s + 1.0 / m_w)
                            kept = ti.exp(-rate)
                            mean = 1.0 - 0.5 * rate
                            if rate > 1e-4:
                                mean = (1.0 - kept) / rate
                            slip, reduced = w - v, m_s * m_w / (m_s + m_w)
                            after = kept * u + mean * (slip - u)
                            change = reduced * (after - slip)
                            # At the mean of the slips: what is lost without forces, and the power of steady flow
                            taken[0] -= 0.5 * change.dot(u + after)
                            for a in ti.static(range(dim)):
                                one[a] = v[a] - change[a] / m_s
                                two[a] = w[a] + change[a] / m_w
                                taken[1 + a] += given[a] + change[a]
                            nodes[first], nodes[second] = one, two
                    for t in ti.static(range(1 + dim)):
                        part[i, t] = taken[t]
        ti.loop_config(serialize=ti.static(in_order()))
        for i in range(rows.shape[0]):
            for t in ti.static(range(1 + dim)):
                total[t] += part[i, t]

    @taichi_kernel
    def mix(nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int, rows: ti.types.ndarray(),
            numbers: ti.types.ndarray(), cut: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for k in range(chunks(cut)):
            if is_worker(k):
                begin, end = chunk(k, cut)
                for i in range(begin, end):
                    for q in range(n_nodes):
                        here = contact_offset + rows[i, 0] * n_nodes + q
                        water = nodes[here]
                        if water[MASS] > 0.0:
                            n = ti.cast(1.0, real)
                            if rows[i, 1] >= 0:
                                grains = nodes[contact_offset + rows[i, 1] * n_nodes + q]
                                if grains[MASS] > 0.0:
                                    n = share_of_water(grains, water, numbers)
                                    for a in ti.static(range(dim)):
                                        water[a] = n * water[a] + (1.0 - n) * grains[a]
                            water[volume] = n
                            nodes[here] = water

    return exchange, mix
