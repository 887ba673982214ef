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

Of what a wall gives the grains, a part answers the water: that of (1 - n) F and of the drag, but for the buoyancy of
the grains, -s m_s rho_w / rho_g g, s the share of the pores that is full. Friction is that of the rest, the effective
stress (`mpm.contact.wall_contact`).
"""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunk_bounds, chunks, in_order, is_worker
from snowmpm.components.two_velocities.room import free_shares
from snowmpm.mpm.kernel_api import MASS, SECOND, SPARE, FieldPairs, block_nodes, node_vector

LEAST_POROSITY = 0.02
"""Of pores that are nearly closed; the water in them would be stiffer without bound."""

DT, PUSHED, GRAINS, WATER, GRAVITY = range(5)
"""Numbers of a step: dt, dt of forces [s], densities of grains and water [kg/m3], gravity along each axis [m/s2]."""

DRAG = GRAVITY + 3
"""The number at which the rows of `drag_table` begin."""

LASTING = 1e30
"""Time [s] after which drag has taken all slip."""

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
    the water. relief (contact nodes, 2 dim + 1): impulse that grains got from the water in this step, less their
    buoyancy, and the part of it that is drag [N s]; volume between walls [m3].
    """

    everywhere = (1,)

    def __init__(self, dim, real, densities, law, serial):
        super().__init__(dim, 2)
        self._numbers = np.append(np.zeros(DRAG), drag_table(law))
        self._numbers[[GRAINS, WATER]] = densities
        self._exchange, self._mix = exchange_kernels(dim, real, serial)
        self.relief = real_array(np.zeros((1, 2 * dim + 1)))

    def rebuild(self, keys, fields, index):
        super().rebuild(keys, fields, index)
        n = int(index.max(initial=0)) + 1
        self.relief, self._measured = real_array(np.zeros((n * block_nodes(self._dim), 2 * self._dim + 1))), False
        wet = np.flatnonzero(fields == 1)
        partner = dict(zip(keys[fields == 0].tolist(), index[fields == 0].tolist(), strict=True))
        rows = np.array([[index[i], partner.get(int(keys[i]), -1)] for i in wet]).reshape(-1, 2)
        self._wet, self._wet_cut, self._n_wet = int_array(rows), int_array(chunk_bounds(np.ones(len(wet)))), len(wet)
        self._part = real_array(np.zeros((max(1, len(wet)), 1)))

    def begin(self, dt, pushed, gravity, held=False):
        """Of a step of dt [s] in which forces and gravity (dim,) [m/s2] act for the time `pushed` [s]; held: water goes
        with the grains, as by drag without end."""
        self.held = held
        self._numbers[[DT, PUSHED]] = LASTING if held else dt, pushed
        self._numbers[GRAVITY : GRAVITY + len(gravity)] = gravity

    def apply_contact(self, grid, dx):
        """Pressure and drag of a step."""
        if not self._measured:
            room = np.zeros(self.relief.shape)
            share = free_shares(grid)
            room[: len(share), -1] = dx**self._dim * share
            self.relief.from_numpy(room)
            self._measured = True
        for total, rows, part, cut, _ in self._groups:
            self._exchange(grid.nodes, grid.contact_offset, rows, self._numbers, part, total, cut, self.relief)

    def mix(self, grid):
        """Book what drag took, now that walls have acted; put q in the place of w at the nodes of water, n in that of
        their volume, and in that of the first of their velocity before how full of water what grains leave is."""
        if self._n_wet:
            self._mix(grid.nodes, grid.contact_offset, self._wet, self._numbers, self._part, self.totals[0, 1],
                      self._wet_cut, self.relief)


