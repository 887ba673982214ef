"""What dummy particles show: stress and velocity of the particles near them, carried on into the solid.

Sums over particles j near dummy k, with weights V_j W_jk / sum V W (Shepard; Adami et al. 2012,
doi:10.1016/j.jcp.2012.05.005; Favero Neto & Borja 2018, doi:10.1007/s11440-018-0700-3, Eq. 28):

    sigma_k = <sigma> - <rho> g . (x_k - <x>) I - <rho> n.(x_k - <x>) (g_t n^T + n g_t^T)
    sigma_k = that, its normal component n.sigma.n the most compressive one nearby         walls = "most_compressive"

g_t: the part of gravity along the wall, where it sticks: there the stress on planes along it grows towards it by the
weight of what lies between, sideways too. Carried on without that, sigma n would be too small behind a slope, and the
stresses of rows would lie above and below their mean in turns, on slopes by 1.5 rho g_t dx, as sums over both sides
allow; snow near its strength then yields in every other row.

(Peng et al. 2015 take the components along the axes, which is the same at walls along the axes only). The velocity
follows a straight line through that of the wall at its surface, at the distances D_k = depth of the dummy and
<D> = mean height of the particles:

    v_k = v_w - (D_k / <D>) (<v> - v_w)                                            stick
    v_k = <v> + (v_w - <v> - (D_k / <D>) (<v> - v_w)).n n                          slip, separate

A dummy of a surface that separates takes no part while its particles leave it without pressing.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.materials.packs import read_lane
from snowmpm.sph.dummy_rows import Walls
from snowmpm.sph.lengths import kernel_functions
from snowmpm.sph.neighbours import COUNT, FIRST, Lists
from snowmpm.sph.pairs import pair_functions
from snowmpm.stepping.contact_velocity import SEPARATE, STICK

STEEPEST = 1.5
"""Bound of D_k / <D>: a lone particle at the surface would give deep dummies any speed."""

LEAST_SHARE = 1e-3
"""Sum of V W below which a dummy has no particles that it could follow."""


@functools.cache
def extrapolation_kernel(layout, real, width, support, form, wall_stress, moved_rows, serial):
    """Kernel that fills the rows of dummies: `source` rows, or with moved_rows the velocity of `moved` rows alone.
    serial: by one thread."""
    dim, at, n_stress, pairs = layout.dim, layout.at, layout.n_stress, layout.pairs
    pair = pair_functions(layout)
    smooth = kernel_functions(support, dim)
    columns = (("x", dim), ("n", dim), ("sum", 1), ("sum_x", dim), ("sum_v", dim), ("sum_S", n_stress), ("rho", 1),
               ("z", 1), ("least", 1))

    @ti.func
    def read_pack(pack: ti.template(), first, count, rows: ti.template(), walls: ti.template()):
        for lane in range(width):
            k = first + ti.min(lane, count - 1)
            for a in ti.static(range(dim)):
                pack["x"][a][lane], pack["n"][a][lane] = rows[k][a], walls.frames[k - walls.first_dummy][a]
                pack["sum_x"][a][lane], pack["sum_v"][a][lane] = 0.0, 0.0
            for s in ti.static(range(n_stress)):
                pack["sum_S"][s][lane] = 0.0
            pack["sum"][0][lane], pack["rho"][0][lane], pack["z"][0][lane] = 0.0, 0.0, 0.0
            pack["least"][0][lane] = 0.0

    @ti.func
    def add_run(pack: ti.template(), c, begin, end, rows: ti.template(), lists: ti.template()):
        sign = pair.signs(lists.reals, c)
        for e in range(begin, end):
            row = rows[lists.entries[e]]
            xj, vj = pair.place(lists.reals, c, row), pair.vector(sign, row, dim)
            Vj = row[2 * dim] if ti.static(moved_rows) else row[at["V"]]
            Sj, rho, z = ti.Vector.zero(real, n_stress), ti.cast(0.0, real), ti.cast(0.0, real)
            if ti.static(not moved_rows):
                rho, z = row[at["m"]] / row[at["V"]], row[at["z"]]
                Sj = pair.symmetric(pair.force(sign, row))
                if ti.static(form in ("density", "corrected")):
                    Sj *= rho * rho
            b = ti.cast(1.0, real)
            if ti.static(smooth.varies):  # dummies lie a spacing apart
                b = smooth.narrowing(ti.cast(1.0, real), smooth.own(Vj))
            for lane in range(width):
                d = read_lane(pack["x"], lane) - xj
                near = Vj * smooth.weight(ti.sqrt(d.norm_sqr()), b)
                pack["sum"][0][lane] += near
                for a in ti.static(range(dim)):
                    pack["sum_x"][a][lane] -= near * d[a]
                    pack["sum_v"][a][lane] += near * vj[a]
                if ti.static(not moved_rows):
                    pack["rho"][0][lane] += near * rho
                    pack["z"][0][lane] += near * z
                    for s in ti.static(range(n_stress)):
                        pack["sum_S"][s][lane] += near * Sj[s]
                    if ti.static(wall_stress == "most_compressive"):
                        n = read_lane(pack["n"], lane)
                        along = n.dot(pair.times(Sj, n))
                        pack["least"][0][lane] = ti.select((near > 0.0) & (along < pack["least"][0][lane]), along,
                                                           pack["least"][0][lane])

    @ti.func
    def write_dummy(pack: ti.template(), lane, k, rows: ti.template(), source: ti.template(), walls: ti.template(),
                    gravity: ti.template(), dx):
        frame, row = walls.frames[k - walls.first_dummy], rows[k]
        n = ti.Vector([frame[a] for a in ti.static(range(dim))])
        v_wall = ti.Vector([frame[dim + 1 + a] for a in ti.static(range(dim))])
        depth, volume = frame[dim], frame[2 * dim + 1]
        code = ti.cast(walls.surfaces[walls.surface_of[k - walls.first_dummy], 0], ti.i32)
        total = pack["sum"][0][lane]
        near = 1.0 / ti.max(total, LEAST_SHARE)
        v, away = near * read_lane(pack["sum_v"], lane), near * read_lane(pack["sum_x"], lane)
        height = ti.max(away.dot(n) - depth, 0.2)
        steep = ti.min(depth / height, STEEPEST)
        slip = v - v_wall
        v_dummy = v_wall - steep * slip
        if code != STICK:
            v_dummy = v - (1.0 + steep) * slip.dot(n) * n
        for a in ti.static(range(dim)):
            row[dim + a] = v_dummy[a]
        if ti.static(moved_rows):
            row[2 * dim] = source[k][at["V"]]
        else:
            S, rho = near * read_lane(pack["sum_S"], lane), near * pack["rho"][0][lane]
            if ti.static(wall_stress == "most_compressive"):
                gain = pack["least"][0][lane] - n.dot(pair.times(S, n))
                for s in ti.static(range(n_stress)):
                    S[s] += gain * n[pairs[s][0]] * n[pairs[s][1]]
            lift = ti.cast(0.0, real)
            for a in ti.static(range(dim)):
                lift += rho * dx * ti.cast(gravity[a], real) * away[a]
            for s in ti.static(range(dim)):
                S[s] += lift
            if code == STICK:
                g = ti.Vector([ti.cast(gravity[a], real) for a in ti.static(range(dim))])
                drag = rho * dx * away.dot(n) * (g - g.dot(n) * n)
                for s in ti.static(range(n_stress)):
                    a, b = ti.static(pairs[s])
                    S[s] += drag[a] * n[b] + n[a] * drag[b]
            active = total > LEAST_SHARE
            if code == SEPARATE:
                active = active and (n.dot(pair.times(S, n)) < 0.0 or slip.dot(n) < 0.0)
            if ti.static(form in ("density", "corrected")):
                S /= ti.max(rho * rho, 1e-30)
            for s in ti.static(range(n_stress)):
                shown = ti.select(active, S[s], 0.0)
                if ti.static(layout.full):
                    a, b = ti.static(pairs[s])
                    row[at["S"] + a * dim + b], row[at["S"] + b * dim + a] = shown, shown
                else:
                    row[at["S"] + s] = shown
                if ti.static(layout.tension):
                    row[at["R"] + s] = 0.0
            row[at["V"]] = ti.select(active, volume, 0.0)
            row[at["m"]] = ti.select(active, rho * volume, 0.0)
            row[at["z"]] = near * pack["z"][0][lane]
        rows[k] = row

    @ti.func
    def extrapolate_pack(pack: ti.template(), k, lists: ti.template(), rows: ti.template(), source: ti.template(),
                         walls: ti.template(), gravity: ti.template(), dx):
        first, count = lists.table[k, FIRST], lists.table[k, COUNT]
        read_pack(pack, first, count, rows, walls)
        begin = k * lists.capacity
        for q in range(lists.n_runs[k]):
            end = k * lists.capacity + lists.runs[k * lists.most_runs + q, 1]
            add_run(pack, lists.runs[k * lists.most_runs + q, 0], begin, end, rows, lists)
            begin = end
        for lane in range(count):
            write_dummy(pack, lane, first + lane, rows, source, walls, gravity, dx)

    @grouped_kernel(real, plain=True)
    def extrapolate(lists: Lists, rows: Array, source: Array, walls: Walls, gravity: Array, dx: Real, n_packs: int,
                    chunk_bounds: Array):
        if ti.static(width == 1):
            for k in range(n_packs):
                blank = ti.Vector.zero(real, width)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                extrapolate_pack(pack, k, lists, rows, source, walls, gravity, dx)
        else:
            ti.loop_config(serialize=serial)
            for i in range(chunks(chunk_bounds)):
                if is_worker(i):
                    begin, end = chunk(i, chunk_bounds)
                    blank = ti.Vector.zero(real, width)
                    pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                    for k in range(begin, end):
                        extrapolate_pack(pack, k, lists, rows, source, walls, gravity, dx)

    return extrapolate


class Extrapolation:
    """Lets the dummies of a `Boundary` follow the particles near them."""

    def __init__(self, rows, near, boundary, gravity, dx, kernels):
        """rows: `Rows`; near: `Neighbourhood`; gravity: array (dim,) [m/s2]; kernels: `extrapolation_kernel`s of all
        columns, and of velocities alone."""
        self._rows, self._near, self._boundary, self._gravity, self._dx = rows, near, boundary, gravity, dx
        self._all, self._velocities = kernels

    def extrapolate_all(self):
        """Stress, mass, volume and velocity, before the sum of forces."""
        self._extrapolate(self._all, self._rows.source)

    def extrapolate_velocities(self):
        """The velocities that forces have led to, before the velocity gradients."""
        self._extrapolate(self._velocities, self._rows.moved)

    def _extrapolate(self, kernel, rows):
        packs = self._near.dummy_packs
        if packs is not None and packs.n:
            kernel(self._near.dummy_lists.of(packs), rows, self._rows.source, self._boundary.walls, self._gravity,
                   self._dx, packs.n, packs.chunk_bounds)
