"""What columns feel of each other, at the nodes of the plan grid.

    depth      H_i = V_i / dx^2, measured vertically
    potential  phi_i = g cos^2 H_i,   a = -grad phi
    velocity   u_i = M_i / V_i

cos^2 H is the height of the surface over the ground for a layer of thickness cos H (Bouchut et al. 2003,
doi:10.1016/S1631-073X(03)00117-1): a lake stays at rest, and on a plane the pressure is that of Savage and Hutter. The
sum of V_i phi_i / 2 is the energy of these forces, and what they do to the columns its gradient, so that it is
conserved (Hamiltonian particle-mesh method, Frank, Gottwald and Reich 2002, doi:10.1007/978-3-642-56103-0_10).

Columns around a node give up what sets them apart at the rate

    v_p <- v_p + sum_i beta_i w_ip (u_i - v_p),   beta_i = 1 - exp(-dt kappa_i)
    kappa_i = C_1 sqrt(phi_i) / dx + C_2 max(0, R_i - u_i . G_i) / V_i

which leaves alone velocities that are linear in place, conserves momentum and takes energy, node by node. C_1 damps
disorder at the speed of waves; C_2 acts where snow gathers, as at a shock: R_i - u_i . G_i is -V_i div u by differences
of velocities (P-73, first form), as in the viscosity of von Neumann and Richtmyer (1950, doi:10.1063/1.1699639).
"""

import functools

import taichi as ti

from snowmpm.compiler.launch import taichi_kernel
from snowmpm.depth.plan_grid import TILE
from snowmpm.depth.scatter import TALLIES, WATER

NODE = 6
"""Numbers of a node: phi, H, beta, u (2), share of the wanted snow cover that there is."""


@functools.cache
def node_kernel(real, entrains, serial):
    """Kernel that makes the numbers of nodes of the tallies of tiles that were touched, and clears these.

    copies: sets of tallies that are added up. entrains: whether snow cover is taken up; then cover: mass left [kg] of
    each node's cell, lowering: how far [m] the ground sinks where a kilogram is taken, under: the node's place in bed.
    """

    @taichi_kernel
    def resolve(tallies: ti.types.ndarray(), touched: ti.types.ndarray(), cos2: ti.types.ndarray(),
                nodes: ti.types.ndarray(), cover: ti.types.ndarray(), lowering: ti.types.ndarray(),
                under: ti.types.ndarray(), bed: ti.types.ndarray(),
                g: real, dx: real, unit: real, damping: real, mixing: real, dt: real,
                copies: int, n_tiles: int):
        ti.loop_config(serialize=serial)
        for tile in range(n_tiles):
            found = 0
            for copy in range(copies):
                found += touched[copy * n_tiles + tile] << copy
            if found > 0:
                for copy in range(copies):
                    touched[copy * n_tiles + tile] = 0
                for inner in range(TILE * TILE):
                    node = tile * (TILE * TILE) + inner
                    sums = ti.Vector.zero(real, TALLIES)
                    for copy in range(copies):
                        if (found >> copy) & 1:
                            place = copy * n_tiles * (TILE * TILE) + node
                            sums += tallies[place]
                            tallies[place] = ti.Vector.zero(real, TALLIES)
                    result = ti.Vector.zero(real, NODE)
                    if sums[0] > 0.0:
                        volume = sums[0]
                        depth = volume * unit / (dx * dx)
                        u = ti.Vector([sums[1 + a] / volume for a in ti.static(range(2))])
                        gradient = ti.Vector([sums[4 + a] for a in ti.static(range(2))])
                        closing = ti.max(0.0, (sums[3] - u.dot(gradient)) / volume) / dx
                        phi = g * ti.cast(cos2[node], real) * depth
                        kappa = damping * ti.sqrt(phi) / dx + mixing * closing
                        result = ti.Vector([phi, depth, 1.0 - ti.exp(-dt * kappa), u[0], u[1], 0.0])
                        if ti.static(entrains):
                            wanted = ti.cast(sums[TALLIES - 1], ti.f64) * WATER * unit
                            if wanted > 0.0:
                                taken = ti.min(wanted, cover[node])
                                cover[node] -= taken
                                bed[under[node]] -= taken * lowering[node]
                                result[NODE - 1] = ti.cast(taken / wanted, real)
                    nodes[node] = result

    return resolve
