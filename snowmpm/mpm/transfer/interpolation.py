"""Grid values at a particle: the sums over its stencil that a gather needs.

Weights are products, w = w_i w_j w_k. With the sums of w v over planes of the stencil, each without its own weight,

    v_i = sum_jk w_j w_k v_ijk,   v_j = sum_ik w_i w_k v_ijk,   v_k = sum_ij w_i w_j v_ijk

the moment of w v along an axis is sum_k k w_k v_k and its sum with the slopes of the weights sum_k dw_k v_k: a node
costs two multiply-adds a number, whatever is wanted of it. Moments alone cost less: numbers that are added up from the
last one on leave partial sums on the way, and these add up to the moment.
"""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import node_vector
from snowmpm.mpm.transfer.stencil import STENCILS


@functools.cache
def interpolation(dim, real, basis, moving, sloping, flip):
    """Taichi functions of a basis. moving: the first moments of the velocity are wanted, from which the affine matrix C
    follows; sloping: its sums with the slopes of the weights, which give grad v; flip: of nodes with a second half."""
    stencil, tile_edge = STENCILS[basis], TILE[dim]
    width = stencil.width
    of_node = node_vector(real, flip)
    stride = [tile_edge ** (dim - 1 - a) for a in range(dim)]

    @ti.func
    def locate(x, b):
        """Where in the tiles the stencil of a particle of block b starts, its f, weights w and their slopes."""
        base = ti.floor(x - stencil.reach, ti.i32)
        f = x - ti.cast(base, float)
        w, dw = stencil.weights(f), ti.Matrix.zero(real, width, dim)
        if ti.static(sloping):
            dw = stencil.slopes(f)
        address = b * tile_edge**dim
        for a in ti.static(range(dim)):
            address += (base[a] + 1) * stride[a]
        return address, f, w, dw

    @ti.func
    def interpolate(tiles: ti.template(), address, w, dw):
        """Sums of w v, the first moments and the slopes: one row for each axis, a node's vector long."""
        v = of_node(0.0)
        moments, slopes = [of_node(0.0) for _ in ti.static(range(dim))], [of_node(0.0) for _ in ti.static(range(dim))]
        if ti.static(dim == 2 and moving and not sloping):
            v, moments[0], moments[1] = moments_of_plane(tiles, address, w)
        else:
            v = add_planes(tiles, address, w, dw, moments, slopes)
        return v, ti.Matrix.rows(moments), ti.Matrix.rows(slopes)

    @ti.func
    def moments_of_plane(tiles: ti.template(), address, w):
        """Sum over the last two axes, and its moments along them; in 3-D rows and columns of a plane together fill a
        register, and are as fast."""
        columns, along = [of_node(0.0) for _ in ti.static(range(width))], of_node(0.0)
        for k in ti.static(range(width)):
            column, moment = sum_and_moment([w[j, dim - 2] * tiles[address + j * stride[dim - 2] + k]
                                             for j in ti.static(range(width))])
            columns[k] = w[k, dim - 1] * column
            along += w[k, dim - 1] * moment
        total, across = sum_and_moment(columns)
        return total, along, across

    @ti.func
    def sum_and_moment(parts: ti.template()):
        """sum_k p_k and sum_k k p_k."""
        later = parts[width - 1]
        moment = later
        for k in ti.static(range(width - 2, 0, -1)):
            later += parts[k]
            moment += later
        return parts[0] + later, moment

    @ti.func
    def add_planes(tiles: ti.template(), address, w, dw, moments: ti.template(), slopes: ti.template()):
        """Sum of w v, and what else is wanted."""
        v = of_node(0.0)
        rows, columns = [of_node(0.0) for _ in ti.static(range(width))], [of_node(0.0) for _ in ti.static(range(width))]
        if ti.static(dim == 3):
            for i in ti.static(range(width)):
                plane = add_plane(tiles, address + i * stride[0], w, w[i, 0], rows, columns)
                v += w[i, 0] * plane
                add_axis(moments, slopes, 0, i, plane, w, dw)
        else:
            v = add_plane(tiles, address, w, ti.cast(1.0, real), rows, columns)
        for k in ti.static(range(width)):
            add_axis(moments, slopes, dim - 2, k, rows[k], w, dw)
            add_axis(moments, slopes, dim - 1, k, columns[k], w, dw)
        return v

    @ti.func
    def add_axis(moments: ti.template(), slopes: ti.template(), a: ti.template(), k: ti.template(), part, w, dw):
        """Add plane k along axis a, whose sum is `part`."""
        if ti.static(moving and k > 0):
            moments[a] += (float(k) * w[k, a]) * part
        if ti.static(sloping):
            slopes[a] += dw[k, a] * part

    @ti.func
    def add_plane(tiles: ti.template(), address, w, weight, rows: ti.template(), columns: ti.template()):
        """Sum over the last two axes, and what it adds to v_j (`rows`) and v_k (`columns`); weight: along the first."""
        total = of_node(0.0)
        for j in ti.static(range(width)):
            row, row_weight = of_node(0.0), weight * w[j, dim - 2]
            for k in ti.static(range(width)):
                node = tiles[address + j * stride[dim - 2] + k]
                row += w[k, dim - 1] * node
                columns[k] += row_weight * node
            total += w[j, dim - 2] * row
            rows[j] += weight * row
        return total

    @ti.func
    def gradients(f, v, moments, slopes, inverse_dx):
        """Affine matrix C and grad v [1/s] of sums [axis, component]; each is the other where only one is wanted."""
        C, L = ti.Matrix.zero(real, dim, dim), ti.Matrix.zero(real, dim, dim)
        for i in ti.static(range(dim)):
            for a in ti.static(range(dim)):
                if ti.static(moving):
                    C[i, a] = (stencil.inverse_second_moment * inverse_dx) * (moments[a, i] - f[a] * v[i])
                if ti.static(sloping):
                    L[i, a] = inverse_dx * slopes[a, i]
        if ti.static(not sloping):
            L = C
        if ti.static(not moving):
            C = L
        return C, L

    return SimpleNamespace(of_node=of_node, locate=locate, interpolate=interpolate, gradients=gradients)
