"""What columns feel of each other, at the nodes of the plan grid.

    depth      H_i = V_i / dx^2, measured vertically
    potential  phi_i = g cos^2 H_i, partly over the corners of the cells (`depth.smoothing`),   a = -grad phi
    velocity   u_i = M_i / V_i

cos^2 H is the height of the surface over the ground for a layer of thickness cos H (Bouchut et al. 2003,
doi:10.1016/S1631-073X(03)00117-1): a lake stays at rest, and on a plane the pressure is that of Savage and Hutter. The
sum of V_i phi_i / 2 is the energy of these forces, and what they do to the columns its gradient, so that it is
conserved (Hamiltonian particle-mesh method, Frank, Gottwald and Reich 2002, doi:10.1007/978-3-642-56103-0_10).

Columns around a node i, and around a corner c of cells, give up what sets them apart at the rates

    v_p <- v_p + sum_i beta_i w_ip (u_i - v_p) + sum_c beta_c w_cp (u_c - v_p)
    beta_i = 1 - exp(-dt C_1 sqrt(g cos^2 H_i) / dx)
    beta_c = 1 - exp(-dt C_2 max(0, R_c - u_c . G_c) / V_c)

where w_cp, V_c, R_c and G_c are means of the four nodes around the corner and u_c = M_c / V_c. This leaves alone
velocities that are linear in place, conserves momentum and takes energy, node by node. C_1 damps disorder at the speed
of waves; C_2 acts where snow gathers, as at a shock: R - u . G is -V div u by differences of velocities (P-73, first
form), as in the viscosity of von Neumann and Richtmyer (1950, doi:10.1063/1.1699639). Taken at nodes, which reach less
far, it would let waves of two cells stand behind a shock.
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import strided, strides
from snowmpm.depth.arrays import CoverArrays, NodeArrays, Tallies
from snowmpm.depth.plan_grid import MARGIN, TILE
from snowmpm.depth.scatter import TALLIES, WATER
from snowmpm.depth.smoothing import SMOOTHING

NODE = 6
"""Numbers of a node: phi, H, b = sum of all beta, b u (2), share of the wanted snow cover that there is."""

TOTALS = 6
"""Numbers of a node of the tallies that neighbours read: V, M (2), R dx, G dx (2)."""


@ti.func
def closing(s):
    """max(0, R - u . G) / V times dx, of totals s."""
    u = ti.Vector([s[1], s[2]]) / s[0]
    return ti.max(0.0, (s[3] - u.dot(ti.Vector([s[4], s[5]]))) / s[0])


class Step(NamedTuple):
    """g [m/s2]; dx [m]; C_1 and C_2; dt [s]."""

    g: Real
    dx: Real
    damping: Real
    mixing: Real
    dt: Real


class Tiles(NamedTuple):
    """Tiles of a set of nodes: those of the sets before it (`column_load`), n of its own, rows of them along y; nodes
    along x and y."""

    first: int
    n: int
    rows: int
    nx: int
    ny: int


@functools.cache
def node_kernel(real, takes, serial):
    """Kernel that makes the numbers of nodes of the tallies of tiles that were touched, and clears these. Tiles that
    were touched in the step before only are `live`, and are emptied.

    takes: whether snow cover is taken up.
    """

    @ti.func
    def three(nodes: ti.template(), first, i, j):
        """Totals and cos^2 (3, 7) of the nodes i - 1, i, i + 1 with the second index j."""
        found = ti.Matrix.zero(real, 3, TOTALS + 1)
        for a in ti.static(range(3)):
            node = nodes.lookup[0, i + (a - 1 + MARGIN)] + nodes.lookup[1, j + MARGIN]
            one = nodes.totals[first + node]
            for k in ti.static(range(TOTALS)):
                found[a, k] = one[k]
            found[a, TOTALS] = ti.cast(nodes.cos2[node], real)
        return found

    @ti.func
    def corners(here: ti.template(), ahead: ti.template(), rate):
        """What the two corners between three nodes and the next three give the one in the middle: cos^2 H, beta, and
        beta u (2), a fourth of each."""
        given = ti.Vector.zero(real, 4)
        for a in ti.static(range(2)):
            s = ti.Vector([here[a, k] + here[a + 1, k] + ahead[a, k] + ahead[a + 1, k]
                           for k in ti.static(range(TOTALS + 1))])
            if s[0] > 0.0:
                beta = 0.25 * (1.0 - ti.exp(-rate * closing(s)))
                given += ti.Vector([s[0] * s[TOTALS] / 64.0, beta, beta / s[0] * s[1], beta / s[0] * s[2]])
        return given

    @grouped_kernel(real)
    def resolve(tallies: Tallies, nodes: NodeArrays, cover: CoverArrays, bed: Array, step: Step, tiles: Tiles):
        first = tiles.first * (TILE * TILE)
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile, found = strided(turn, tiles.n), 0
            if tile < tiles.n:
                for copy in range(tallies.copies):
                    found += tallies.touched[copy * tallies.stride + tiles.first + tile] << copy
            if found > 0:
                for copy in range(tallies.copies):
                    tallies.touched[copy * tallies.stride + tiles.first + tile] = 0
                for inner in range(TILE * TILE):
                    node = tile * (TILE * TILE) + inner
                    sums = ti.Vector.zero(real, TALLIES)
                    for copy in range(tallies.copies):
                        if (found >> copy) & 1:
                            place = (copy * tallies.stride + tiles.first) * (TILE * TILE) + node
                            sums += tallies.sums[place]
                            tallies.sums[place] = ti.Vector.zero(real, TALLIES)
                    nodes.totals[first + node] = ti.Vector([sums[k] for k in ti.static(range(TOTALS))])
                    if ti.static(takes):
                        wanted = ti.cast(sums[TALLIES - 1], ti.f64) * WATER * tallies.unit
                        nodes.values[first + node][NODE - 1] = 0.0
                        if wanted > 0.0:
                            taken = ti.min(wanted, cover.mass[node])
                            cover.mass[node] -= taken
                            bed[cover.under[node]] -= taken * cover.lowering[node]
                            nodes.values[first + node][NODE - 1] = ti.cast(taken / wanted, real)
                nodes.live[tiles.first + tile] = 1
            elif tile < tiles.n and nodes.live[tiles.first + tile] > 0:
                for inner in range(TILE * TILE):
                    nodes.totals[(tiles.first + tile) * (TILE * TILE) + inner] = ti.Vector.zero(real, TOTALS)
                    for k in ti.static(range(NODE)):
                        nodes.values[(tiles.first + tile) * (TILE * TILE) + inner][k] = 0.0
                nodes.live[tiles.first + tile] = 0
        deep = tallies.unit / (step.dx * step.dx)
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and nodes.live[tiles.first + tile] > 0:
                for row in range(TILE):
                    i, first_j = tile // tiles.rows * TILE + row, tile % tiles.rows * TILE
                    if i < tiles.nx:
                        here = three(nodes, first, i, first_j)
                        behind = corners(three(nodes, first, i, first_j - 1), here, step.dt * step.mixing / step.dx)
                        for j in range(first_j, ti.min(first_j + TILE, tiles.ny)):
                            ahead = three(nodes, first, i, j + 1)
                            before = corners(here, ahead, step.dt * step.mixing / step.dx)
                            given, V = behind + before, here[1, 0]
                            level = here[1, TOTALS] * V
                            beta, drive = given[1], ti.Vector([given[2], given[3]])
                            if V > 0.0:
                                share = 1.0 - ti.exp(-step.dt * step.damping * ti.sqrt(step.g * level * deep) / step.dx)
                                beta += share
                                drive += share / V * ti.Vector([here[1, 1], here[1, 2]])
                            level += SMOOTHING * (given[0] - level)
                            node = first + tile * (TILE * TILE) + row * TILE + j - first_j
                            nodes.values[node][0] = step.g * level * deep
                            nodes.values[node][1], nodes.values[node][2] = V * deep, beta
                            nodes.values[node][3], nodes.values[node][4] = drive[0], drive[1]
                            here, behind = ahead, before

    return resolve
