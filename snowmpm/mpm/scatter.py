"""Particles to grid: mass, momentum and internal force in the moving-least-squares form.

For particle p and node i, with m = rho_0 V, D^-1 = 4 / dx^2 and x_i, x_p in metres (Hu et al. 2018,
doi:10.1145/3197517.3201293, eq. 16-18; Kirchhoff stress tau, reference volume V):

    m_i     += w_ip m
    (mv)_i  += w_ip [ m v + (m C - dt D^-1 V tau) (x_i - x_p) ]

PIC and FLIP leave out m C.
"""

import functools

import taichi as ti

from snowmpm.material_table import DENSITY
from snowmpm.mpm.grid import TILE, tile_strides
from snowmpm.parallel import chunk, chunks, is_worker
from snowmpm.particles import MATERIAL, accessors
from snowmpm.stencil import INVERSE_SECOND_MOMENT, WIDTH, quadratic_stencil


@functools.cache
def scatter_kernel(layout, real, atomic, flip):
    """Kernel that fills the tiles. atomic: one particle a thread (GPU); else one block a thread, in fixed order (CPU).

    flip: the internal impulse goes to tiles of its own, since FLIP needs the velocity before it.
    """
    dim, tile_edge = layout.dim, TILE[layout.dim]
    load, _ = accessors(layout)
    at = layout.offsets
    vec4 = ti.types.vector(4, real)
    rows = [()] if dim == 1 else [(i,) for i in range(WIDTH)]
    if dim == 3:
        rows = [(i, j) for i in range(WIDTH) for j in range(WIDTH)]
    stride = tile_strides(dim)[3 - dim:]
    plane = tile_strides(dim)[0]

    @ti.func
    def symmetric_matrix(s):
        """dim x dim block of a symmetric tensor stored as xx, yy, zz, xy[, yz, xz]."""
        if ti.static(dim == 2):
            return ti.Matrix([[s[0], s[3]], [s[3], s[1]]])
        else:
            return ti.Matrix([[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]])

    @ti.func
    def node_vector(momentum, mass):
        result = vec4(0.0)
        for a in ti.static(range(dim)):
            result[a] = momentum[a]
        result[3] = mass
        return result

    @ti.func
    def scatter_particle(p, b, reals: ti.template(), integers: ti.template(), materials: ti.template(),
                         tiles: ti.template(), impulses: ti.template(), dt, dx, affine_share, n_tiles):
        zero = ti.cast(0.0, real)
        if ti.static(real == ti.f32):
            # A zero the compiler cannot see keeps the four lanes of a node alike: one vector, 15 % faster.
            zero = ti.select(n_tiles < 0, 1.0, 0.0)
        base, f, w = quadratic_stencil(load(reals, p, at["position"], dim))
        velocity = load(reals, p, at["velocity"], dim)
        grad_v = load(reals, p, at["affine"], dim * dim)
        tau = symmetric_matrix(load(reals, p, at["stress"], layout.sym_size))
        volume = load(reals, p, at["volume"], 1)[0]
        mass = volume * materials[integers[p, MATERIAL], DENSITY]
        internal = ((-dt * INVERSE_SECOND_MOMENT / dx) * volume) * tau
        affine = ti.Matrix.zero(real, dim, dim)
        for i in ti.static(range(dim)):
            for j in ti.static(range(dim)):
                affine[i, j] = affine_share * mass * dx * grad_v[i * dim + j]
        if ti.static(flip):
            scatter_linear(impulses, b, base, w, node_vector(-internal @ f, zero), internal, zero)
        else:
            affine += internal
        scatter_linear(tiles, b, base, w, node_vector(mass * velocity - affine @ f, mass), affine, zero)

    @ti.func
    def scatter_linear(tiles: ti.template(), b, base, w, corner, slope, zero):
        """Add to the nodes of a stencil a weighted vector that is linear in the node: corner + slope (node - base)."""
        step = [node_vector(slope[:, a], zero) for a in ti.static(range(dim))]
        address = b * tile_edge**dim
        for a in ti.static(range(dim)):
            address += (base[a] + 1) * stride[a]
        for row in ti.static(rows):
            value, weight, start = corner, ti.cast(1.0, real), address
            for a in ti.static(range(dim - 1)):
                value += float(row[a]) * step[a]
                weight *= w[row[a], a]
                start += row[a] * stride[a]
            for k in ti.static(range(WIDTH)):
                part = (weight * w[k, dim - 1]) * (value + float(k) * step[dim - 1])
                if ti.static(atomic):
                    ti.atomic_add(tiles[start + k], part)
                else:
                    tiles[start + k] = tiles[start + k] + part

    @ti.func
    def clear_box(tiles: ti.template(), boxes: ti.template(), b):
        """Set the box of tile b to zero: whole rows of it, since one run of stores is faster than a few short ones."""
        for i in range(boxes[b, 0], boxes[b, 3]):
            start = b * tile_edge**dim + i * plane
            for q in range(start + boxes[b, 1] * tile_edge, start + boxes[b, 4] * tile_edge):
                tiles[q] = vec4(0.0)

    @ti.kernel
    def scatter_blocks(reals: ti.types.ndarray(), integers: ti.types.ndarray(), materials: ti.types.ndarray(),
                       start: ti.types.ndarray(), boxes: ti.types.ndarray(),
                       tiles: ti.types.ndarray(dtype=vec4, ndim=1), impulses: ti.types.ndarray(dtype=vec4, ndim=1),
                       dt: real, dx: real, affine_share: real, n_tiles: int, shares: ti.types.ndarray()):
        for i in range(chunks(shares)):
            if is_worker(i):
                first, last = chunk(i, shares)
                for b in range(first, last):
                    clear_box(tiles, boxes, b)
                    if ti.static(flip):
                        clear_box(impulses, boxes, b)
                    for p in range(start[b], start[b + 1]):
                        scatter_particle(p, b, reals, integers, materials, tiles, impulses, dt, dx, affine_share,
                                         n_tiles)

    @ti.kernel
    def scatter_atomic(reals: ti.types.ndarray(), integers: ti.types.ndarray(), materials: ti.types.ndarray(),
                       block_of: ti.types.ndarray(), boxes: ti.types.ndarray(),
                       tiles: ti.types.ndarray(dtype=vec4, ndim=1), impulses: ti.types.ndarray(dtype=vec4, ndim=1),
                       dt: real, dx: real, affine_share: real, n_tiles: int, count: int):
        for q in range(n_tiles * tile_edge**dim):
            tiles[q] = vec4(0.0)
            if ti.static(flip):
                impulses[q] = vec4(0.0)
        for p in range(count):
            scatter_particle(p, block_of[p], reals, integers, materials, tiles, impulses, dt, dx, affine_share,
                             n_tiles)

    return scatter_atomic if atomic else scatter_blocks
