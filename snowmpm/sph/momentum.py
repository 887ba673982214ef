"""The momentum sum: forces of neighbours and walls on every particle, and the kick of its velocity.

    m_i a_i = sum_j m_i m_j (sigma_i / rho_i^2 + sigma_j / rho_j^2 - Pi_ij I) . grad_i W_ij + m_i g        "density"
    the same with sigma K^-1 for sigma, K that of the velocity gradient (`update`)                         "corrected"
    m_i a_i = sum_j V_i V_j (sigma_i + sigma_j - ...) . grad_i W_ij + m_i g                                "volume"
    m_i a_i = sum_j V_i V_j (sigma_j - sigma_i - ...) . grad_i W_ij + m_i g                                "difference"

The first three are antisymmetric in i and j and conserve momentum to round-off; "corrected" does the work of the
corrected velocity gradient (Bonet & Lok 1999, doi:10.1016/S0045-7825(99)00051-1), and so keeps the stiffness of free
surfaces, of which the others lose a part. The last is exact for uniform stress, and unstable (Bui & Nguyen 2021, Fig.
8): a negative control. Pi_ij: `viscosity`. Artificial stress (Gray, Monaghan & Swift 2001,
doi:10.1016/S0045-7825(01)00254-7): ((W(r) / W(dx))^n - c) (R_i + R_j) beside the stresses, c its mean over the pairs of
a lattice, as the sum weighs them.
Without c the sum takes away a share epsilon c of every tension, and with it of the stiffness: 0.58 epsilon at h = 1.5
dx, which bends a beam a fifth too far.

Confinement (Bui & Nguyen, Eq. 123): a_i += 2 p / rho_i sum_j V_j grad_i W_ij, what a stress -p all over would push back
with, on any arrangement. They let it act on the free surface alone, told by the sum of V W of others; layers below the
first then lack what balances theirs.

Forces of each surface are summed apart, and it says what becomes of them (`surface_forces`).
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker
from snowmpm.materials.packs import read_lane
from snowmpm.sph.candidates import SURFACE
from snowmpm.sph.dummy_rows import Walls
from snowmpm.sph.lengths import kernel_functions
from snowmpm.sph.neighbours import COUNT, FIRST, Lists
from snowmpm.sph.pairs import pair_functions
from snowmpm.sph.rows import RowTables
from snowmpm.sph.smoothing import KERNELS
from snowmpm.sph.surface_forces import surface_functions, tally_width
from snowmpm.sph.tallies import Sums
from snowmpm.sph.viscosity import viscosity_functions

INTO = {"plain": "f", "mirror": "wall", "dummies": "wall"}
"""Column of a pack to which the rows of a run are added, by how they are seen."""


class Step(NamedTuple):
    """gravity (dim) [m/s2]; loads, of which n_loads rows count; dx [m], dt [s]; damping: factor of the velocities."""

    gravity: Array
    loads: Array
    n_loads: int
    dx: Real
    dt: Real
    damping: Real


class Factors(NamedTuple):
    """Of the linear and the quadratic viscosity, and of that of disorder; confining pressure [Pa], and the sum of V W
    below which a particle is at the free surface."""

    alpha: Real
    beta: Real
    gamma: Real
    pressure: Real
    threshold: Real


class Terms(NamedTuple):
    """Form of the sum; n of the artificial stress; how dummy particles get their stress; whether walls stop what comes
    too close, whether there is a confining pressure, whether a quadratic viscosity."""

    form: str
    power: float
    wall_stress: str
    barrier: bool
    confined: bool
    viscous: bool


@functools.cache
def momentum_kernel(layout, real, width, support, terms, serial):
    """Kernel for a `RowLayout` and `width` lanes. support: `lengths.Support`; terms: `Terms`; serial: by one thread."""
    (kernel, radius, _), (form, power, wall_stress, barrier, confined, viscous) = support, terms
    dim, at, n_stress, n_force = layout.dim, layout.at, layout.n_stress, len(layout.force_pairs)
    mask = layout.row_mask
    pair = pair_functions(layout)
    smooth, half_power = kernel_functions(support, dim), round(2.0 * power)
    viscosity = viscosity_functions(radius / KERNELS[kernel].reach, viscous)
    weight_of, _ = KERNELS[kernel].functions(radius, dim)
    w_spacing = float(KERNELS[kernel].weight(1.0, radius, dim))
    even = KERNELS[kernel].lattice_share(radius, dim, power) if layout.tension else 0.0
    w_self = float(KERNELS[kernel].weight(0.0, radius, dim))
    surface_forces, n_tally = surface_functions(dim, real, width, barrier), tally_width(dim)
    columns = (("x", dim), ("v", dim), ("S", n_force), ("R", n_stress * layout.tension),
               ("D", n_stress * layout.ordered), ("m", 1), ("V", 1), ("z", 1),
               ("ratio", 1), ("f", dim), ("inner", dim), ("wall", dim), ("earlier", dim), ("normal", dim),
               ("wall_v", dim), ("share", 1), ("height", 1), ("cover", 1), ("edge", dim), ("s", int(smooth.varies)))

    @ti.func
    def read_pack(pack: ti.template(), first, count, source: ti.template()):
        for lane in range(width):
            row = source[first + ti.min(lane, count - 1)]
            for a in ti.static(range(dim)):
                pack["x"][a][lane], pack["v"][a][lane] = row[a], row[dim + a]
                pack["f"][a][lane], pack["inner"][a][lane], pack["edge"][a][lane] = 0.0, 0.0, 0.0
                pack["earlier"][a][lane] = 0.0
            for k in ti.static(range(n_force)):
                pack["S"][k][lane] = row[at["S"] + k]
            for k in ti.static(range(n_stress)):
                if ti.static(layout.tension):
                    pack["R"][k][lane] = row[at["R"] + k]
                if ti.static(layout.ordered):
                    pack["D"][k][lane] = row[at["D"] + k]
            pack["m"][0][lane], pack["V"][0][lane], pack["z"][0][lane] = row[at["m"]], row[at["V"]], row[at["z"]]
            pack["ratio"][0][lane] = row[at["V"]] / row[at["m"]]
            pack["cover"][0][lane] = 0.0
            if ti.static(smooth.varies):
                pack["s"][0][lane] = smooth.own(row[at["V"]])

    @ti.func
    def add_run(pack: ti.template(), seen: ti.template(), run, rows: ti.template(), lists: ti.template(),
                walls: ti.template(), factors: ti.template()):
        """Sum of the rows of one run into a column of the pack (`INTO`), of dummies also where they face.

        run: candidate, first and last entry.
        """
        dummies = ti.static(seen == "dummies")
        c, sign = run[0], ti.Vector.one(real, dim)
        if ti.static(seen != "plain"):
            sign = pair.signs(lists.reals, c)
        for e in range(run[1], run[2]):
            j = lists.entries[e]
            row = rows.source[j & mask]
            xj, vj, Sj = pair.place(lists.reals, c, row), pair.vector(sign, row, at["v"]), pair.force(sign, row)
            Rj, Dj = ti.Vector.zero(real, n_stress), ti.Vector.zero(real, n_stress)
            if ti.static(layout.tension):
                Rj = pair.tensor(sign, row, at["R"])
            if ti.static(layout.ordered):
                Dj = pair.tensor(sign, row, at["D"])
            mj, Vj, zj = row[at["m"]], row[at["V"]], row[at["z"]]
            sj = smooth.own(Vj) if ti.static(smooth.varies) else ti.cast(1.0, real)
            nj, uj, depth = xj * 0.0, xj * 0.0, xj[0] * 0.0
            if ti.static(dummies):
                frame = walls.frames[j - walls.first_dummy]
                nj, uj, depth = pair.vector(sign, frame, 0), pair.vector(sign, frame, dim + 1), frame[dim]
            for lane in range(width):
                d = read_lane(pack["x"], lane) - xj
                r2 = d.norm_sqr()
                r, b = ti.sqrt(r2), ti.cast(1.0, real)
                if ti.static(smooth.varies):
                    b = smooth.narrowing(pack["s"][0][lane], sj)
                F = smooth.slope_over_r(r, b)
                ratio = pack["ratio"][0][lane]
                Si = read_lane(pack["S"], lane)
                sum_S = Si + Sj
                if ti.static(dummies and wall_stress == "copied"):
                    sum_S = 2.0 * Si
                elif ti.static(form == "difference"):
                    sum_S = Sj - Si
                pair_mass, stress_term = mj, pair.times_force(sum_S, d)
                if ti.static(form in ("volume", "difference")):
                    pair_mass = Vj * ratio
                closing, z = (read_lane(pack["v"], lane) - vj).dot(d), pack["z"][0][lane] + zj
                if ti.static(smooth.varies):  # h s in place of h
                    closing *= b
                    r2 *= b * b
                viscous_pressure = viscosity.artificial(closing, r2, Vj, mj, ratio, z, factors.alpha, factors.beta)
                if ti.static(layout.ordered and not dummies):
                    orderly = 0.5 * d.dot(pair.times(read_lane(pack["D"], lane) + Dj, d))
                    if ti.static(smooth.varies):
                        orderly *= b
                    viscous_pressure += viscosity.disorder(closing - orderly, r2, Vj, ratio, z, factors.gamma)
                if ti.static(layout.tension):
                    f = weight_over_spacing(r * b)
                    amplified = f
                    if ti.static(2.0 * power == half_power):
                        f = ti.sqrt(f) if ti.static(half_power % 2 == 1) else f
                        amplified = f
                        for _ in ti.static(range((half_power if half_power % 2 == 1 else half_power // 2) - 1)):
                            amplified *= f
                    else:
                        amplified = ti.pow(f, power)
                    stress_term += (amplified - even) * pair.times(read_lane(pack["R"], lane) + Rj, d)
                force = F * (pair_mass * stress_term - viscous_pressure * d)
                for a in ti.static(range(dim)):
                    pack[INTO[seen]][a][lane] += force[a]
                if ti.static(dummies):
                    near = -F * Vj
                    pack["share"][0][lane] += near
                    pack["height"][0][lane] += near * (d.dot(nj) - depth)
                    for a in ti.static(range(dim)):
                        pack["normal"][a][lane] += near * nj[a]
                        pack["wall_v"][a][lane] += near * uj[a]
                if ti.static(confined):
                    pack["cover"][0][lane] += Vj * smooth.weight(r, b)
                    for a in ti.static(range(dim)):
                        pack["edge"][a][lane] += Vj * F * d[a]

    @ti.func
    def weight_over_spacing(r):
        return weight_of(r) / w_spacing

    @ti.func
    def confine(pack: ti.template(), pressure, threshold):
        for lane in range(width):
            own = pack["V"][0][lane] * w_self
            if ti.static(smooth.varies):
                own /= pack["s"][0][lane] ** dim
            covered = pack["cover"][0][lane] - own
            confining = ti.select(covered < threshold, 2.0 * pressure * pack["ratio"][0][lane], 0.0)
            for a in ti.static(range(dim)):
                pack["inner"][a][lane] += confining * pack["edge"][a][lane]

    @ti.func
    def accelerate(pack: ti.template(), k, lists: ti.template(), rows: ti.template(), walls: ti.template(),
                   tallies: ti.template(), step: ti.template(), factors: ti.template()):
        first, count = lists.table[k, FIRST], lists.table[k, COUNT]
        tally, inverse_dx = tallies.of[k], 1.0 / step.dx
        g = ti.Vector([ti.cast(step.gravity[a], real) for a in ti.static(range(dim))])
        if tally >= 0:
            for s in range(walls.surfaces.shape[0]):
                for q in ti.static(range(n_tally)):
                    tallies.sums[tally, s, q] = 0.0
        read_pack(pack, first, count, rows.source)
        begin, current, mirror = k * lists.capacity, -1, 0
        for q in range(lists.n_runs[k]):
            c, end = lists.runs[k * lists.most_runs + q, 0], k * lists.capacity + lists.runs[k * lists.most_runs + q, 1]
            surface, run = lists.ints[c, SURFACE], ti.Vector([c, begin, end])
            if surface != current:
                if current < 0:
                    write_inner(pack)
                else:
                    surface_forces.apply_contact(pack, k, current, mirror, lists, walls, tallies, step)
                surface_forces.clear(pack)
                current = surface
            if surface < 0:
                add_run(pack, "plain", run, rows, lists, walls, factors)
            elif walls.surfaces[surface, 2] > 0.0:
                mirror = 1
                add_run(pack, "mirror", run, rows, lists, walls, factors)
            else:
                mirror = 0
                add_run(pack, "dummies", run, rows, lists, walls, factors)
            begin = end
        if current < 0:
            write_inner(pack)
        else:
            surface_forces.apply_contact(pack, k, current, mirror, lists, walls, tallies, step)
        if ti.static(confined):
            confine(pack, factors.pressure, factors.threshold)
        if step.n_loads > 0:
            surface_forces.apply_loads(pack, k, lists, tallies, step)
        for lane in range(count):
            row = ti.Vector.zero(real, layout.moved_width)
            for a in ti.static(range(dim)):
                row[a] = pack["x"][a][lane]
                row[dim + a] = step.damping * (
                    pack["v"][a][lane] + step.dt * (inverse_dx * pack["inner"][a][lane] + g[a]))
            row[2 * dim] = pack["V"][0][lane]
            rows.moved[first + lane] = row

    @ti.func
    def write_inner(pack: ti.template()):
        for lane in range(width):
            for a in ti.static(range(dim)):
                pack["inner"][a][lane] = pack["f"][a][lane]

    @grouped_kernel(real, plain=True)
    def kick(lists: Lists, rows: RowTables, walls: Walls, tallies: Sums, step: Step, factors: Factors, n_packs: int,
             chunk_bounds: Array):
        if ti.static(width == 1):
            for k in range(n_packs):
                blank = ti.Vector.zero(real, width)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                accelerate(pack, k, lists, rows, walls, tallies, step, factors)
        else:
            ti.loop_config(serialize=serial)
            for i in range(chunks(chunk_bounds)):
                if is_worker(i):
                    begin, end = chunk(i, chunk_bounds)
                    blank = ti.Vector.zero(real, width)
                    pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                    for k in range(begin, end):
                        accelerate(pack, k, lists, rows, walls, tallies, step, factors)
        ti.loop_config(serialize=ti.static(in_order()))
        for t in range(tallies.n):
            for s in range(tallies.total.shape[0]):
                for q in ti.static(range(n_tally)):
                    tallies.total[s, q] += tallies.sums[t, s, q]

    return kick
