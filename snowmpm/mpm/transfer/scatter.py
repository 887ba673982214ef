"""Particles to grid: mass, momentum and internal force.

For particle p and node i, with m = rho_0 V, D the second moment of the basis (`stencil`), x_i, x_p in metres, Kirchhoff
stress tau and reference volume V:

    m_i     += w_ip m
    (mv)_i  += w_ip [ m v + m C (x_i - x_p) ] + dt f_ip
    f_ip     = -V tau D^-1 w_ip (x_i - x_p)    gradient "affine": moving least squares (Hu et al. 2018,
                                               doi:10.1145/3197517.3201293, eq. 16-18)
             = -V tau grad w_ip                gradient "shape": the classical form (Sulsky et al. 1995,
                                               doi:10.1016/0010-4655(94)00170-7)

A component may change the impulse (`kernel_api.Inlined.impulse`). PIC and FLIP leave out m C. A CPU takes the
particles of a block in packs (`scatter_packs`), a GPU one a thread.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.mpm.contact.spreading import Given, spreading
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import node_size, node_vector
from snowmpm.mpm.transfer.arrays import Tiles
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.scatter_packs import impulse_function, scatter_pack_kernel
from snowmpm.particles.arrays import ParticleArrays
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


def scatter_kernel(layout, real, scheme, atomic, serial=False, inlined=()):
    """Kernel that fills the tiles. atomic: one particle a thread (GPU); else one block a thread, in fixed order (CPU).

    scheme: `Scheme`; serial: by one thread, unless atomic; inlined: `kernel_api.Inlined` of components.
    """
    if atomic:
        return particle_kernel(layout, real, scheme, inlined)
    return scatter_pack_kernel(layout, real, scheme, inlined, serial)


@functools.cache
def particle_kernel(layout, real, scheme, inlined):
    """The kernel for one particle a thread."""
    flip, basis, gradient, affine = scheme
    dim, tile_edge = layout.dim, TILE[layout.dim]
    shape = gradient == "shape"
    access, at = accessors(layout), layout.offsets
    of_node, size = node_vector(real, flip), node_size(flip)
    grid = interpolation(dim, real, basis, affine or not shape, shape, flip)
    given = impulse_function(layout, real, inlined)
    pulls = given is not None
    parts = spreading(dim, real, basis, gradient, flip, affine, True, pulls)

    @ti.func
    def symmetric_matrix(s):
        """dim x dim block of a symmetric tensor stored as xx, yy, zz, xy[, yz, xz]."""
        if ti.static(dim == 2):
            return ti.Matrix([[s[0], s[3]], [s[3], s[1]]])
        else:
            return ti.Matrix([[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]])

    @ti.func
    def scatter_particle(p, b, particles: ti.template(), places, nodes: ti.template(), dt, dx):
        address, f, w, dw = grid.locate(access.load(particles.reals, places, p, at["position"], dim), b)
        velocity = access.load(particles.reals, places, p, at["velocity"], dim)
        C = ti.Matrix.zero(real, dim, dim)
        if ti.static(affine):
            rows = dx * access.load(particles.reals, places, p, at["affine"], dim * dim)
            for i in ti.static(range(dim)):
                for a in ti.static(range(dim)):
                    C[i, a] = rows[dim * i + a]
        tau = symmetric_matrix(access.load(particles.reals, places, p, at["stress"], layout.sym_size))
        volume = access.load(particles.reals, places, p, at["volume"], 1)[0]
        mass, beside = volume * particles.materials[particles.material[p], DENSITY], ti.cast(0.0, real)
        if ti.static(layout.mass_at >= 0):
            mass += volume * access.load(particles.reals, places, p, layout.mass_at, 1)[0]
            beside = volume * access.load(particles.reals, places, p, at["volume_ratio"], 1)[0]
        vectors = [ti.Vector.zero(real, size) for _ in ti.static(range(parts.n_vectors))]
        impulse, pull = (-dt / dx * volume) * tau, ti.Vector.zero(real, dim)
        if ti.static(pulls):
            own = access.load(particles.reals, places, p, given.at, given.size)
            ratio = access.load(particles.reals, places, p, at["volume_ratio"], 1)[0]
            impulse, pull, beside = given.act(impulse, ratio, own, dx)
        parts.prepare(vectors, 0, f, w, dw, ti.static(Given(mass, velocity, C, impulse, pull, beside)))
        parts.spread(nodes, address, w, vectors, 0)

    @grouped_kernel(real)
    def scatter_atomic(particles: ParticleArrays, block_of: Array, tiles: Tiles, dt: Real, dx: Real, count: int):
        for q in range(tiles.n * tile_edge**dim):
            tiles.nodes[q] = of_node(0.0)
        for p in range(count):
            places = access.places(particles.reals, particles.slot_offset)
            scatter_particle(p, block_of[p], particles, places, tiles.nodes, dt, dx)

    return scatter_atomic
