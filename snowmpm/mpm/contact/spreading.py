"""What a particle gives to the nodes of its stencil: products of its weights with a few vectors.

Weights are products, w = w_i w_j w_k. So what a node gets of a field,

    w q + sum_a [ w k_a s_a + dw/dx_a g_a ]        k_a: number of the node along axis a, from the base of the stencil

(q: value at the base, s_a: its slope along a, g_a: what goes by the slopes of the weights) is with one u an axis

    w_i w_j w_k q + u_i w_j w_k + w_i u_j w_k + w_i w_j u_k,     u_k = w_k k s_a + dw_k g_a

These vectors are few, 9 of a quadratic stencil in 3-D (u_i takes q up). With them a node costs two multiply-adds a
number, by whichever gradient.
"""

import functools
from types import SimpleNamespace

import taichi as ti

from snowmpm.mpm.grid import TILE
from snowmpm.mpm.transfer.stencil import STENCILS


@functools.cache
def spreading(dim, real, basis, gradient, flip, affine, atomic):
    """Taichi functions of a scatter, and its fields, which they take by number, with how many vectors each has.

    Field 0 is mass, momentum and, but for flip, internal impulse; with flip this is field 1. affine: C counts.
    """
    stencil, shape = STENCILS[basis], gradient == "shape"
    width = stencil.width
    vec4 = ti.types.vector(4, real)
    stride = [TILE[dim] ** (dim - 1 - a) for a in range(dim)]
    pulled = [not flip, True][: 1 + flip]  # fields with the internal impulse
    sloped = [affine or not flip, True][: 1 + flip]  # fields with u
    n_vectors = [width * dim * u + (dim == 2 or not u) for u in sloped]

    @ti.func
    def prepare(field: ti.template(), vectors: ti.template(), lane: ti.template(), f, w, dw, mass, velocity, C,
                impulse):
        """Write the vectors of a particle: u along each axis, q where none took it up; vectors[n][4 lane + 0 .. 3].

        C: affine matrix times dx [m/s]; impulse: internal one, -dt V tau / dx [N s].
        """
        s, g = ti.Matrix.zero(real, dim, dim), ti.Matrix.zero(real, dim, dim)
        if ti.static(field == 0 and affine):
            s += mass * C
        if ti.static(pulled[field] and shape):
            g += impulse
        if ti.static(pulled[field] and not shape):
            s += stencil.inverse_second_moment * impulse
        q, heavy = -(s @ f), ti.cast(0.0, real)
        if ti.static(field == 0):
            q += mass * velocity
            heavy = mass
        if ti.static(sloped[field]):
            for a in ti.static(range(dim)):
                for k in ti.static(range(width)):
                    u, taken = (float(k) * w[k, a]) * s[:, a] + dw[k, a] * g[:, a], ti.cast(0.0, real)
                    if ti.static(dim == 3 and a == 0):
                        u += w[k, 0] * q
                        taken = w[k, 0] * heavy
                    write(vectors, a * width + k, lane, u, taken)
        if ti.static(dim == 2 or not sloped[field]):
            write(vectors, n_vectors[field] - 1, lane, q, heavy)

    @ti.func
    def write(vectors: ti.template(), n: ti.template(), lane: ti.template(), momentum, mass):
        for c in ti.static(range(3)):
            vectors[n][4 * lane + c] = momentum[c] if ti.static(c < dim) else 0.0
        vectors[n][4 * lane + 3] = mass

    @ti.func
    def read(vectors: ti.template(), n: ti.template(), lane: ti.template()):
        return vec4([vectors[n][4 * lane + c] for c in ti.static(range(4))])

    @ti.func
    def spread(field: ti.template(), tiles: ti.template(), address, w, vectors: ti.template(), lane: ti.template()):
        """Add a particle's part to the nodes of its stencil, which starts at `address`."""
        if ti.static(dim == 3):
            for i in ti.static(range(width)):
                value = vec4(0.0)
                if ti.static(sloped[field]):
                    value = read(vectors, i, lane)
                else:
                    value = w[i, 0] * read(vectors, 0, lane)
                spread_plane(field, tiles, address + i * stride[0], w, w[i, 0], value, vectors, lane)
        else:
            value = read(vectors, n_vectors[field] - 1, lane)
            spread_plane(field, tiles, address, w, ti.cast(1.0, real), value, vectors, lane)

    @ti.func
    def spread_plane(field: ti.template(), tiles: ti.template(), address, w, weight, value, vectors: ti.template(),
                     lane: ti.template()):
        """The last two axes, of weight `weight` along the first one."""
        for j in ti.static(range(width)):
            row, row_weight = w[j, dim - 2] * value, weight * w[j, dim - 2]
            if ti.static(sloped[field]):
                row += weight * read(vectors, (dim - 2) * width + j, lane)
            for k in ti.static(range(width)):
                part = w[k, dim - 1] * row
                if ti.static(sloped[field]):
                    part += row_weight * read(vectors, (dim - 1) * width + k, lane)
                node = address + j * stride[dim - 2] + k
                if ti.static(atomic):
                    ti.atomic_add(tiles[node], part)
                else:
                    tiles[node] = tiles[node] + part

    return SimpleNamespace(fields=tuple(enumerate(n_vectors)), prepare=prepare, spread=spread)
