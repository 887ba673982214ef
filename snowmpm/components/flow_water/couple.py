"""What columns of grains and columns of water feel of each other, at the nodes of the plan grid.

Pitman and Le (2005, doi:10.1098/rsta.2005.1596), as Pelanti, Bouchut and Mangeney (2008, doi:10.1051/m2an:2008029) and
Pastor et al. (2020, ALERT Doctoral School, eqs. 46 to 57) write it, with h = h_s + h_w, gamma = rho_w / rho_s and drag
R = C (v_w - v_s):

    dv_s/dt = -g grad h_s - (1 + gamma)/2 g grad h_w - (1 - gamma)/2 g (h_w / h_s) grad h_s + h R / (rho_s h_s)
    dv_w/dt = -g grad h - h R / (rho_w h_w)

With m = rho_s h_s + rho_w h_w, both together have the acceleration of the potential energy m g h / 2,

    (rho_s h_s dv_s/dt + rho_w h_w dv_w/dt) / m = -g/2 (grad h + (h / m) grad m)

which every column gets at its place, in the way of `depth.nodes`. Its h / m is a number of its own, which follows that
around it as the phases move apart by cells. What parts the phases beside drag,

    a_w - a_s = (1 - gamma)/2 g ((h_w / h_s) grad h_s - grad h_w)

and drag act node by node, with equal and opposite momentum, and are integrated exactly and at once (`water.drag.
relaxed`): no drag limits the step, and what a stiff one holds together is not pulled apart first. So is friction of the
ground, which acts on the grains: with F the part of it that does not depend on the speed, and mean = (1 - exp(-l dt)) /
(l dt) of the drag's rate l,

    grains   -F / m - (m_w / m) mean F / m_s,    water   -F / m (1 - mean)
"""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import strided, strides
from snowmpm.depth.kernel_api import MARGIN, TILE, NodeArrays

OWN, HEAVY, LIGHT, LOOSE, APART, NUMBERS = 6, 7, 8, 9, 10, 11
"""Places in the numbers of a node, after those of `depth.nodes`: depth of the phase alone, g/2 m / rho_w, h rho_w / m,
cells by which the phases move apart in the step, share that drag leaves of what parts them; and how many there are."""

LEAST_SHARE = 0.02
"""Of the depth, below which a phase is too thin to exchange momentum."""

TABLE = 1025
"""Entries of C by porosity, 0 to 1."""


class Sizes(NamedTuple):
    """Nodes and tiles of a phase, tiles along y, nodes along both axes."""

    n_nodes: int
    n_tiles: int
    tile_rows: int
    nx: int
    ny: int


class Mixture(NamedTuple):
    """Densities [kg/m3]; g; dx; depth of a unit of volume on a cell [m]; dt [s]; C_1 of `depth.nodes`."""

    grains: Real
    water: Real
    g: Real
    dx: Real
    deep: Real
    dt: Real
    damping: Real


def drag_table(law):
    """ln C (TABLE,) of a law of `water.drag` at small slip."""
    porosity = np.clip(np.linspace(0.0, 1.0, TABLE), 1e-4, 1.0 - 1e-4)
    return np.log(law.coefficient(porosity, 0.0))


