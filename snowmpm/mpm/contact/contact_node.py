"""How contact gives nodes of the grid a velocity, and books what the solid gave them."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.mpm.node import MASS, block_nodes
from snowmpm.particles.blocks import EDGE

N_TOTALS = {2: 5, 3: 8}
"""What a surface gave the snow: impulse, minus work, moment about the reference point, minus the work of the solid."""


@functools.cache
def node_functions(dim, real, moving):
    """Taichi functions of nodes of the contact blocks.

    moving: the solid moves as `motion` says: velocity, angular velocity, reference point (three numbers each; in 2-D
    the angular velocity is the last of its three), lengths in cells; moments are added up too.
    """
    edge, stride = EDGE[dim], block_nodes(dim)
    n_totals = N_TOTALS[dim]

    @ti.func
    def as_vector(node):
        return ti.Vector([node[a] for a in ti.static(range(dim))])

    @ti.func
    def offset(place, coordinates: ti.template(), motion: ti.template()):
        """From the reference point to a node [cells]."""
        x, c, q = ti.Vector.zero(real, dim), place // stride, place % stride
        for a in ti.static(range(dim)):
            i = q // ti.static(edge ** (dim - 1 - a)) % edge
            x[a] = ti.cast(ti.cast(edge * coordinates[c, a] + i, ti.f64) - motion[6 + a], real)
        return x

    @ti.func
    def solid_velocity(place, coordinates: ti.template(), motion: ti.template(), dx):
        """Velocity of the solid at a node [m/s]."""
        v = ti.Vector.zero(real, dim)
        if ti.static(moving):
            x = offset(place, coordinates, motion) * dx
            if ti.static(dim == 2):
                w = ti.cast(motion[5], real)
                v = ti.Vector([ti.cast(motion[0], real) - w * x[1], ti.cast(motion[1], real) + w * x[0]])
            else:
                w = ti.Vector([ti.cast(motion[3 + a], real) for a in ti.static(range(3))])
                v = ti.Vector([ti.cast(motion[a], real) for a in ti.static(range(3))]) + w.cross(x)
        return v

    @ti.func
    def set_velocity(nodes: ti.template(), contact_offset, place, u, solid, totals: ti.template(),
                     coordinates: ti.template(), motion: ti.template()):
        """Give a node the velocity u relative to the solid; add what it gained to the totals."""
        node = nodes[contact_offset + place]
        before, mass = as_vector(node), node[MASS]
        after = u + solid
        J = mass * (after - before)
        for a in ti.static(range(dim)):
            totals[a] += ti.cast(J[a], ti.f64)
        # Force times the velocity at the end of the step, as the scheme itself does work
        totals[dim] -= ti.cast(J.dot(after), ti.f64)
        if ti.static(moving):
            x = offset(place, coordinates, motion)
            if ti.static(dim == 2):
                totals[3] += ti.cast(x[0] * J[1] - x[1] * J[0], ti.f64)
            else:
                moment = x.cross(J)
                for a in ti.static(range(3)):
                    totals[4 + a] += ti.cast(moment[a], ti.f64)
            totals[n_totals - 1] -= ti.cast(J.dot(solid), ti.f64)
        for a in ti.static(range(dim)):
            node[a] = after[a]
        nodes[contact_offset + place] = node

    return SimpleNamespace(as_vector=as_vector, solid_velocity=solid_velocity, set_velocity=set_velocity)
