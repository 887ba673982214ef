"""Grid to particles, then the constitutive update: everything a particle learns from a step.

    v_grid = sum_i w v_i,   C <- D^-1 sum_i w v_i (x_i - x_p)^T,   x <- x + dt v_grid
    v  <- v_grid + flip_ratio (v + sum_i w dv_i - v_grid)        flip_ratio = 0 in PIC and APIC
    L = grad v: C with the gradient "affine", sum_i v_i grad w^T with "shape" (see `scatter`)
    f = I + dt L,  A = dt L;   law.update(h, A) -> h, tau, state;   J <- J det f

f is the deformation of the map x + dt v_grid(x) itself, so that stress and places stay one thing: v is that of the end
of the step over the geometry of its start, and in a rotation L has the part -omega^2 dt / 2 I, which leaves det f = 1 +
(omega dt)^4 / 4. exp(dt L) would hold J as well, but let the places swell by omega^2 dt t against it.

A CPU takes the particles of a block in packs of LANES: the sums over the nodes one particle after the other, and all
that is a straight line in loops over local arrays, which the compiler vectorises (`materials.packs`). Packs are formed
within a block, so that no division of work changes a result.
"""

import functools

import taichi as ti

from snowmpm.blocks import EDGE
from snowmpm.material_table import DENSITY
from snowmpm.materials.law import REDO
from snowmpm.materials.packs import (
    LANES,
    read_lane,
    read_matrix_lane,
    update_lane,
    update_pack,
    write_lane,
    write_matrix_lane,
)
from snowmpm.mpm.interpolation import interpolation
from snowmpm.mpm.report import BAD, EXCURSION, N_REPORT, STRAIN, SUMMED, WAVE2, larger, report_functions
from snowmpm.parallel import chunk, chunks, is_worker
from snowmpm.particles import accessors
from snowmpm.stencil import STENCILS

LARGEST_RATIO = 1e4
"""J at which a grain that flies alone stops to grow: its volume means nothing, and would overflow in the end. The law
sees no deformation then either, so that what it has to close again and J stay the same thing."""


