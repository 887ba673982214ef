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
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.mpm.contact.spreading import spreading
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import node_size, node_vector
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.scatter_packs import impulse_function, scatter_pack_kernel
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


def scatter_kernel(layout, real, atomic, flip, basis="quadratic", gradient="affine", affine=True, serial=False,
                   inlined=()):
    """Kernel that fills the tiles. atomic: one particle a thread (GPU); else one block a thread, in fixed order (CPU).

    flip: the internal impulse goes to the second half of a node, since FLIP needs the velocity before it.
    basis: name of a stencil; gradient: "affine" or "shape", see above; affine: whether C counts (APIC, AFLIP). serial:
    by one thread, unless atomic; inlined: `kernel_api.Inlined` of components.
    """
    scheme = layout, real, flip, basis, gradient, affine, inlined
    return particle_kernel(*scheme) if atomic else scatter_pack_kernel(*scheme, serial)


@functools.cache
def particle_kernel(layout, real, flip, basis, gradient, affine, inlined):
    """The kernel for one particle a thread."""
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
    def scatter_particle(p, b, reals: ti.template(), places, material: ti.template(), materials: ti.template(),
                         tiles: ti.template(), dt, dx):
        address, f, w, dw = grid.locate(access.load(reals, places, p, at["position"], dim), b)
        velocity = access.load(reals, places, p, at["velocity"], dim)
        C = ti.Matrix.zero(real, dim, dim)
        if ti.static(affine):
            rows = dx * access.load(reals, places, p, at["affine"], dim * dim)
            for i in ti.static(range(dim)):
                for a in ti.static(range(dim)):
                    C[i, a] = rows[dim * i + a]
        tau = symmetric_matrix(access.load(reals, places, p, at["stress"], layout.sym_size))
        volume = access.load(reals, places, p, at["volume"], 1)[0]
        mass, beside = volume * materials[material[p], DENSITY], ti.cast(0.0, real)
        if ti.static(layout.mass_at >= 0):
            mass += volume * access.load(reals, places, p, layout.mass_at, 1)[0]
            beside = volume * access.load(reals, places, p, at["volume_ratio"], 1)[0]
        vectors = [ti.Vector.zero(real, size) for _ in ti.static(range(parts.n_vectors))]
        impulse, pull = (-dt / dx * volume) * tau, ti.Vector.zero(real, dim)
        if ti.static(pulls):
            own = access.load(reals, places, p, given.at, given.size)
            impulse, pull, beside = given.act(impulse, access.load(reals, places, p, at["volume_ratio"], 1)[0], own, dx)
        parts.prepare(vectors, 0, f, w, dw, mass, velocity, C, impulse, pull, beside)
        parts.spread(tiles, address, w, vectors, 0)

    @taichi_kernel
    def scatter_atomic(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(),
                       materials: ti.types.ndarray(), block_of: ti.types.ndarray(), active_nodes: ti.types.ndarray(),
                       tiles: ti.types.ndarray(dtype=of_node, ndim=1), dt: real, dx: real, n_tiles: int, count: int):
        for q in range(n_tiles * tile_edge**dim):
            tiles[q] = of_node(0.0)
        for p in range(count):
            scatter_particle(p, block_of[p], reals, access.places(reals, slot_offset), material, materials, tiles,
                             dt, dx)

    return scatter_atomic
