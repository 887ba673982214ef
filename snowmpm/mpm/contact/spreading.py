"""What a particle gives to the nodes of its stencil: products of its weights with a few vectors.

Weights are products, w = w_i w_j w_k. So what a node gets of a field,

    w q + sum_a [ w k_a s_a + dw/dx_a g_a ]        k_a: number of the node along axis a, from the base of the stencil

(q: value at the base, s_a: its slope along a, g_a: what goes by the slopes of the weights) is with one u an axis

    w_i w_j w_k q + u_i w_j w_k + w_i u_j w_k + w_i w_j u_k,     u_k = w_k k s_a + dw_k g_a

These vectors are few, 9 of a quadratic stencil in 3-D (u_i takes q up). With them a node costs two multiply-adds a
number, by whichever gradient. A vector has the numbers of a node (`mpm.node`); with FLIP what belongs to the internal
impulse is in its second half.
"""

import functools
from types import SimpleNamespace
from typing import Any, NamedTuple

from snowmpm.compiler import ti
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import SECOND, node_size
from snowmpm.mpm.transfer.stencil import STENCILS


class Given(NamedTuple):
    """What a particle gives, within a kernel: mass [kg]; velocity [m/s]; C: affine matrix times dx [m/s]; impulse:
    internal one, -dt V tau / dx [N s]; pull (dim,) [N s]: one that goes by the weights alone; beside: to the spare
    number of the nodes."""

    mass: Any
    velocity: Any
    C: Any
    impulse: Any
    pull: Any
    beside: Any


@functools.cache
def spreading(dim, real, basis, gradient, flip, affine, atomic, pulls=False):
    """Taichi functions of a scatter, and how many vectors they need. affine: C counts; pulls: a component gives
    impulses by the weights alone."""
    stencil, shape = STENCILS[basis], gradient == "shape"
    width = stencil.width
    size = node_size(flip)
    of_node = ti.types.vector(size, real)
    stride = [TILE[dim] ** (dim - 1 - a) for a in range(dim)]
    pulled = 1 if flip else 0  # the half with the internal impulse
    n_vectors = width * dim + (dim == 2)

    @ti.func
    def prepare(vectors: ti.template(), lane: ti.template(), f, w, dw, given: ti.template()):
        """Write the vectors of a particle, of what is `Given`: u along each axis, q where none took it up, `size`
        numbers a lane."""
        for half in ti.static(range(size // SECOND)):
            s, g = ti.Matrix.zero(real, dim, dim), ti.Matrix.zero(real, dim, dim)
            if ti.static(half == 0 and affine):
                s += given.mass * given.C
            if ti.static(half == pulled and shape):
                g += given.impulse
            if ti.static(half == pulled and not shape):
                s += stencil.inverse_second_moment * given.impulse
            q, heavy = -(s @ f), ti.cast(0.0, real)
            if ti.static(half == 0):
                q += given.mass * given.velocity
                heavy = given.mass
            else:
                heavy = given.beside
            if ti.static(half == pulled and pulls):
                q += given.pull
            for a in ti.static(range(dim)):
                for k in ti.static(range(width)):
                    u, taken = (float(k) * w[k, a]) * s[:, a] + dw[k, a] * g[:, a], ti.cast(0.0, real)
                    if ti.static(dim == 3 and a == 0):
                        u += w[k, 0] * q
                        taken = w[k, 0] * heavy
                    write(vectors, a * width + k, lane, half, u, taken)
            if ti.static(dim == 2):
                write(vectors, n_vectors - 1, lane, half, q, heavy)

    @ti.func
    def write(vectors: ti.template(), n: ti.template(), lane: ti.template(), half: ti.template(), momentum, mass):
        for c in ti.static(range(3)):
            vectors[n][size * lane + ti.static(SECOND * half + c)] = momentum[c] if ti.static(c < dim) else 0.0
        vectors[n][size * lane + ti.static(SECOND * half + 3)] = mass

    @ti.func
    def read(vectors: ti.template(), n: ti.template(), lane: ti.template()):
        return of_node([vectors[n][size * lane + c] for c in ti.static(range(size))])

    @ti.func
    def spread(tiles: ti.template(), address, w, vectors: ti.template(), lane: ti.template()):
        """Add a particle's part to the nodes of its stencil, which starts at `address`."""
        if ti.static(dim == 3):
            for i in ti.static(range(width)):
                value = read(vectors, i, lane)
                spread_plane(tiles, address + i * stride[0], w, w[i, 0], value, vectors, lane)
        else:
            value = read(vectors, n_vectors - 1, lane)
            spread_plane(tiles, address, w, ti.cast(1.0, real), value, vectors, lane)

    @ti.func
    def spread_plane(tiles: ti.template(), address, w, weight, value, vectors: ti.template(), lane: ti.template()):
        """The last two axes, of weight `weight` along the first one."""
        for j in ti.static(range(width)):
            row, row_weight = w[j, dim - 2] * value, weight * w[j, dim - 2]
            row += weight * read(vectors, (dim - 2) * width + j, lane)
            for k in ti.static(range(width)):
                part = w[k, dim - 1] * row
                part += row_weight * read(vectors, (dim - 1) * width + k, lane)
                node = address + j * stride[dim - 2] + k
                if ti.static(atomic):
                    ti.atomic_add(tiles[node], part)
                else:
                    tiles[node] = tiles[node] + part

    return SimpleNamespace(n_vectors=n_vectors, prepare=prepare, spread=spread)
