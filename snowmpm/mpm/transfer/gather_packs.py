"""The gather of a CPU: packs of particles, a vector register of them at a time.

The particles of a block are taken LANES by LANES: the sums over the nodes one particle after the other, and all that is
a straight line in loops over local arrays, which the compiler vectorises (`materials.packs`). Packs are formed within a
block, in the order of its particles, so that no division of work changes a result.
"""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.materials.packs import LANES, read_lane, read_matrix_lane, write_lane, write_matrix_lane
from snowmpm.mpm.node import SECOND, node_mask, node_size
from snowmpm.mpm.report import report_functions
from snowmpm.mpm.transfer.arrays import Step, Tiles
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.arrays import ParticleArrays
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.law_packs import law_functions, most_held
from snowmpm.particles.response import response_functions
from snowmpm.particles.store import accessors
from snowmpm.stepping.step_report import (
    BAD,
    BREAKING,
    EXCURSION,
    N_REPORT,
    STRAIN,
    STRAINED,
    SUMMED,
    WAVE2,
    larger,
)


def gradient_functions(layout, real, inlined):
    """Of each component that acts on the velocity gradient: act, its function; at, size of its column, its name, and
    whether it keeps what becomes of it. inlined: `kernel_api.Inlined`s."""
    found = [(one, one.gradient(layout.dim, real)) for one in inlined]
    return [SimpleNamespace(act=act, at=layout.offsets[one.column], size=layout.sizes[one.column], column=one.column,
                            keeps=one.keeps) for one, act in found if act is not None]


