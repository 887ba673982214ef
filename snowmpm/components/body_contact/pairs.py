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
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker
from snowmpm.compiler.runtime import DTYPES
from snowmpm.mpm.kernel_api import FieldPairs, block_nodes
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
            self._exchange(FieldNodes(grid.nodes, grid.contact_offset, grid.contact.neighbours),
                           Pairs(rows, self._friction, self._density, n, cut), dx**self._dim, part, total)


class FieldNodes(NamedTuple):
    """Nodes, of which those of the contact blocks begin at offset, and neighbours of the blocks."""

    nodes: Array
    offset: int
    neighbours: Array


class Pairs(NamedTuple):
    """rows (n, 4): contact blocks of both, their fields; mu of each pair of fields, density of each; number of pairs,
    their chunks."""

    rows: Array
    friction: Array
    density: Array
    n: int
    cut: Array


@functools.cache
def body_contact_kernel(dim, real, flip, serial):
    """Kernel of one kind of pair."""
    edge, n_nodes = EDGE[dim], block_nodes(dim)

    @ti.func
    def mass_of(at: ti.template(), c, q):
        mass = ti.cast(0.0, real)
        if c >= 0:
            mass = at.nodes[at.offset + c * n_nodes + q][3]
        return mass

    @ti.func
    def mass_gradient(at: ti.template(), c, q):
        """Twice the difference of the masses of the nodes around, along each axis."""
        gradient = ti.Vector.zero(real, dim)
        for a in ti.static(range(dim)):
            width = edge ** (dim - 1 - a)
            here = q // width % edge
            back = ti.select(here > 0, c, at.neighbours[c, 2 * a])
            ahead = ti.select(here < edge - 1, c, at.neighbours[c, 2 * a + 1])
            q_back = ti.select(here > 0, q - width, q + (edge - 1) * width)
            q_ahead = ti.select(here < edge - 1, q + width, q - (edge - 1) * width)
            gradient[a] = mass_of(at, ahead, q_ahead) - mass_of(at, back, q_back)
        return gradient

    @grouped_kernel(real)
    def exchange_momentum(at: FieldNodes, pairs: Pairs, cell: Real, part: Array, total: Array):
        ti.loop_config(serialize=ti.static(serial))
        for w in range(chunks(pairs.cut)):
            if is_worker(w):
                begin, end = chunk(w, pairs.cut)
                for i in range(begin, end):
                    c1, c2, first, second = pairs.rows[i, 0], pairs.rows[i, 1], pairs.rows[i, 2], pairs.rows[i, 3]
                    mu = ti.cast(pairs.friction[first, second], real)
                    first_density = ti.cast(pairs.density[first], real)
                    second_density = ti.cast(pairs.density[second], real)
                    taken = ti.Vector.zero(ti.f64, 1 + dim)
                    for q in range(n_nodes):
                        one = at.nodes[at.offset + c1 * n_nodes + q]
                        two = at.nodes[at.offset + c2 * n_nodes + q]
                        m1, m2 = one[3], two[3]
                        if m1 > LEAST_SHARE * cell * first_density and m2 > LEAST_SHARE * cell * second_density:
                            n = -mass_gradient(at, c1, q) / first_density
                            other = mass_gradient(at, c2, q) / second_density
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
                                at.nodes[at.offset + c1 * n_nodes + q] = one
                                at.nodes[at.offset + c2 * n_nodes + q] = two
                    for t in ti.static(range(1 + dim)):
                        part[i, t] = taken[t]
        ti.loop_config(serialize=ti.static(in_order()))
        for i in range(pairs.n):
            for t in ti.static(range(1 + dim)):
                total[t] += part[i, t]

    return exchange_momentum
