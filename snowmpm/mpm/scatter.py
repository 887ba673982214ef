"""Particles to grid: mass, momentum and internal force.

For particle p and node i, with m = rho_0 V, D the second moment of the basis (`stencil`), x_i, x_p in metres, Kirchhoff
stress tau and reference volume V:

    m_i     += w_ip m
    (mv)_i  += w_ip [ m v + m C (x_i - x_p) ] + dt f_ip
    f_ip     = -V tau D^-1 w_ip (x_i - x_p)    gradient "affine": moving least squares (Hu et al. 2018,
                                               doi:10.1145/3197517.3201293, eq. 16-18)
             = -V tau grad w_ip                gradient "shape": the classical form (Sulsky et al. 1995,
                                               doi:10.1016/0010-4655(94)00170-7)

PIC and FLIP leave out m C.
"""

import functools

import taichi as ti

from snowmpm.material_table import DENSITY
from snowmpm.mpm.grid import TILE, tile_strides
from snowmpm.parallel import chunk, chunks, is_worker
from snowmpm.particles import accessors
from snowmpm.stencil import STENCILS


@functools.cache
def scatter_kernel(layout, real, atomic, flip, basis="quadratic", gradient="affine"):
    """Kernel that fills the tiles. atomic: one particle a thread (GPU); else one block a thread, in fixed order (CPU).

    flip: the internal impulse goes to tiles of its own, since FLIP needs the velocity before it.
    basis: name of a stencil; gradient: "affine" or "shape", see above.
    """
    dim, tile_edge = layout.dim, TILE[layout.dim]
    stencil, shape = STENCILS[basis], gradient == "shape"
    width, reach = stencil.width, stencil.reach
    access = accessors(layout)
    at = layout.offsets
    vec4 = ti.types.vector(4, real)
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
    def scatter_particle(p, b, reals: ti.template(), places, material: ti.template(), materials: ti.template(),
                         tiles: ti.template(), impulses: ti.template(), dt, dx, affine_share, n_tiles):
        zero = ti.cast(0.0, real)
        if ti.static(real == ti.f32):
            # A zero the compiler cannot see keeps the four lanes of a node alike: one vector, 15 % faster.
            zero = ti.select(n_tiles < 0, 1.0, 0.0)
        x = access.load(reals, places, p, at["position"], dim)
        base = ti.floor(x - reach, ti.i32)
        f = x - ti.cast(base, float)
        w, dw = stencil.weights(f), ti.Matrix.zero(real, width, dim)
        velocity = access.load(reals, places, p, at["velocity"], dim)
        grad_v = access.load(reals, places, p, at["affine"], dim * dim)
        tau = symmetric_matrix(access.load(reals, places, p, at["stress"], layout.sym_size))
        volume = access.load(reals, places, p, at["volume"], 1)[0]
        mass = volume * materials[material[p], DENSITY]
        internal, pull = (-dt / dx * volume) * tau, ti.Matrix.zero(real, dim, dim)
        if ti.static(shape):
            dw, pull, internal = stencil.slopes(f), internal, pull
        else:
            internal *= stencil.inverse_second_moment
        affine = ti.Matrix.zero(real, dim, dim)
        for i in ti.static(range(dim)):
            for j in ti.static(range(dim)):
                affine[i, j] = affine_share * mass * dx * grad_v[i * dim + j]
        if ti.static(flip):
            scatter_field(impulses, b, base, w, dw, node_vector(-internal @ f, zero), internal, pull, zero,
                          not shape, shape)
        else:
            affine += internal
        scatter_field(tiles, b, base, w, dw, node_vector(mass * velocity - affine @ f, mass), affine, pull, zero,
                      True, shape and not flip)

    @ti.func
    def scatter_field(tiles: ti.template(), b, base, w, dw, corner, slope, pull, zero, linear: ti.template(),
                      pulled: ti.template()):
        """Add to the nodes of a stencil, if linear, the vector w (corner + slope (node - base)) and, if pulled,
        pull grad w."""
        step = [node_vector(slope[:, a], zero) for a in ti.static(range(dim))]
        force = [node_vector(pull[:, a], zero) for a in ti.static(range(dim))]
        address = b * tile_edge**dim
        for a in ti.static(range(dim)):
            address += (base[a] + 1) * stride[a]
        if ti.static(dim == 3):
            for i in ti.static(range(width)):
                scatter_rows(tiles, address + i * stride[0], w, dw, w[i, 0], corner + float(i) * step[0],
                             dw[i, 0] * force[0], step, force, linear, pulled)
        else:
            scatter_rows(tiles, address, w, dw, ti.cast(1.0, real), corner, vec4(0.0), step, force, linear, pulled)

    @ti.func
    def scatter_rows(tiles: ti.template(), address, w, dw, weight, value, tilt, step: ti.template(),
                     force: ti.template(), linear: ti.template(), pulled: ti.template()):
        """The last two axes of `scatter_field`."""
        for j in ti.static(range(width)):
            row_weight = weight * w[j, dim - 2]
            row_value, row_force = value + float(j) * step[dim - 2], vec4(0.0)
            if ti.static(pulled):
                row_pull = w[j, dim - 2] * tilt + (weight * dw[j, dim - 2]) * force[dim - 2]
                row_value = row_pull + row_weight * row_value if ti.static(linear) else row_pull
                row_force = row_weight * force[dim - 1]
            for k in ti.static(range(width)):
                part = vec4(0.0)
                if ti.static(not pulled):
                    part = (row_weight * w[k, dim - 1]) * (row_value + float(k) * step[dim - 1])
                elif ti.static(linear):
                    part = w[k, dim - 1] * (row_value + (float(k) * row_weight) * step[dim - 1])
                    part += dw[k, dim - 1] * row_force
                else:
                    part = w[k, dim - 1] * row_value + dw[k, dim - 1] * row_force
                node = address + j * stride[dim - 2] + k
                if ti.static(atomic):
                    ti.atomic_add(tiles[node], part)
                else:
                    tiles[node] = tiles[node] + part

    @ti.func
    def clear_box(tiles: ti.template(), boxes: ti.template(), b):
        """Set the box of tile b to zero: whole rows of it, since one run of stores is faster than a few short ones."""
        for i in range(boxes[b, 0], boxes[b, 3]):
            start = b * tile_edge**dim + i * plane
            for q in range(start + boxes[b, 1] * tile_edge, start + boxes[b, 4] * tile_edge):
                tiles[q] = vec4(0.0)

    @ti.kernel
    def scatter_blocks(reals: ti.types.ndarray(), turn: int, material: ti.types.ndarray(),
                       materials: ti.types.ndarray(), start: ti.types.ndarray(), boxes: ti.types.ndarray(),
                       tiles: ti.types.ndarray(dtype=vec4, ndim=1), impulses: ti.types.ndarray(dtype=vec4, ndim=1),
                       dt: real, dx: real, affine_share: real, n_tiles: int, shares: ti.types.ndarray()):
        for i in range(chunks(shares)):
            if is_worker(i):
                first, last = chunk(i, shares)
                places = access.places(reals, turn)
                for b in range(first, last):
                    clear_box(tiles, boxes, b)
                    if ti.static(flip):
                        clear_box(impulses, boxes, b)
                    for p in range(start[b], start[b + 1]):
                        scatter_particle(p, b, reals, places, material, materials, tiles, impulses, dt, dx,
                                         affine_share, n_tiles)

    @ti.kernel
    def scatter_atomic(reals: ti.types.ndarray(), turn: int, material: ti.types.ndarray(),
                       materials: ti.types.ndarray(), block_of: ti.types.ndarray(), boxes: ti.types.ndarray(),
                       tiles: ti.types.ndarray(dtype=vec4, ndim=1), impulses: ti.types.ndarray(dtype=vec4, ndim=1),
                       dt: real, dx: real, affine_share: real, n_tiles: int, count: int):
        for q in range(n_tiles * tile_edge**dim):
            tiles[q] = vec4(0.0)
            if ti.static(flip):
                impulses[q] = vec4(0.0)
        for p in range(count):
            scatter_particle(p, block_of[p], reals, access.places(reals, turn), material, materials, tiles, impulses,
                             dt, dx, affine_share, n_tiles)

    return scatter_atomic if atomic else scatter_blocks