@functools.cache
def gather_kernel(layout, real, laws, n_parameters, atomic, flip, basis="quadratic", gradient="affine", affine=True):
    """Kernel of the second half of a step.

    laws: (update, lanes, stiffness) of each, the last two None where a law has none.
    atomic, basis, gradient: as in `scatter_kernel`; affine: whether the transfer hands C on (APIC), and so needs it
    beside a grad v of the shape functions.
    """
    dim, edge, sym_size = layout.dim, EDGE[layout.dim], layout.sym_size
    access, at = accessors(layout), layout.offsets
    vec4 = ti.types.vector(4, real)
    n_laws, updates, lanes, stiffnesses = len(laws), *zip(*laws, strict=True)
    has_lanes, stiffens = ([function is not None for function in functions] for functions in (lanes, stiffnesses))
    some_stiffen = any(stiffens)
    shape, width = gradient == "shape", STENCILS[basis].width
    grid = interpolation(dim, real, basis, affine or not shape, shape)
    judged = report_functions(dim, real, basis)
    # What a pack holds, numbers a lane
    columns = (("x", dim), ("v", dim), ("old", dim * flip), ("moments", dim * dim), ("slopes", dim * dim * shape),
               ("f", dim), ("w", width * dim), ("dw", width * dim * shape), ("C", dim * dim), ("L", dim * dim),
               ("A", dim * dim), ("h", sym_size), ("tau", sym_size), ("state", layout.state_size),
               ("ratio", 1), ("volume", 1), ("growth", 1), ("strain", 1), ("wave2", 1))
    n_sums = 1 + dim * (1 + shape) + flip  # node vectors: w v, its moments, its slopes, w dv
    found_columns = ("most", N_REPORT), ("lowest", dim), ("highest", dim)

    @ti.func
    def deform(L, ratio, dt):
        """Deformation of a step: A, det f and the new J."""
        A = dt * L
        growth = (ti.Matrix.identity(real, dim) + A).determinant()
        ends = (ratio * growth > LARGEST_RATIO) & (growth > 1.0)
        return ti.select(ends, 0.0, 1.0) * A, growth, ti.select(ends, ratio, ratio * growth)

    @ti.func
    def parameters_of(materials: ti.template(), material):
        parameters = ti.Vector.zero(real, n_parameters)
        for c in ti.static(range(n_parameters)):
            parameters[c] = materials[material, 1 + c]
        return parameters

    @ti.func
    def extremes_of_law(k: ti.template(), materials: ti.template(), material, h, tau, state):
        """STRAIN and WAVE2 of a particle of law k."""
        strain, wave2 = h.norm_sqr(), ti.cast(0.0, real)
        if ti.static(stiffens[k]):
            wave2 = stiffnesses[k](parameters_of(materials, material), tau, state) / materials[material, DENSITY]
            strain = 0.0
        return strain, wave2

    @ti.func
    def blend(velocity, changed, flip_ratio):
        """Velocity of FLIP or AFLIP from that on the grid and the particle's own with its change."""
        return velocity + flip_ratio * (changed - velocity)

    @ti.func
    def store_motion(p, reals: ti.template(), places, velocity, C):
        """Columns that follow each other are stored as one vector, so that whole rows are written."""
        motion = ti.Vector.zero(real, dim + dim * dim)
        for i in ti.static(range(dim)):
            motion[i] = velocity[i]
            for a in ti.static(range(dim)):
                motion[dim + i * dim + a] = C[i, a]
        access.store(reals, places, p, at["velocity"], motion)

    @ti.func
    def store_response(p, reals: ti.template(), places, h, tau, state, ratio):
        response = ti.Vector.zero(real, 2 * sym_size + layout.state_size + 1)
        for k in ti.static(range(sym_size)):
            response[k], response[sym_size + k] = h[k], tau[k]
        for k in ti.static(range(layout.state_size)):
            response[2 * sym_size + k] = state[k]
        response[2 * sym_size + layout.state_size] = ratio
        access.store(reals, places, p, at["elastic"], response)

    # ---- one particle a thread ----------------------------------------------------------------------------------

    @ti.func
    def gather_particle(p, b, reals: ti.template(), places, material: ti.template(), materials: ti.template(),
                        law_of: ti.template(), tiles: ti.template(), changes: ti.template(), dt, inverse_dx,
                        flip_ratio):
        """Advance one particle; -> its report."""
        x = access.load(reals, places, p, at["position"], dim)
        address, f, w, dw = grid.locate(x, b)
        v, moments, slopes = grid.interpolate(tiles, address, w, dw, True)
        C, L = grid.gradients(f, v, moments, slopes, inverse_dx)
        velocity = ti.Vector([v[i] for i in ti.static(range(dim))])
        x += (dt * inverse_dx) * velocity
        if ti.static(flip):
            change, _, _ = grid.interpolate(changes, address, w, dw, False)
            old = access.load(reals, places, p, at["velocity"], dim)
            velocity = blend(velocity, old + ti.Vector([change[i] for i in ti.static(range(dim))]), flip_ratio)
        A, growth, ratio = deform(L, access.load(reals, places, p, at["volume_ratio"], 1)[0], dt)
        h, tau = access.load(reals, places, p, at["elastic"], sym_size), ti.Vector.zero(real, sym_size)
        state = access.load(reals, places, p, at["state"], layout.state_size)
        work, iterations = ti.cast(0.0, real), 0
        strain, wave2 = ti.cast(0.0, real), ti.cast(0.0, real)
        for k in ti.static(range(n_laws)):
            if law_of[material[p]] == k:
                parameters = parameters_of(materials, material[p])
                h, tau, state, work, iterations = updates[k](parameters, h, state, A, dt)
                strain, wave2 = extremes_of_law(k, materials, material[p], h, tau, state)
        access.store(reals, places, p, at["position"], x)
        store_motion(p, reals, places, velocity, C)
        store_response(p, reals, places, h, tau, state, ratio)
        volume = access.load(reals, places, p, at["volume"], 1)[0]
        report = judged.judge(x, velocity, L, growth, h, tau, work * volume, iterations)
        report[STRAIN], report[WAVE2], report[EXCURSION] = strain, wave2, judged.excursion(x, x)
        return report

    @ti.kernel
    def gather_atomic(reals: ti.types.ndarray(), turn: int, material: ti.types.ndarray(),
                      materials: ti.types.ndarray(), law_of: ti.types.ndarray(), block_of: ti.types.ndarray(),
                      boxes: ti.types.ndarray(), tiles: ti.types.ndarray(dtype=vec4, ndim=1),
                      changes: ti.types.ndarray(dtype=vec4, ndim=1), dt: real, dx: real, flip_ratio: real,
                      reports: ti.types.ndarray(), report: ti.types.ndarray(), n_tiles: int, count: int):
        for b, c in ti.ndrange(n_tiles, N_REPORT):
            reports[b, c] = 0.0
        for p in range(count):
            one = gather_particle(p, block_of[p], reals, access.places(reals, turn), material, materials, law_of, tiles,
                                  changes, dt, 1.0 / dx, flip_ratio)
            for c in ti.static(range(N_REPORT)):
                value = ti.cast(one[c], ti.f64)
                if ti.static(c == BAD):
                    value *= p + 1
                if ti.static(c in SUMMED):
                    ti.atomic_add(reports[block_of[p], c], value)
                else:
                    ti.atomic_max(reports[block_of[p], c], value)
        ti.loop_config(serialize=True)
        for _ in range(1):
            judged.reduce_report(reports, report, n_tiles)

    # ---- packs of particles -------------------------------------------------------------------------------------

    @ti.func
    def read_pack(pack: ti.template(), address: ti.template(), first, count, b, reals: ti.template(), places):
        """Load the particles first .. first + count - 1 of block b, and find their stencils."""
        for lane in range(count):
            p = first + lane
            write_lane(pack["x"], lane, access.load(reals, places, p, at["position"], dim))
            write_lane(pack["h"], lane, access.load(reals, places, p, at["elastic"], sym_size))
            write_lane(pack["state"], lane, access.load(reals, places, p, at["state"], layout.state_size))
            write_lane(pack["ratio"], lane, access.load(reals, places, p, at["volume_ratio"], 1))
            write_lane(pack["volume"], lane, access.load(reals, places, p, at["volume"], 1))
            if ti.static(flip):
                write_lane(pack["old"], lane, access.load(reals, places, p, at["velocity"], dim))
        for lane in range(LANES):
            start, f, w, dw = grid.locate(read_lane(pack["x"], lane), b)
            address[lane] = start
            write_lane(pack["f"], lane, f)
            for k in ti.static(range(width)):
                for a in ti.static(range(dim)):
                    pack["w"][k * dim + a][lane] = w[k, a]
                    if ti.static(shape):
                        pack["dw"][k * dim + a][lane] = dw[k, a]

    @ti.func
    def sum_over_nodes(pack: ti.template(), address: ti.template(), sums: ti.template(), first, count,
                       reals: ti.template(), places, tiles: ti.template(), changes: ti.template(), cells_per_metre):
        """Interpolate to each lane, and move it. Node vectors are kept whole, four numbers in a register; were the
        position not stored here, the compiler would take several lanes at once and each number of a node alone."""
        for lane in range(count):
            w, dw = ti.Matrix.zero(real, width, dim), ti.Matrix.zero(real, width, dim)
            for k in ti.static(range(width)):
                for a in ti.static(range(dim)):
                    w[k, a] = pack["w"][k * dim + a][lane]
                    if ti.static(shape):
                        dw[k, a] = pack["dw"][k * dim + a][lane]
            v, moments, slopes = grid.interpolate(tiles, address[lane], w, dw, True)
            for c in ti.static(range(4)):
                sums[0][4 * lane + c] = v[c]
                for a in ti.static(range(dim)):
                    sums[1 + a][4 * lane + c] = moments[a, c]
                    if ti.static(shape):
                        sums[1 + dim + a][4 * lane + c] = slopes[a, c]
            if ti.static(flip):
                change, _, _ = grid.interpolate(changes, address[lane], w, dw, False)
                for c in ti.static(range(4)):
                    sums[n_sums - 1][4 * lane + c] = change[c]
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
                pack["v"][i][lane] = sums[0][4 * lane + i]
                for a in ti.static(range(dim)):
                    pack["moments"][a * dim + i][lane] = sums[1 + a][4 * lane + i]
                    if ti.static(shape):
                        pack["slopes"][a * dim + i][lane] = sums[1 + dim + a][4 * lane + i]
                if ti.static(flip):
                    pack["old"][i][lane] += sums[n_sums - 1][4 * lane + i]

    @ti.func
    def deform_pack(pack: ti.template(), dt, inverse_dx, flip_ratio):
        """Velocity, C and deformation of all lanes."""
        for lane in range(LANES):
            v, slopes = read_lane(pack["v"], lane), ti.Matrix.zero(real, dim, dim)
            if ti.static(shape):
                slopes = read_matrix_lane(pack["slopes"], lane)
            moments = read_matrix_lane(pack["moments"], lane)
            C, L = grid.gradients(read_lane(pack["f"], lane), v, moments, slopes, inverse_dx)
            if ti.static(flip):
                v = blend(v, read_lane(pack["old"], lane), flip_ratio)
            A, growth, ratio = deform(L, pack["ratio"][0][lane], dt)
            write_lane(pack["v"], lane, v)
            write_matrix_lane(pack["C"], lane, C)
            write_matrix_lane(pack["L"], lane, L)
            write_matrix_lane(pack["A"], lane, A)
            pack["growth"][0][lane], pack["ratio"][0][lane] = growth, ratio

    @ti.func
    def apply_laws(pack: ti.template(), work: ti.template(), iterations: ti.template(), first, count,
                   material: ti.template(), materials: ti.template(), law_of: ti.template(), dt):
        """A pack of one material at once as far as its law can, everything else particle by particle."""
        common, alike = ti.cast(material[first], ti.i32), 1
        for lane in range(count):
            iterations[lane] = REDO
            if material[first + lane] != common:
                alike = 0
        if alike == 1:
            for k in ti.static(range(n_laws)):
                if ti.static(has_lanes[k]):  # noqa: SIM102 (one is compile time)
                    if law_of[common] == k:
                        update_pack(lanes[k], parameters_of(materials, common), dt, pack["h"], pack["state"],
                                    pack["A"], pack["tau"], work, iterations)
        for lane in range(count):
            own = ti.cast(material[first + lane], ti.i32)
            for k in ti.static(range(n_laws)):
                if law_of[own] == k:
                    if iterations[lane] == REDO:
                        update_lane(updates[k], lane, parameters_of(materials, own), dt, pack["h"], pack["state"],
                                    pack["A"], pack["tau"], work, iterations)
                    if ti.static(some_stiffen):
                        strain, wave2 = extremes_of_law(k, materials, own, read_lane(pack["h"], lane),
                                                        read_lane(pack["tau"], lane), read_lane(pack["state"], lane))
                        pack["strain"][0][lane], pack["wave2"][0][lane] = strain, wave2

    @ti.func
    def report_pack(pack: ti.template(), work: ti.template(), iterations: ti.template(), found: ti.template(),
                    worst: ti.template(), first, count):
        """Add what a pack reports to the lanes of its block's report."""
        for lane in range(LANES):
            x, h = read_lane(pack["x"], lane), read_lane(pack["h"], lane)
            one = judged.judge(x, read_lane(pack["v"], lane), read_matrix_lane(pack["L"], lane),
                               pack["growth"][0][lane], h, read_lane(pack["tau"], lane),
                               work[lane] * pack["volume"][0][lane], iterations[lane])
            one[STRAIN] = h.norm_sqr()
            if ti.static(some_stiffen):
                one[STRAIN], one[WAVE2] = pack["strain"][0][lane], pack["wave2"][0][lane]
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
            store_motion(first + lane, reals, places, read_lane(pack["v"], lane), read_matrix_lane(pack["C"], lane))
            store_response(first + lane, reals, places, read_lane(pack["h"], lane), read_lane(pack["tau"], lane),
                           read_lane(pack["state"], lane), pack["ratio"][0][lane])

    @ti.func
    def clear_found(found: ti.template(), worst: ti.template()):
        for lane in range(LANES):
            worst[lane] = 0
            for c in ti.static(range(N_REPORT)):
                found["most"][c][lane] = 0.0
            for a in ti.static(range(dim)):
                found["lowest"][a][lane], found["highest"][a][lane] = 2.0 * edge, -1.0 * edge

    @ti.func
    def write_found(found: ti.template(), worst: ti.template(), b, boxes: ti.template(), reports: ti.template()):
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
        judged.store_box(boxes, b, lowest, highest)
        block[EXCURSION] = judged.excursion(lowest, highest)
        for c in ti.static(range(N_REPORT)):
            reports[b, c] = ti.cast(block[c], ti.f64)
        reports[b, BAD] = ti.cast(worst.max(), ti.f64)

    @ti.kernel
    def gather_blocks(reals: ti.types.ndarray(), turn: int, material: ti.types.ndarray(),
                      materials: ti.types.ndarray(), law_of: ti.types.ndarray(), start: ti.types.ndarray(),
                      boxes: ti.types.ndarray(), tiles: ti.types.ndarray(dtype=vec4, ndim=1),
                      changes: ti.types.ndarray(dtype=vec4, ndim=1), dt: real, dx: real, flip_ratio: real,
                      reports: ti.types.ndarray(), report: ti.types.ndarray(), n_tiles: int,
                      shares: ti.types.ndarray()):
        for i in range(chunks(shares)):
            if is_worker(i):
                begin, end = chunk(i, shares)
                places = access.places(reals, turn)
                pack = {name: [ti.Vector.zero(real, LANES) for _ in ti.static(range(n))]
                        for name, n in ti.static(columns)}
                found = {name: [ti.Vector.zero(real, LANES) for _ in ti.static(range(n))]
                         for name, n in ti.static(found_columns)}
                work, iterations = ti.Vector.zero(real, LANES), ti.Vector.zero(ti.i32, LANES)
                worst, address = ti.Vector.zero(ti.i32, LANES), ti.Vector.zero(ti.i32, LANES)
                sums = [ti.Vector.zero(real, 4 * LANES) for _ in ti.static(range(n_sums))]
                for b in range(begin, end):
                    clear_found(found, worst)
                    for k in range((start[b + 1] - start[b] + LANES - 1) // LANES):
                        first = start[b] + k * LANES
                        count = ti.min(LANES, start[b + 1] - first)
                        read_pack(pack, address, first, count, b, reals, places)
                        sum_over_nodes(pack, address, sums, first, count, reals, places, tiles, changes, dt / dx)
                        spread_sums(pack, sums)
                        deform_pack(pack, dt, 1.0 / dx, flip_ratio)
                        apply_laws(pack, work, iterations, first, count, material, materials, law_of, dt)
                        report_pack(pack, work, iterations, found, worst, first, count)
                        write_pack(pack, first, count, reals, places)
                    write_found(found, worst, b, boxes, reports)
        ti.loop_config(serialize=True)
        for _ in range(1):
            judged.reduce_report(reports, report, n_tiles)

    return gather_atomic if atomic else gather_blocks