@functools.cache
def pack_kernel(layout, real, laws, scheme, inlined, serial):
    """Kernel of `gather.gather_kernel` for one block a thread, in fixed order"""
    flip, basis, gradient, affine = scheme
    dim, edge, sym_size = layout.dim, EDGE[layout.dim], layout.sym_size
    access, at = accessors(layout), layout.offsets
    size, mask = node_size(flip), node_mask(flip)
    some_stiffen = any(law.stiffness is not None for law in laws)
    some_bonded = any(law.bonds is not None for law in laws)
    shape, width = gradient == "shape", STENCILS[basis].width
    grid = interpolation(dim, real, basis, affine or not shape, shape, flip)
    judged = report_functions(dim, real, basis)
    particle = response_functions(layout, real, laws)
    apply_laws = law_functions(layout, real, laws)
    bent = gradient_functions(layout, real, inlined)
    # What a pack holds, numbers a lane
    columns = (("x", dim), ("v", dim), ("old", dim * flip), ("moments", dim * dim), ("slopes", dim * dim * shape),
               ("f", dim), ("w", width * dim), ("dw", width * dim * shape), ("C", dim * dim), ("L", dim * dim),
               ("A", dim * dim), ("h", sym_size), ("tau", sym_size), ("state", layout.state_size), ("ratio", 1),
               ("volume", 1), ("growth", 1), ("strain", 1), ("wave2", 1), ("breaks", 1),
               ("held", most_held(laws, sym_size)), *((one.column, one.size) for one in bent))
    n_sums = 1 + dim * (1 + shape)  # node vectors: w v, its moments, its slopes
    # Of the second half of a node no moments are wanted. In single precision both halves are one register, and take
    # no longer than one; in double precision each has its own
    kept = size if real == ti.f32 else SECOND
    found_columns = ("most", N_REPORT), ("lowest", dim), ("highest", dim)

    @ti.func
    def read_pack(pack: ti.template(), first, count, b, reals: ti.template(), places):
        """Load the particles first .. first + count - 1 of block b, and find their stencils."""
        for lane in range(count):
            p = first + lane
            write_lane(pack["x"], lane, access.load(reals, places, p, at["position"], dim))
            write_lane(pack["h"], lane, access.load(reals, places, p, at["elastic"], sym_size))
            write_lane(pack["state"], lane, access.load(reals, places, p, at["state"], layout.state_size))
            write_lane(pack["ratio"], lane, access.load(reals, places, p, at["volume_ratio"], 1))
            write_lane(pack["volume"], lane, access.load(reals, places, p, at["volume"], 1))
            for k in ti.static(range(len(bent))):
                write_lane(pack[bent[k].column], lane, access.load(reals, places, p, bent[k].at, bent[k].size))
            if ti.static(flip):
                write_lane(pack["old"], lane, access.load(reals, places, p, at["velocity"], dim))
        for lane in range(LANES):
            start, f, w, dw = grid.locate(read_lane(pack["x"], lane), b)
            pack["address"][lane] = start
            write_lane(pack["f"], lane, f)
            for k in ti.static(range(width)):
                for a in ti.static(range(dim)):
                    pack["w"][k * dim + a][lane] = w[k, a]
                    if ti.static(shape):
                        pack["dw"][k * dim + a][lane] = dw[k, a]

    @ti.func
    def sum_over_nodes(pack: ti.template(), sums: ti.template(), first, count, reals: ti.template(), places,
                       nodes: ti.template(), cells_per_metre):
        """Interpolate to each lane, and move it. Node vectors are kept whole, as numbers of a register; were the
        position not stored here, the compiler would take several lanes at once and each number of a node alone."""
        for lane in range(count):
            w, dw = ti.Matrix.zero(real, width, dim), ti.Matrix.zero(real, width, dim)
            for k in ti.static(range(width)):
                for a in ti.static(range(dim)):
                    w[k, a] = pack["w"][k * dim + a][lane]
                    if ti.static(shape):
                        dw[k, a] = pack["dw"][k * dim + a][lane]
            v, moments, slopes = grid.interpolate(nodes, pack["address"][lane] & mask, w, dw)
            for c in ti.static(range(size)):
                sums[0][size * lane + c] = v[c]
                if ti.static(c < kept):
                    for a in ti.static(range(dim)):
                        sums[1 + a][size * lane + c] = moments[a, c]
                        if ti.static(shape):
                            sums[1 + dim + a][size * lane + c] = slopes[a, c]
            x = read_lane(pack["x"], lane)
            for a in ti.static(range(dim)):
                x[a] += cells_per_metre * v[a]
            write_lane(pack["x"], lane, x)
            access.store(reals, places, first + lane, at["position"], x)

    @ti.func
    def spread_sums(pack: ti.template(), sums: ti.template()):
        """From node vectors to one array for each number, which is what a loop over lanes needs."""
        for lane in range(LANES):
            for i in ti.static(range(dim)):
                pack["v"][i][lane] = sums[0][size * lane + i]
                for a in ti.static(range(dim)):
                    pack["moments"][a * dim + i][lane] = sums[1 + a][size * lane + i]
                    if ti.static(shape):
                        pack["slopes"][a * dim + i][lane] = sums[1 + dim + a][size * lane + i]
                if ti.static(flip):
                    pack["old"][i][lane] += sums[0][size * lane + ti.static(SECOND + i)]

    @ti.func
    def deform_pack(pack: ti.template(), dt, inverse_dx, flip_ratio):
        """Velocity, C and deformation of all lanes."""
        for lane in range(LANES):
            v, slopes = read_lane(pack["v"], lane), ti.Matrix.zero(real, dim, dim)
            if ti.static(shape):
                slopes = read_matrix_lane(pack["slopes"], lane)
            moments = read_matrix_lane(pack["moments"], lane)
            C, L = grid.gradients(read_lane(pack["f"], lane), v, moments, slopes, inverse_dx)
            for k in ti.static(range(len(bent))):
                own = read_lane(pack[bent[k].column], lane)
                L, own = bent[k].act(L, v, pack["ratio"][0][lane], own, dt, 1.0 / inverse_dx)
                if ti.static(bent[k].keeps):
                    write_lane(pack[bent[k].column], lane, own)
            if ti.static(flip):
                v = particle.blend(v, read_lane(pack["old"], lane), flip_ratio)
            A, growth, ratio = particle.deform(L, pack["ratio"][0][lane], dt)
            write_lane(pack["v"], lane, v)
            write_matrix_lane(pack["C"], lane, C)
            write_matrix_lane(pack["L"], lane, L)
            write_matrix_lane(pack["A"], lane, A)
            pack["growth"][0][lane], pack["ratio"][0][lane] = growth, ratio

    @ti.func
    def report_pack(pack: ti.template(), found: ti.template(), worst: ti.template(), first, count):
        """Add what a pack reports to the lanes of its block's report."""
        for lane in range(LANES):
            x, h = read_lane(pack["x"], lane), read_lane(pack["h"], lane)
            one = judged.judge(x, read_lane(pack["v"], lane), read_matrix_lane(pack["L"], lane),
                               pack["growth"][0][lane], h, read_lane(pack["tau"], lane),
                               pack["work"][lane] * pack["volume"][0][lane], pack["iterations"][lane])
            one[STRAIN] = h.norm_sqr()
            if ti.static(some_stiffen):
                one[STRAIN], one[WAVE2] = pack["strain"][0][lane], pack["wave2"][0][lane]
            one[STRAINED] = judged.strained(one[STRAIN])
            if ti.static(some_bonded):
                one[BREAKING] = pack["breaks"][0][lane]
            used = lane < count
            worst[lane] = ti.select(used & (one[BAD] > 0.0), first + lane + 1, worst[lane])
            for c in ti.static(range(N_REPORT)):
                value = ti.select(used, one[c], 0.0)
                if ti.static(c in SUMMED):
                    found["most"][c][lane] += value
                else:
                    found["most"][c][lane] = larger(value, found["most"][c][lane])
            for a in ti.static(range(dim)):
                lowest, highest = found["lowest"][a][lane], found["highest"][a][lane]
                found["lowest"][a][lane] = ti.select(used & (x[a] < lowest), x[a], lowest)
                found["highest"][a][lane] = ti.select(used & (x[a] > highest), x[a], highest)

    @ti.func
    def write_pack(pack: ti.template(), first, count, reals: ti.template(), places):
        for lane in range(count):
            p = first + lane
            particle.store_motion(p, reals, places, read_lane(pack["v"], lane), read_matrix_lane(pack["C"], lane))
            particle.store_response(p, reals, places, read_lane(pack["h"], lane), read_lane(pack["tau"], lane),
                                    read_lane(pack["state"], lane), pack["ratio"][0][lane])
            for k in ti.static(range(len(bent))):
                if ti.static(bent[k].keeps):
                    access.store(reals, places, p, bent[k].at, read_lane(pack[bent[k].column], lane))

    @ti.func
    def clear_found(found: ti.template(), worst: ti.template()):
        for lane in range(LANES):
            worst[lane] = 0
            for c in ti.static(range(N_REPORT)):
                found["most"][c][lane] = 0.0
            for a in ti.static(range(dim)):
                found["lowest"][a][lane], found["highest"][a][lane] = 2.0 * edge, -1.0 * edge

    @ti.func
    def write_found(found: ti.template(), worst: ti.template(), b, active_nodes: ti.template(), reports: ti.template()):
        """Lanes of a block's report, in their order, into its row."""
        block = read_lane(found["most"], 0)
        lowest, highest = read_lane(found["lowest"], 0), read_lane(found["highest"], 0)
        for lane in range(1, LANES):
            for c in ti.static(range(N_REPORT)):
                if ti.static(c in SUMMED):
                    block[c] += found["most"][c][lane]
                else:
                    block[c] = larger(found["most"][c][lane], block[c])
            lowest = -larger(-read_lane(found["lowest"], lane), -lowest)
            highest = larger(read_lane(found["highest"], lane), highest)
        judged.store_active_nodes(active_nodes, b, lowest, highest)
        block[EXCURSION] = judged.excursion(lowest, highest)
        for c in ti.static(range(N_REPORT)):
            reports[b, c] = ti.cast(block[c], ti.f64)
        reports[b, BAD] = ti.cast(worst.max(), ti.f64)

    @grouped_kernel(real, plain=True)
    def gather_blocks(particles: ParticleArrays, start: Array, tiles: Tiles, step: Step, reports: Array, report: Array,
                      chunk_bounds: Array):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(particles.reals, particles.slot_offset)
                # Each a copy of its own; zeros anew for every array would take Taichi a tenth of its time
                blank, count_blank = ti.Vector.zero(real, LANES), ti.Vector.zero(ti.i32, LANES)
                blanks = ti.Vector.zero(real, size * LANES)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)} | {
                    "work": blank, "iterations": count_blank, "address": count_blank}
                found = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(found_columns)}
                worst = count_blank
                sums = [blanks for _ in ti.static(range(n_sums))]
                for b in range(begin, end):
                    clear_found(found, worst)
                    for k in range((start[b + 1] - start[b] + LANES - 1) // LANES):
                        first = start[b] + k * LANES
                        count = ti.min(LANES, start[b + 1] - first)
                        read_pack(pack, first, count, b, particles.reals, places)
                        sum_over_nodes(pack, sums, first, count, particles.reals, places, tiles.nodes,
                                       step.dt / step.dx)
                        spread_sums(pack, sums)
                        deform_pack(pack, step.dt, 1.0 / step.dx, step.flip_ratio)
                        apply_laws(pack, first, count, particles.material, particles.materials, particles.law_of,
                                   step.dt)
                        report_pack(pack, found, worst, first, count)
                        write_pack(pack, first, count, particles.reals, places)
                    write_found(found, worst, b, tiles.active_nodes, reports)
        ti.loop_config(serialize=True)
        for b in range(tiles.n):
            judged.add_row(reports, b, report)

    return gather_blocks
