"""Contact between bodies that move in velocity fields of their own, where their nodes meet.

At a node with mass of both, with v_c = (p_1 + p_2) / (m_1 + m_2) and n the unit normal from body 1 to body 2,

    n = grad V_2 / |grad V_2| or -grad V_1 / |grad V_1|, the longer of the two gradients (central differences)
    p_n = m_1 (v_1 - v_c) . n                              > 0 while they approach

the momentum p_n n goes from 1 to 2 if p_n > 0 (nothing holds bodies together that part), and of the tangential part
m_1 (v_1 - v_c)_t as much as Coulomb allows: at most mu p_n. Bardenhagen, Brackbill & Sulsky 2000,
doi:10.1016/S0045-7825(99)00338-2, eq. 19-24. V is the volume of a body at the nodes (its mass over its mean density);
at the edge of a block on a plane, whose own normal is oblique, the plane has the longer gradient (the maximum volume
gradient of Nairn 2013, doi:10.3970/cmes.2013.092.271).
"""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker
from snowmpm.compiler.runtime import DTYPES
from snowmpm.mpm.kernel_api import FieldPairs, block_nodes, node_vector
from snowmpm.particles.blocks import EDGE

LEAST_SHARE = 0.1
"""Share of a cell that each body must fill at a node. Less is the fringe of its splines: contact there would set in a
cell too early, and along normals that say little."""


class CoulombPairs(FieldPairs):
    """Contact of bodies, and what it took.

    friction (n, n): Coulomb mu between fields; density (n,): mean reference density of each [kg/m3].
    """

    def __init__(self, dim, real, flip, friction, density, serial):
        super().__init__(dim, len(density))
        self._friction, self._density = real_array(friction), real_array(density)
        self._exchange = body_contact_kernel(dim, real, flip, serial)

    @classmethod
    def of(cls, population, density, friction, solver):
        """Contact of the velocity fields of a `Population` in an `MpmSolver`; density (m,): of the materials."""
        masses = population.volumes * density[population.material]
        mass, volume = (np.bincount(population.field, part, len(friction)) for part in (masses, population.volumes))
        return cls(solver.dim, DTYPES[solver.precision][0], solver.flip, friction,
                   mass / np.where(volume > 0.0, volume, 1.0), solver.serial)

    def apply_contact(self, grid, dx):
        """Let bodies that meet push each other apart."""
        for total, rows, part, cut, n in self._groups:
            self._exchange(grid.nodes, grid.contact_offset, grid.contact.neighbours, rows, self._friction,
                           self._density, dx**self._dim, part, total, n, cut)


@functools.cache
def body_contact_kernel(dim, real, flip, serial):
    """Kernel of one kind of pair; rows (n, 4): contact blocks of both, their fields."""
    edge, n_nodes = EDGE[dim], block_nodes(dim)
    of_node = node_vector(real, flip)

    @ti.func
    def mass_of(nodes: ti.template(), contact_offset, c, q):
        mass = ti.cast(0.0, real)
        if c >= 0:
            mass = nodes[contact_offset + c * n_nodes + q][3]
        return mass

    @ti.func
    def mass_gradient(nodes: ti.template(), contact_offset, c, q, neighbours: ti.template()):
        """Twice the difference of the masses of the nodes around, along each axis."""
        gradient = ti.Vector.zero(real, dim)
        for a in ti.static(range(dim)):
            width = edge ** (dim - 1 - a)
            here = q // width % edge
            back = ti.select(here > 0, c, neighbours[c, 2 * a])
            ahead = ti.select(here < edge - 1, c, neighbours[c, 2 * a + 1])
            q_back = ti.select(here > 0, q - width, q + (edge - 1) * width)
            q_ahead = ti.select(here < edge - 1, q + width, q - (edge - 1) * width)
            gradient[a] = mass_of(nodes, contact_offset, ahead, q_ahead) - mass_of(nodes, contact_offset, back, q_back)
        return gradient

    @taichi_kernel
    def exchange_momentum(nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int,
                          neighbours: ti.types.ndarray(), rows: ti.types.ndarray(), friction: ti.types.ndarray(),
                          density: ti.types.ndarray(), cell: real, part: ti.types.ndarray(), total: ti.types.ndarray(),
                          n_pairs: int, cut: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for w in range(chunks(cut)):
            if is_worker(w):
                begin, end = chunk(w, cut)
                for i in range(begin, end):
                    c1, c2 = rows[i, 0], rows[i, 1]
                    mu = ti.cast(friction[rows[i, 2], rows[i, 3]], real)
                    first_density = ti.cast(density[rows[i, 2]], real)
                    second_density = ti.cast(density[rows[i, 3]], real)
                    taken = ti.Vector.zero(ti.f64, 1 + dim)
                    for q in range(n_nodes):
                        one, two = nodes[contact_offset + c1 * n_nodes + q], nodes[contact_offset + c2 * n_nodes + q]
                        m1, m2 = one[3], two[3]
                        if m1 > LEAST_SHARE * cell * first_density and m2 > LEAST_SHARE * cell * second_density:
                            n = -mass_gradient(nodes, contact_offset, c1, q, neighbours) / first_density
                            other = mass_gradient(nodes, contact_offset, c2, q, neighbours) / second_density
                            n = ti.select(other.norm_sqr() > n.norm_sqr(), other, n)
                            n /= ti.max(n.norm(), 1e-30)
                            shared = m1 * m2 / (m1 + m2)
                            apart = ti.Vector([one[a] - two[a] for a in ti.static(range(dim))])
                            approach = apart.dot(n)
                            if approach > 0.0:
                                along = apart - approach * n
                                speed = along.norm()
                                given = approach * n + along * ti.min(1.0, mu * approach / ti.max(speed, 1e-30))
                                after = apart - given
                                # Force times the velocity at the end of the step, as the scheme itself does work
                                taken[0] += ti.cast(shared * given.dot(after), ti.f64)
                                for a in ti.static(range(dim)):
                                    taken[1 + a] += ti.cast(shared * given[a], ti.f64)
                                    one[a] -= shared / m1 * given[a]
                                    two[a] += shared / m2 * given[a]
                                nodes[contact_offset + c1 * n_nodes + q] = one
                                nodes[contact_offset + c2 * n_nodes + q] = two
                    for t in ti.static(range(1 + dim)):
                        part[i, t] = taken[t]
        ti.loop_config(serialize=ti.static(in_order()))
        for i in range(n_pairs):
            for t in ti.static(range(1 + dim)):
                total[t] += part[i, t]

    return exchange_momentum
