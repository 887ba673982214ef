"""From velocities to stresses: velocity gradient, deformation, law, drift of a step.

    A_i = sum_j V_j (v_j - v_i) (x) grad_i W_ij,   K_i = sum_j V_j (x_j - x_i) (x) grad_i W_ij
    L_i = A_i K_i^-1                    "corrected": exact for linear velocities on any arrangement (Bui & Nguyen 2021,
                                        Eq. 21)
    L_i = A_i                           "plain" (Favero Neto & Borja 2018)
    L_i = C_i - D_i + (D_i K_i + K_i D_i) / 2   "balanced": C the corrected one, D = (f^T f - I) / 2 dt of its f, which
                                        is zero in any rotation
    f = I + dt L,  A = dt L;   law.update(h, A) -> h, tau, state;   J <- J det f;   x <- x + dt v

A = L K for the corrected L, so the balanced stretching has the plain sum's trace: the rate at which the particles
around one become fewer, which keeps J what a count of them says; and it does the work that the plain sum of forces
takes from the motion. The corrected one fits a plane through the velocities; what it does not see adds up. In sand that
flows, particles crowd to one and a half of their number while J says that nothing has happened, no pressure drives them
apart, and the heap comes to lie a fifth too low (`tests/sph/test_crowding.py`). The plain spin, W K of a body that
turns, would strain free surfaces; the balanced one is that of the corrected gradient. With the "corrected" sum of
forces it is the corrected gradient that is in balance.

K = I of a full neighbourhood, and has no inverse where there are too few (`moment`). Packs as in the grid's gather
(`snowmpm.particles.law_packs`).
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker, partial_sums
from snowmpm.materials.packs import read_lane, read_matrix_lane, write_lane, write_matrix_lane
from snowmpm.particles.arrays import ParticleArrays
from snowmpm.particles.law_packs import law_functions, most_held
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.response import response_functions
from snowmpm.particles.store import accessors
from snowmpm.sph.lengths import kernel_functions
from snowmpm.sph.moment import inverse_function
from snowmpm.sph.neighbours import COUNT, FIRST, Lists
from snowmpm.sph.pairs import pair_functions
from snowmpm.sph.row_writing import Shown, row_functions
from snowmpm.sph.rows import RowTables
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
    particle_report,
)


class Report(NamedTuple):
    """Mean velocity (dim), from which excursions count; what each pack reports; what all report."""

    mean: Array
    of_packs: Array
    total: Array


class Step(NamedTuple):
    """speeds: of waves in each material [m/s]; dt [s], dx [m]."""

    speeds: Array
    dt: Real
    dx: Real


class Terms(NamedTuple):
    """Form of the momentum sum; gradient: "balanced", "corrected" or "plain"; tension, volumes: as `row_functions`
    takes them."""

    form: str
    gradient: str
    tension: tuple
    volumes: str


@functools.cache
def update_kernel(layout, row_layout, real, laws, width, support, terms, serial):
    """`update(...)`, the second half of a step, and the sum of its reports. support: `lengths.Support`; serial: by one
    thread."""
    form, gradient, tension, volumes = terms
    dim, sym_size, mask = layout.dim, layout.sym_size, row_layout.row_mask
    access, at = accessors(layout), layout.offsets
    pair = pair_functions(row_layout)
    smooth = kernel_functions(support, dim)
    stiffnesses = [law.stiffness for law in laws]
    stiffens = [function is not None for function in stiffnesses]
    some_stiffen, some_bonded = any(stiffens), any(law.bonds is not None for law in laws)
    judged, particle = particle_report(real), response_functions(layout, real, laws)
    apply_laws = law_functions(layout, real, laws, width)
    store_row, inverse = row_functions(layout, row_layout, real, form, tension, volumes), inverse_function(dim, real)
    symmetric = [(a, b) for a in range(dim) for b in range(a, dim)]
    number = {**{(a, b): k for k, (a, b) in enumerate(symmetric)}, **{(b, a): k for k, (a, b) in enumerate(symmetric)}}
    columns = (("x", dim), ("v", dim), ("sums", dim * dim), ("K", len(symmetric)), ("L", dim * dim), ("A", dim * dim),
               ("h", sym_size), ("tau", sym_size), ("state", layout.state_size), ("ratio", 1), ("volume", 1),
               ("growth", 1), ("strain", 1), ("wave2", 1), ("breaks", 1), ("most", N_REPORT),
               ("back", dim * dim * row_layout.full), ("held", most_held(laws, sym_size, width)),
               ("s", int(smooth.varies)))

    @ti.func
    def read_pack(pack: ti.template(), first, count, reals: ti.template(), places, moved: ti.template()):
        for lane in range(count):
            p = first + lane
            row = moved[p]
            for a in ti.static(range(dim)):
                pack["x"][a][lane], pack["v"][a][lane] = row[a], row[dim + a]
            write_lane(pack["h"], lane, access.load(reals, places, p, at["elastic"], sym_size))
            write_lane(pack["state"], lane, access.load(reals, places, p, at["state"], layout.state_size))
            write_lane(pack["ratio"], lane, access.load(reals, places, p, at["volume_ratio"], 1))
            write_lane(pack["volume"], lane, access.load(reals, places, p, at["volume"], 1))
            if ti.static(smooth.varies):
                pack["s"][0][lane] = smooth.own(row[2 * dim])
        for lane in range(width):
            for k in ti.static(range(dim * dim)):
                pack["sums"][k][lane] = 0.0
            for k in ti.static(range(len(symmetric))):
                pack["K"][k][lane] = 0.0

    @ti.func
    def add_run(pack: ti.template(), c, begin, end, moved: ti.template(), lists: ti.template()):
        sign = pair.signs(lists.reals, c)
        for e in range(begin, end):
            row = moved[lists.entries[e] & mask]
            xj, vj, Vj = pair.place(lists.reals, c, row), pair.vector(sign, row, dim), row[2 * dim]
            sj = smooth.own(Vj) if ti.static(smooth.varies) else ti.cast(1.0, real)
            for lane in range(width):
                d = xj - read_lane(pack["x"], lane)
                dv = vj - read_lane(pack["v"], lane)
                b = ti.cast(1.0, real)
                if ti.static(smooth.varies):
                    b = smooth.narrowing(pack["s"][0][lane], sj)
                near = -Vj * smooth.slope_over_r(ti.sqrt(d.norm_sqr()), b)
                for a in ti.static(range(dim)):
                    for b in ti.static(range(dim)):
                        pack["sums"][a * dim + b][lane] += near * dv[a] * d[b]
                for k in ti.static(range(len(symmetric))):
                    pack["K"][k][lane] += near * d[symmetric[k][0]] * d[symmetric[k][1]]

    @ti.func
    def deform_pack(pack: ti.template(), dt, inverse_dx):
        for lane in range(width):
            sums = read_matrix_lane(pack["sums"], lane)
            L = inverse_dx * sums
            K = ti.Matrix.zero(real, dim, dim)
            if ti.static(gradient != "plain" or row_layout.full):
                for a in ti.static(range(dim)):
                    for b in ti.static(range(dim)):
                        K[a, b] = pack["K"][number[a, b]][lane]
                back = inverse(K)
                if ti.static(gradient != "plain"):
                    L = inverse_dx * (sums @ back)
                if ti.static(row_layout.full):
                    write_matrix_lane(pack["back"], lane, back)
            write_matrix_lane(pack["L"], lane, L)
            if ti.static(gradient == "balanced" and not row_layout.full):
                # That of f: L alone has a part -omega^2 dt / 2 I in a body that turns, which keeps its volume
                stretching = 0.5 * (L + L.transpose() + dt * (L.transpose() @ L))
                L += 0.5 * (stretching @ K + K @ stretching) - stretching
            A, growth, ratio = particle.deform(L, pack["ratio"][0][lane], dt)
            write_matrix_lane(pack["A"], lane, A)
            pack["growth"][0][lane], pack["ratio"][0][lane] = growth, ratio
            for a in ti.static(range(dim)):
                pack["x"][a][lane] += dt * inverse_dx * pack["v"][a][lane]

    @ti.func
    def report_pack(pack: ti.template(), first, count, k, report: ti.template()):
        bad = 0
        for lane in range(width):
            h, v = read_lane(pack["h"], lane), read_lane(pack["v"], lane)
            one = judged.judge(v, read_matrix_lane(pack["L"], lane), pack["growth"][0][lane], h,
                               read_lane(pack["tau"], lane), pack["work"][lane] * pack["volume"][0][lane],
                               pack["iterations"][lane])
            one[STRAIN] = h.norm_sqr()
            if ti.static(some_stiffen):
                one[STRAIN], one[WAVE2] = pack["strain"][0][lane], pack["wave2"][0][lane]
            one[STRAINED] = judged.strained(one[STRAIN])
            if ti.static(some_bonded):
                one[BREAKING] = pack["breaks"][0][lane]
            one[EXCURSION] = 0.0
            for a in ti.static(range(dim)):
                one[EXCURSION] += (v[a] - ti.cast(report.mean[a], real)) ** 2
            used = lane < count
            for c in ti.static(range(N_REPORT)):
                pack["most"][c][lane] = ti.select(used, one[c], 0.0)
        total = read_lane(pack["most"], 0)
        for lane in range(width):
            if pack["most"][BAD][lane] > 0.0:
                bad = first + lane + 1
        for lane in range(1, width):
            for c in ti.static(range(N_REPORT)):
                if ti.static(c in SUMMED):
                    total[c] += pack["most"][c][lane]
                else:
                    total[c] = larger(pack["most"][c][lane], total[c])
        for c in ti.static(range(N_REPORT)):
            report.of_packs[k, c] = ti.cast(total[c], ti.f64)
        report.of_packs[k, BAD] = ti.cast(bad, ti.f64)

    @ti.func
    def wave_speed(pack: ti.template(), lane, material, speeds: ti.template(), law_of: ti.template()):
        speed = ti.cast(speeds[material], real)
        if ti.static(some_stiffen):
            for k in ti.static(range(len(stiffens))):
                if ti.static(stiffens[k]):  # noqa: SIM102 (one is compile time)
                    if law_of[material] == k:
                        speed = ti.sqrt(pack["wave2"][0][lane])
        return speed

    @ti.func
    def write_pack(pack: ti.template(), first, count, particles: ti.template(), places, rows: ti.template(),
                   speeds: ti.template(), dx):
        for lane in range(count):
            p = first + lane
            x, v, tau = read_lane(pack["x"], lane), read_lane(pack["v"], lane), read_lane(pack["tau"], lane)
            own, ratio = ti.cast(particles.material[p], ti.i32), pack["ratio"][0][lane]
            access.store(particles.reals, places, p, at["position"], x)
            particle.store_motion(p, particles.reals, places, v, read_matrix_lane(pack["L"], lane))
            particle.store_response(p, particles.reals, places, read_lane(pack["h"], lane), tau,
                                    read_lane(pack["state"], lane), ratio)
            back = ti.Matrix.identity(real, dim)
            if ti.static(row_layout.full):
                back = read_matrix_lane(pack["back"], lane)
            L, volume = dx * read_matrix_lane(pack["L"], lane), pack["volume"][0][lane] / dx**dim
            density, speed = particles.materials[own, DENSITY], wave_speed(pack, lane, own, speeds, particles.law_of)
            store_row(p, rows.source, ti.static(Shown(x, v, L, tau, ratio, volume, density, speed)), back)

    @ti.func
    def update_pack(pack: ti.template(), k, lists: ti.template(), particles: ti.template(), places,
                    rows: ti.template(), report: ti.template(), step: ti.template()):
        first, count = lists.table[k, FIRST], lists.table[k, COUNT]
        read_pack(pack, first, count, particles.reals, places, rows.moved)
        begin = k * lists.capacity
        for q in range(lists.n_runs[k]):
            end = k * lists.capacity + lists.runs[k * lists.most_runs + q, 1]
            add_run(pack, lists.runs[k * lists.most_runs + q, 0], begin, end, rows.moved, lists)
            begin = end
        deform_pack(pack, step.dt, 1.0 / step.dx)
        apply_laws(pack, first, count, particles.material, particles.materials, particles.law_of, step.dt)
        report_pack(pack, first, count, k, report)
        write_pack(pack, first, count, particles, places, rows, step.speeds, step.dx)

    @grouped_kernel(real, plain=True)
    def update(lists: Lists, particles: ParticleArrays, rows: RowTables, report: Report, step: Step, n_packs: int,
               chunk_bounds: Array):
        if ti.static(width == 1):
            for k in range(n_packs):
                blank, count_blank = ti.Vector.zero(real, width), ti.Vector.zero(ti.i32, width)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)} | {
                    "work": blank, "iterations": count_blank}
                update_pack(pack, k, lists, particles, access.places(particles.reals, particles.slot_offset), rows,
                            report, step)
        else:
            ti.loop_config(serialize=serial)
            for i in range(chunks(chunk_bounds)):
                if is_worker(i):
                    begin, end = chunk(i, chunk_bounds)
                    places = access.places(particles.reals, particles.slot_offset)
                    blank, count_blank = ti.Vector.zero(real, width), ti.Vector.zero(ti.i32, width)
                    pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)} | {
                        "work": blank, "iterations": count_blank}
                    for k in range(begin, end):
                        update_pack(pack, k, lists, particles, places, rows, report, step)
        # Another launch would cost what a thousand particles do
        ti.loop_config(serialize=ti.static(in_order()))
        for i in range(partial_sums(n_packs)):
            judged.add_rows(report.of_packs, i, n_packs, report.total)

    return update
