"""How nodes behind a smooth wall move that hardly any snow tells: as their line does.

One particle cannot tell how a node behind the wall moves along it, and its own stress would be off by a third of the
pressure. So nodes that less than a hundredth of their leader's mass moves have the tangential velocity that is linear
along their line through the leader and the node above it, which share their momentum: least squares, as in the rest of
contact (extended B-splines: Hoellig, Reif & Wipper 2001, doi:10.1137/S0036142900373208).
"""

import functools

from snowmpm.compiler import ti
from snowmpm.mpm.contact.contact_node import node_functions
from snowmpm.mpm.contact.lines import REACH

FAINT = 0.01
"""Mass of a node over its leader's below which it moves as its line does."""


@functools.cache
def extension_function(dim, real, kernel):
    """Taichi function that gives the faint followers of a line of `JoinedLines` their tangential velocity."""
    node, rows = node_functions(dim, real, False), REACH[kernel] + 1
    ABOVE = rows

    @ti.func
    def tangential(nodes: ti.template(), place, v, n):
        """Give a node the tangential part of v."""
        before, result = node.as_vector(nodes[place]), nodes[place]
        change = v - before
        change -= change.dot(n) * n
        for a in ti.static(range(dim)):
            result[a] += change[a]
        nodes[place] = result

    @ti.func
    def extend(i, nodes: ti.template(), contact_offset, ints: ti.template(), n):
        """Give followers with hardly any mass the tangential velocity of their line."""
        leader, above = contact_offset + ints[i, 0], ints[i, ABOVE]
        if above >= 0:
            above += contact_offset
            m_l, m_a = nodes[leader][3], nodes[above][3]
            if m_l > 0.0 and m_a > 0.5 * m_l:
                limit, found = FAINT * m_l, 0
                b_l, b_a = m_l * node.as_vector(nodes[leader]), m_a * node.as_vector(nodes[above])
                A_ll, A_la, A_aa = m_l, m_l * 0.0, m_a
                for j in ti.static(range(1, rows)):
                    if ints[i, j] >= 0:
                        at = nodes[contact_offset + ints[i, j]]
                        if at[3] > 0.0 and at[3] < limit:
                            found = 1
                            p = at[3] * node.as_vector(at)
                            b_l += (1.0 + j) * p
                            b_a -= float(j) * p
                            A_ll += (1.0 + j) ** 2 * at[3]
                            A_la -= (1.0 + j) * j * at[3]
                            A_aa += float(j * j) * at[3]
                if found == 1:
                    determinant = A_ll * A_aa - A_la * A_la
                    new_l = (A_aa * b_l - A_la * b_a) / determinant
                    new_a = (A_ll * b_a - A_la * b_l) / determinant
                    for j in ti.static(range(1, rows)):
                        if ints[i, j] >= 0:
                            at = nodes[contact_offset + ints[i, j]]
                            if at[3] > 0.0 and at[3] < limit:
                                tangential(nodes, contact_offset + ints[i, j], (1.0 + j) * new_l - float(j) * new_a, n)
                    tangential(nodes, leader, new_l, n)
                    tangential(nodes, above, new_a, n)

    return extend
