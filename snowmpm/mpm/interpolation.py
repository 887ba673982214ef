"""Grid values at a particle: the sums over its stencil that a gather needs."""

import functools
from types import SimpleNamespace

import taichi as ti

from snowmpm.mpm.grid import TILE
from snowmpm.stencil import STENCILS


@functools.cache
def interpolation(dim, real, basis, moving, sloping):
    """Taichi functions of a basis. moving: the first moments of the velocity are wanted, from which the affine matrix C
    follows; sloping: its sums with the slopes of the weights, which give grad v."""
    stencil, tile_edge = STENCILS[basis], TILE[dim]
    width = stencil.width
    vec4 = ti.types.vector(4, real)
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
    def interpolate(tiles: ti.template(), address, w, dw, more: ti.template()):
        """Sums of w v, and if `more` the first moments and the slopes: one row for each axis, a node's vector long."""
        v = vec4(0.0)
        moments, slopes = [vec4(0.0) for _ in ti.static(range(dim))], [vec4(0.0) for _ in ti.static(range(dim))]
        if ti.static(dim == 3):
            for i in ti.static(range(width)):
                plane, plane_moments, plane_slopes = sum_rows(tiles, address + i * stride[0], w, dw, more)
                v += w[i, 0] * plane
                if ti.static(moving and more):
                    moments[0] += (float(i) * w[i, 0]) * plane
                    moments[1] += w[i, 0] * plane_moments[0, :]
                    moments[2] += w[i, 0] * plane_moments[1, :]
                if ti.static(sloping and more):
                    slopes[0] += dw[i, 0] * plane
                    slopes[1] += w[i, 0] * plane_slopes[0, :]
                    slopes[2] += w[i, 0] * plane_slopes[1, :]
        else:
            v, plane_moments, plane_slopes = sum_rows(tiles, address, w, dw, more)
            for a in ti.static(range(dim)):
                moments[a], slopes[a] = plane_moments[a, :], plane_slopes[a, :]
        return v, ti.Matrix.rows(moments), ti.Matrix.rows(slopes)

    @ti.func
    def sum_rows(tiles: ti.template(), address, w, dw, more: ti.template()):
        """Over the last two axes of a stencil: sum of w v, its two first moments, and the sums with the slopes of w."""
        total = vec4(0.0)
        moments, slopes = [vec4(0.0), vec4(0.0)], [vec4(0.0), vec4(0.0)]
        for j in ti.static(range(width)):
            row, moment, slope = vec4(0.0), vec4(0.0), vec4(0.0)
            for k in ti.static(range(width)):
                node = tiles[address + j * stride[dim - 2] + k]
                row += w[k, dim - 1] * node
                if ti.static(moving and more and k > 0):
                    moment += (float(k) * w[k, dim - 1]) * node
                if ti.static(sloping and more):
                    slope += dw[k, dim - 1] * node
            total += w[j, dim - 2] * row
            if ti.static(moving and more):
                moments[0] += (float(j) * w[j, dim - 2]) * row
                moments[1] += w[j, dim - 2] * moment
            if ti.static(sloping and more):
                slopes[0] += dw[j, dim - 2] * row
                slopes[1] += w[j, dim - 2] * slope
        return total, ti.Matrix.rows(moments), ti.Matrix.rows(slopes)

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

    return SimpleNamespace(locate=locate, interpolate=interpolate, gradients=gradients)