@functools.cache
def couple_kernel(real, serial):
    """Kernel that puts both phases of the nodes together, after `depth.nodes` of each alone. ln_drag: `drag_table`."""

    @grouped_kernel(real)
    def couple(at: NodeArrays, ln_drag: Array, size: Sizes, mix: Mixture):
        ti.loop_config(serialize=serial)
        for turn in range(strides(size.n_tiles)):
            tile = strided(turn, size.n_tiles)
            if tile < size.n_tiles and at.live[tile] > 0:
                gamma = mix.water / mix.grains
                for inner in range(TILE * TILE):
                    i, j = tile // size.tile_rows * TILE + inner // TILE, tile % size.tile_rows * TILE + inner % TILE
                    if i < size.nx and j < size.ny:
                        node = tile * (TILE * TILE) + inner
                        water = node + size.n_nodes
                        rise_s, rise_w = ti.Vector.zero(real, 2), ti.Vector.zero(real, 2)
                        for a, b in ti.static(ti.ndrange(3, 3)):
                            if ti.static(a != 1 or b != 1):
                                other = at.lookup[0, i + (a - 1 + MARGIN)] + at.lookup[1, j + (b - 1 + MARGIN)]
                                level = mix.g * ti.cast(at.cos2[other], real) * mix.deep / (8.0 * mix.dx)
                                along = ti.Vector([ti.static((a - 1) * (2 - abs(b - 1))),
                                                   ti.static((b - 1) * (2 - abs(a - 1)))])
                                rise_s += level * at.totals[other][0] * along
                                rise_w += level * at.totals[other + size.n_nodes][0] * along
                        grains, wet = at.values[node], at.values[water]
                        h_s, h_w = grains[1], wet[1]
                        h = h_s + h_w
                        m_s, m_w = mix.grains * h_s, mix.water * h_w
                        light = mix.water * h / ti.max(m_s + m_w, 1e-30)
                        heavy = 0.5 * (grains[0] / gamma + wet[0])
                        at.values[node][ti.static(OWN)], at.values[water][ti.static(OWN)] = h_s, h_w
                        for k in ti.static(range(2)):
                            at.values[node + k * size.n_nodes][0] = 0.5 * (grains[0] + wet[0])
                            at.values[node + k * size.n_nodes][1] = h
                            at.values[node + k * size.n_nodes][ti.static(HEAVY)] = heavy
                            at.values[node + k * size.n_nodes][ti.static(LIGHT)] = light
                        loose, mean = 1.0 + 0.0 * h, 1.0 + 0.0 * h
                        # Disorder is damped at the speed of waves of both
                        whole = ti.exp(-mix.damping * mix.dt / mix.dx * ti.sqrt(ti.max(0.0, grains[0] + wet[0])))
                        for k, part in ti.static(((0, grains), (1, wet))):
                            sums = at.totals[node + k * size.n_nodes]
                            if sums[0] > 0.0:
                                level = mix.g * ti.cast(at.cos2[node], real) * mix.deep * sums[0]
                                more = ti.exp(-mix.damping * mix.dt / mix.dx * ti.sqrt(level)) - whole
                                part[2] += more
                                for axis in ti.static(range(2)):
                                    part[3 + axis] += more * sums[1 + axis] / sums[0]
                            at.values[node + k * size.n_nodes][2] = part[2]
                            for axis in ti.static(range(2)):
                                at.values[node + k * size.n_nodes][3 + axis] = part[3 + axis]
                        least = ti.static(LEAST_SHARE) * h
                        if h_s > least and h_w > least:
                            s, w = at.totals[node], at.totals[water]
                            slip = ti.Vector([w[1] / w[0] - s[1] / s[0], w[2] / w[0] - s[2] / s[0]])
                            apart = 0.5 * (1.0 - gamma) * (h_w / h_s * rise_s - rise_w)
                            place = ti.static(float(TABLE - 1)) * h_w / h
                            low = ti.min(ti.cast(place, ti.i32), TABLE - 2)
                            on = place - low
                            drag = ti.exp((1.0 - on) * ln_drag[low] + on * ln_drag[low + 1])
                            rate = mix.dt * ti.cast(drag, real) * h * (1.0 / m_s + 1.0 / m_w)
                            kept = ti.exp(-rate)
                            mean = 1.0 - 0.5 * rate
                            if rate > 1e-3:
                                mean = (1.0 - kept) / rate
                            change = (kept - 1.0) * slip + mix.dt * mean * apart
                            loose = mix.dt / mix.dx * (kept * slip + mix.dt * mean * apart).norm()
                            for k in ti.static(range(2)):
                                at.values[node][3 + k] = grains[3 + k] - m_w / (m_s + m_w) * change[k]
                                at.values[water][3 + k] = wet[3 + k] + m_s / (m_s + m_w) * change[k]
                        for k in ti.static(range(2)):
                            at.values[node + k * size.n_nodes][ti.static(LOOSE)] = loose
                            at.values[node + k * size.n_nodes][ti.static(APART)] = mean

    return couple
