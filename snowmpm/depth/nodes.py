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

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import strided, strides
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


@functools.cache
def node_kernel(real, takes, serial):
    """Kernel that makes the numbers of nodes of the tallies of tiles that were touched, and clears these. Tiles that
    were touched in the step before only are `live`, and are emptied.

    copies: sets of tallies that are added up, `stride` tiles each; base: tiles of sets before this one
    (`column_load`). tile_rows: tiles along y. nx, ny: nodes. takes: whether snow cover is
    taken up; then cover: mass left [kg] of each node's cell, lowering: how far [m] the ground sinks where a kilogram is
    taken, under: the node's place in bed.
    """

    @ti.func
    def three(totals: ti.template(), lookup: ti.template(), cos2: ti.template(), first, i, j):
        """Totals and cos^2 (3, 7) of the nodes i - 1, i, i + 1 with the second index j."""
        found = ti.Matrix.zero(real, 3, TOTALS + 1)
        for a in ti.static(range(3)):
            node = lookup[0, i + (a - 1 + MARGIN)] + lookup[1, j + MARGIN]
            one = totals[first + node]
            for k in ti.static(range(TOTALS)):
                found[a, k] = one[k]
            found[a, TOTALS] = ti.cast(cos2[node], real)
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

    @taichi_kernel
    def resolve(tallies: ti.types.ndarray(), touched: ti.types.ndarray(), live: ti.types.ndarray(),
                totals: ti.types.ndarray(), nodes: ti.types.ndarray(), lookup: ti.types.ndarray(),
                cos2: ti.types.ndarray(), cover: ti.types.ndarray(), lowering: ti.types.ndarray(),
                under: ti.types.ndarray(), bed: ti.types.ndarray(), g: real, dx: real, unit: real, damping: real,
                mixing: real, dt: real, copies: int, stride: int, base: int, n_tiles: int, tile_rows: int, nx: int,
                ny: int):
        first = base * (TILE * TILE)
        ti.loop_config(serialize=serial)
        for turn in range(strides(n_tiles)):
            tile, found = strided(turn, n_tiles), 0
            if tile < n_tiles:
                for copy in range(copies):
                    found += touched[copy * stride + base + tile] << copy
            if found > 0:
                for copy in range(copies):
                    touched[copy * stride + base + tile] = 0
                for inner in range(TILE * TILE):
                    node = tile * (TILE * TILE) + inner
                    sums = ti.Vector.zero(real, TALLIES)
                    for copy in range(copies):
                        if (found >> copy) & 1:
                            place = (copy * stride + base) * (TILE * TILE) + node
                            sums += tallies[place]
                            tallies[place] = ti.Vector.zero(real, TALLIES)
                    totals[first + node] = ti.Vector([sums[k] for k in ti.static(range(TOTALS))])
                    if ti.static(takes):
                        wanted = ti.cast(sums[TALLIES - 1], ti.f64) * WATER * unit
                        nodes[first + node][NODE - 1] = 0.0
                        if wanted > 0.0:
                            taken = ti.min(wanted, cover[node])
                            cover[node] -= taken
                            bed[under[node]] -= taken * lowering[node]
                            nodes[first + node][NODE - 1] = ti.cast(taken / wanted, real)
                live[base + tile] = 1
            elif tile < n_tiles and live[base + tile] > 0:
                for inner in range(TILE * TILE):
                    totals[(base + tile) * (TILE * TILE) + inner] = ti.Vector.zero(real, TOTALS)
                    for k in ti.static(range(NODE)):
                        nodes[(base + tile) * (TILE * TILE) + inner][k] = 0.0
                live[base + tile] = 0
        deep = unit / (dx * dx)
        ti.loop_config(serialize=serial)
        for turn in range(strides(n_tiles)):
            tile = strided(turn, n_tiles)
            if tile < n_tiles and live[base + tile] > 0:
                for row in range(TILE):
                    i, first_j = tile // tile_rows * TILE + row, tile % tile_rows * TILE
                    if i < nx:
                        here = three(totals, lookup, cos2, first, i, first_j)
                        behind = corners(three(totals, lookup, cos2, first, i, first_j - 1), here, dt * mixing / dx)
                        for j in range(first_j, ti.min(first_j + TILE, ny)):
                            ahead = three(totals, lookup, cos2, first, i, j + 1)
                            before = corners(here, ahead, dt * mixing / dx)
                            given, V = behind + before, here[1, 0]
                            level = here[1, TOTALS] * V
                            beta, drive = given[1], ti.Vector([given[2], given[3]])
                            if V > 0.0:
                                share = 1.0 - ti.exp(-dt * damping * ti.sqrt(g * level * deep) / dx)
                                beta += share
                                drive += share / V * ti.Vector([here[1, 1], here[1, 2]])
                            level += SMOOTHING * (given[0] - level)
                            node = first + tile * (TILE * TILE) + row * TILE + j - first_j
                            nodes[node][0], nodes[node][1], nodes[node][2] = g * level * deep, V * deep, beta
                            nodes[node][3], nodes[node][4] = drive[0], drive[1]
                            here, behind = ahead, before

    return resolve