@functools.cache
def exchange_kernels(dim, real, serial):
    """Kernels: `exchange`, rows (k, 4) of contact blocks of grains and water, and `mix`, rows (k, 2) of those of water
    and of grains there, -1 for none."""
    n_nodes, of_node = block_nodes(dim), node_vector(real, True)
    volume = SPARE

    @ti.func
    def share_of_water(grains, water, numbers: ti.template()):
        """n"""
        solid, liquid = grains[MASS] / numbers[GRAINS], water[MASS] / numbers[WATER]
        return ti.max(LEAST_POROSITY, 1.0 - solid / ti.max(grains[volume], solid + liquid))

    @ti.func
    def fullness(grains, water, numbers: ti.template()):
        """Share of the pores that water fills."""
        pores = ti.max(LEAST_POROSITY * grains[volume], grains[volume] - grains[MASS] / numbers[GRAINS])
        return ti.min(1.0, water[MASS] / numbers[WATER] / pores)

    @ti.func
    def drag_of(grains, water, slip, numbers: ti.template()):
        """D [kg/s]"""
        bulk = grains[volume]
        pores = ti.min(1.0, ti.max(LEAST_POROSITY, 1.0 - grains[MASS] / numbers[GRAINS] / bulk))
        place = pores * ti.static(TABLE - 1.0)
        low = ti.min(ti.cast(place, ti.i32), TABLE - 2)
        on, row = place - low, DRAG + 2 * low
        still = ti.exp((1.0 - on) * numbers[row] + on * numbers[row + 2])
        more = (1.0 - on) * numbers[row + 1] + on * numbers[row + 3]
        return (still + more * slip) * ti.min(bulk, water[MASS] / numbers[WATER] / pores)

    @taichi_kernel
    def exchange(nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int, rows: ti.types.ndarray(),
                 numbers: ti.types.ndarray(), part: ti.types.ndarray(), total: ti.types.ndarray(),
                 cut: ti.types.ndarray(), relief: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for k in range(chunks(cut)):
            if is_worker(k):
                begin, end = chunk(k, cut)
                for i in range(begin, end):
                    taken = ti.Vector.zero(ti.f64, dim)
                    for q in range(n_nodes):
                        first = contact_offset + rows[i, 0] * n_nodes + q
                        second = contact_offset + rows[i, 1] * n_nodes + q
                        one, two = nodes[first], nodes[second]
                        m_s, m_w = one[MASS], two[MASS]
                        for a in ti.static(range(2 * dim)):
                            relief[first - contact_offset, a] = 0.0
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
                            rate = numbers[DT] * drag_of(one, two, u.norm(), numbers) * (1.0 / m_s + 1.0 / m_w)
                            kept = ti.exp(-rate)
                            mean = 1.0 - 0.5 * rate
                            if rate > 1e-4:
                                mean = (1.0 - kept) / rate
                            slip, reduced = w - v, m_s * m_w / (m_s + m_w)
                            after = kept * u + mean * (slip - u)
                            change = reduced * (after - slip)
                            displaced = fullness(one, two, numbers) * m_s / numbers[GRAINS] * numbers[WATER]
                            for a in ti.static(range(dim)):
                                one[a] = v[a] - change[a] / m_s
                                two[a] = w[a] + change[a] / m_w
                                taken[a] += given[a] + change[a]
                                buoyancy = -displaced * numbers[PUSHED] * numbers[GRAVITY + a]
                                relief[first - contact_offset, a] = -given[a] - change[a] - buoyancy
                                relief[first - contact_offset, dim + a] = -change[a]
                            nodes[first], nodes[second] = one, two
                    for a in ti.static(range(dim)):
                        part[i, a] = taken[a]
        ti.loop_config(serialize=ti.static(in_order()))
        for i in range(rows.shape[0]):
            for a in ti.static(range(dim)):
                total[1 + a] += part[i, a]

    @taichi_kernel
    def mix(nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int, rows: ti.types.ndarray(),
            numbers: ti.types.ndarray(), part: ti.types.ndarray(), total: ti.types.ndarray(), cut: ti.types.ndarray(),
            relief: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for k in range(chunks(cut)):
            if is_worker(k):
                begin, end = chunk(k, cut)
                for i in range(begin, end):
                    taken = ti.cast(0.0, ti.f64)
                    for q in range(n_nodes):
                        here = contact_offset + rows[i, 0] * n_nodes + q
                        water = nodes[here]
                        if water[MASS] > 0.0:
                            n, room = ti.cast(1.0, real), ti.cast(relief[rows[i, 0] * n_nodes + q, 2 * dim], real)
                            fill = water[MASS] / numbers[WATER]
                            if rows[i, 1] >= 0:
                                place = rows[i, 1] * n_nodes + q
                                grains = nodes[contact_offset + place]
                                if grains[MASS] > 0.0:
                                    n = share_of_water(grains, water, numbers)
                                    room -= grains[MASS] / numbers[GRAINS]
                                    for a in ti.static(range(dim)):
                                        # At the mean of the slips of the step: walls have stopped the nodes at them
                                        slips = water[SECOND + a] - grains[SECOND + a] + water[a] - grains[a]
                                        taken += 0.5 * relief[place, dim + a] * slips
                                        water[a] = n * water[a] + (1.0 - n) * grains[a]
                            # On the way to the tiles this half becomes the first less itself
                            water[volume], water[SECOND] = n, water[0] - fill / ti.max(room, 1e-3 * fill)
                            nodes[here] = water
                    part[i, 0] = taken
        ti.loop_config(serialize=ti.static(in_order()))
        for i in range(rows.shape[0]):
            total[0] += part[i, 0]

    return exchange, mix
