"""The scatter of a CPU: packs of particles, like its gather (`gather_packs`).

What a particle gives to its nodes (`spreading`) is worked out for a vector register of particles at a time; then they
add it up one after the other, in their order, the numbers of a node in a register.
"""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.materials.packs import LANES, read_lane, read_matrix_lane, write_lane
from snowmpm.materials.symmetric import entries
from snowmpm.mpm.contact.spreading import Given, spreading
from snowmpm.mpm.grid import TILE, tile_strides
from snowmpm.mpm.node import node_mask, node_size, node_vector
from snowmpm.mpm.transfer.arrays import Tiles
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.arrays import ParticleArrays
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


def impulse_function(layout, real, inlined):
    """Of the component that acts on the impulse of a particle: act, its function; at and size of its column; None
    without one. inlined: `kernel_api.Inlined`s."""
    found = [(one, act) for one in inlined if (act := one.impulse(layout.dim, real)) is not None]
    assert len(found) <= 1, "one component at a time has the spare number of a node"
    return SimpleNamespace(act=found[0][1], at=layout.offsets[found[0][0].column],
                           size=layout.sizes[found[0][0].column]) if found else None


@functools.cache
def scatter_pack_kernel(layout, real, scheme, inlined, serial):
    """Kernel of `scatter.scatter_kernel` for one block a thread, in fixed order"""
    flip, basis, gradient, affine = scheme
    dim, tile_edge, sym_size = layout.dim, TILE[layout.dim], layout.sym_size
    access, at = accessors(layout), layout.offsets
    of_node, size, mask = node_vector(real, flip), node_size(flip), node_mask(flip)
    width, plane = STENCILS[basis].width, tile_strides(dim)[0]
    shape = gradient == "shape"
    grid = interpolation(dim, real, basis, affine or not shape, shape, flip)
    given = impulse_function(layout, real, inlined)
    pulls = given is not None
    n_own = given.size if given else 0
    parts = spreading(dim, real, basis, gradient, flip, affine, False, pulls)
    # What a pack holds, numbers a lane
    columns = (("x", dim), ("v", dim), ("C", dim * dim * affine), ("tau", sym_size), ("volume", 1), ("mass", 1),
               ("w", width * dim), ("bulk", int(layout.mass_at >= 0)), ("own", n_own), ("ratio", int(n_own > 0)))
    entry = entries(dim)

    @ti.func
    def read_pack(pack: ti.template(), first, count, particles: ti.template(), places):
        """Load the particles first .. first + count - 1."""
        for lane in range(count):
            p = first + lane
            write_lane(pack["x"], lane, access.load(particles.reals, places, p, at["position"], dim))
            write_lane(pack["v"], lane, access.load(particles.reals, places, p, at["velocity"], dim))
            if ti.static(affine):
                write_lane(pack["C"], lane, access.load(particles.reals, places, p, at["affine"], dim * dim))
            write_lane(pack["tau"], lane, access.load(particles.reals, places, p, at["stress"], sym_size))
            volume = access.load(particles.reals, places, p, at["volume"], 1)[0]
            pack["volume"][0][lane] = volume
            pack["mass"][0][lane] = volume * particles.materials[particles.material[p], DENSITY]
            if ti.static(pulls):
                write_lane(pack["own"], lane, access.load(particles.reals, places, p, given.at, given.size))
                pack["ratio"][0][lane] = access.load(particles.reals, places, p, at["volume_ratio"], 1)[0]
            if ti.static(layout.mass_at >= 0):
                pack["mass"][0][lane] += volume * access.load(particles.reals, places, p, layout.mass_at, 1)[0]
                pack["bulk"][0][lane] = volume * access.load(particles.reals, places, p, at["volume_ratio"], 1)[0]

    @ti.func
    def prepare_pack(pack: ti.template(), address: ti.template(), vectors: ti.template(), b, dt, dx):
        """Stencils of all lanes of block b, and what they give to them."""
        for lane in range(LANES):
            start, f, w, dw = grid.locate(read_lane(pack["x"], lane), b)
            address[lane] = start
            for k in ti.static(range(width)):
                for a in ti.static(range(dim)):
                    pack["w"][k * dim + a][lane] = w[k, a]
            C, tau = ti.Matrix.zero(real, dim, dim), ti.Matrix.zero(real, dim, dim)
            if ti.static(affine):
                C = dx * read_matrix_lane(pack["C"], lane)
            for i in ti.static(range(dim)):
                for j in ti.static(range(dim)):
                    tau[i, j] = pack["tau"][entry[i][j]][lane]
            impulse = (-dt / dx * pack["volume"][0][lane]) * tau
            pull, beside = ti.Vector.zero(real, dim), ti.cast(0.0, real)
            if ti.static(layout.mass_at >= 0):
                beside = pack["bulk"][0][lane]
            if ti.static(pulls):
                impulse, pull, beside = given.act(impulse, pack["ratio"][0][lane], read_lane(pack["own"], lane), dx)
            mass, velocity = pack["mass"][0][lane], read_lane(pack["v"], lane)
            parts.prepare(vectors, lane, f, w, dw, ti.static(Given(mass, velocity, C, impulse, pull, beside)))

    @ti.func
    def clear_box(tiles: ti.template(), active_nodes: ti.template(), b):
        """Set the box of tile b to zero, whole rows of it: one loop compiles several times faster than two."""
        first = b * tile_edge**dim + active_nodes[b, 0] * plane + active_nodes[b, 1] * tile_edge
        wide = active_nodes[b, 4] - active_nodes[b, 1]
        row, left = first, wide
        for _ in range((active_nodes[b, 3] - active_nodes[b, 0]) * wide):
            at = row & mask
            for k in ti.static(range(tile_edge)):
                # Always zero; told so by a choice, LLVM stores a node at once, not number by number
                tiles[at + k] = ti.select(first >= 0, of_node(0.0), tiles[at + k])
            row, left = row + tile_edge, left - 1
            if left == 0:
                row, left = row + plane - wide * tile_edge, wide

    @grouped_kernel(real)
    def scatter_blocks(particles: ParticleArrays, start: Array, tiles: Tiles, dt: Real, dx: Real, chunk_bounds: Array):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(particles.reals, particles.slot_offset)
                # Each a copy of its own; zeros anew for every array would take Taichi a tenth of its time
                blank, blanks = ti.Vector.zero(real, LANES), ti.Vector.zero(real, size * LANES)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                vectors = [blanks for _ in ti.static(range(parts.n_vectors))]
                address = ti.Vector.zero(ti.i32, LANES)
                for b in range(begin, end):
                    clear_box(tiles.nodes, tiles.active_nodes, b)
                    for k in range((start[b + 1] - start[b] + LANES - 1) // LANES):
                        first = start[b] + k * LANES
                        count = ti.min(LANES, start[b + 1] - first)
                        read_pack(pack, first, count, particles, places)
                        prepare_pack(pack, address, vectors, b, dt, dx)
                        for lane in range(count):
                            w = ti.Matrix([[pack["w"][k * dim + a][lane] for a in ti.static(range(dim))]
                                           for k in ti.static(range(width))])
                            parts.spread(tiles.nodes, address[lane] & mask, w, vectors, lane)

    return scatter_blocks
