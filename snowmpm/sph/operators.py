"""Differential operators and filters of fields on particles (Bui & Nguyen 2021, section 2.2, equation numbers theirs).

With d = x_j - x_i and a weight w of each pair, the sums M0 = sum w, M1 = sum w d, M2 = sum w d d^T, B0 = sum w (f_j -
f_i), B1 = sum w d (f_j - f_i) give, for w = -V_j W'/r (so that grad_i W = -(W'/r) d),

    gradient             B1                                          (20)
    corrected_gradient   G = M2^-1 B1                                (21) exact for linear f
    plain_laplacian      2 B0                                        (31)
    laplacian            2 (B0 - M1 . G) / K,   K = tr M2 / dim      (39) exact for linear f

and for w = V_j W

    coverage             M0 of the others: half of it is missing at a free surface
    shepard              f + B0 / M0
    mls                  f + (B0 - M1 . M2^-1 B1) / (M0 - M1 . M2^-1 M1)    linear f pass unchanged

The isotropic K of (39) leaves an error in x^2 - y^2 and x y on disordered particles, which (31) has a hundred times
larger, and growing with resolution.
"""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker, runs_serially
from snowmpm.compiler.runtime import DTYPES
from snowmpm.materials.packs import read_lane
from snowmpm.sph.lengths import kernel_functions
from snowmpm.sph.neighbours import COUNT, FIRST, Lists
from snowmpm.sph.pairs import pair_functions

SLOPES = ("gradient", "corrected_gradient", "plain_laplacian", "laplacian")
FILTERS = ("coverage", "shepard", "mls")
LEAST_PIVOT = 1e-6
"""Determinant of M2 relative to (tr M2 / dim)^dim below which a neighbourhood is flat, and has no inverse."""


def results(kind, dim):
    """Number of results that an operator has for each field and particle: dim for gradients, else 1."""
    return dim if kind in ("gradient", "corrected_gradient") else 1


@functools.cache
def operator_kernel(layout, real, width, support, kind, parity):
    """Kernel that applies the operator `kind` over the particles and their mirror images.

    width: lanes of a pack; support: `lengths.Support`. parity: for each field the axes whose
    mirror turns its sign. Dummies have no values, and do not count.
    """
    dim, n_fields = layout.dim, len(parity)
    pair, serial = pair_functions(layout), runs_serially()
    smooth = kernel_functions(support, dim)
    columns = (("x", dim), ("f", n_fields), ("m0", 1), ("m1", dim), ("m2", dim * dim), ("b0", n_fields),
               ("b1", n_fields * dim), ("V", 1))

    @ti.func
    def inverse(m2):
        """Inverse of M2, zero for flat neighbourhoods."""
        scale = ti.max(m2.trace() / dim, 1e-20)
        determinant = (m2 / scale).determinant()
        sound = ti.abs(determinant) > LEAST_PIVOT
        safe = ti.select(sound, m2 / scale, ti.Matrix.identity(real, dim))
        return ti.select(sound, safe.inverse() / scale, ti.Matrix.zero(real, dim, dim))

    @ti.func
    def add_run(pack: ti.template(), c, begin, end, moved: ti.template(), fields: ti.template(),
                lists: ti.template()):
        """Add the neighbours entries[begin:end], seen by candidate c, to the sums of a pack."""
        sign = pair.signs(lists.reals, c)
        for e in range(begin, end):
            j = lists.entries[e]
            row = moved[j]
            xj, Vj, fj = pair.place(lists.reals, c, row), row[2 * dim], fields[j]
            for q in ti.static(range(n_fields)):
                for a in ti.static(parity[q]):
                    fj[q] *= sign[a]
            for lane in range(width):
                d = xj - read_lane(pack["x"], lane)
                r, b = ti.sqrt(d.norm_sqr()), ti.cast(1.0, real)
                if ti.static(smooth.varies):
                    b = smooth.narrowing(smooth.own(pack["V"][0][lane]), smooth.own(Vj))
                w = Vj * smooth.weight(r, b) if ti.static(kind in FILTERS) else -Vj * smooth.slope_over_r(r, b)
                pack["m0"][0][lane] += w
                for a in ti.static(range(dim)):
                    pack["m1"][a][lane] += w * d[a]
                    for b in ti.static(range(dim)):
                        pack["m2"][a * dim + b][lane] += w * d[a] * d[b]
                for q in ti.static(range(n_fields)):
                    gain = w * (fj[q] - pack["f"][q][lane])
                    pack["b0"][q][lane] += gain
                    for a in ti.static(range(dim)):
                        pack["b1"][q * dim + a][lane] += gain * d[a]

    @ti.func
    def conclude(pack: ti.template(), lane, row, out: ti.template()):
        """Write the operator of one lane, from its sums, to out[row]."""
        m2 = ti.Matrix([[pack["m2"][a * dim + b][lane] for b in ti.static(range(dim))] for a in ti.static(range(dim))])
        m1, m0, back = read_lane(pack["m1"], lane), pack["m0"][0][lane], inverse(m2)
        for q in ti.static(range(n_fields)):
            b0 = pack["b0"][q][lane]
            b1 = ti.Vector([pack["b1"][q * dim + a][lane] for a in ti.static(range(dim))])
            if ti.static(kind == "gradient"):
                for a in ti.static(range(dim)):
                    out[row, q * dim + a] = b1[a]
            elif ti.static(kind == "corrected_gradient"):
                slope = back @ b1
                for a in ti.static(range(dim)):
                    out[row, q * dim + a] = slope[a]
            elif ti.static(kind == "plain_laplacian"):
                out[row, q] = 2.0 * b0
            elif ti.static(kind == "laplacian"):
                out[row, q] = 2.0 * (b0 - m1.dot(back @ b1)) / ti.max(m2.trace() / dim, 1e-20)
            elif ti.static(kind == "coverage"):
                V, b = pack["V"][0][lane], ti.cast(1.0, real)
                if ti.static(smooth.varies):
                    b = 1.0 / smooth.own(V)
                out[row, q] = m0 - V * smooth.weight(ti.cast(0.0, real), b)
            elif ti.static(kind == "shepard"):
                out[row, q] = pack["f"][q][lane] + b0 / ti.max(m0, 1e-20)
            else:
                lower = m0 - m1.dot(back @ m1)
                out[row, q] = pack["f"][q][lane] + (b0 - m1.dot(back @ b1)) / ti.max(lower, 1e-6 * m0 + 1e-20)

    @grouped_kernel(real, plain=True)
    def operate(lists: Lists, moved: Array, fields: Array, out: Array, first_dummy: int, n_packs: int,
                chunk_bounds: Array):
        ti.loop_config(serialize=serial)
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first_pack, last_pack = chunk(i, chunk_bounds)
                blank = ti.Vector.zero(real, width)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                for k in range(first_pack, last_pack):
                    first, count = lists.table[k, FIRST], lists.table[k, COUNT]
                    for lane in range(width):
                        p = first + ti.min(lane, count - 1)
                        row, own = moved[p], fields[p]
                        for a in ti.static(range(dim)):
                            pack["x"][a][lane], pack["m1"][a][lane] = row[a], 0.0
                        for q in ti.static(range(n_fields)):
                            pack["f"][q][lane], pack["b0"][q][lane] = own[q], 0.0
                        for q in ti.static(range(n_fields * dim)):
                            pack["b1"][q][lane] = 0.0
                        for q in ti.static(range(dim * dim)):
                            pack["m2"][q][lane] = 0.0
                        pack["m0"][0][lane], pack["V"][0][lane] = 0.0, row[2 * dim]
                    begin = k * lists.capacity
                    for q in range(lists.n_runs[k]):
                        c = lists.runs[k * lists.most_runs + q, 0]
                        end = k * lists.capacity + lists.runs[k * lists.most_runs + q, 1]
                        if lists.entries[begin] < first_dummy:
                            add_run(pack, c, begin, end, moved, fields, lists)
                        begin = end
                    for lane in range(count):
                        conclude(pack, lane, first + lane, out)

    return operate


class Operators:
    """Operators with one smoothing kernel, on the particles of a solver and their present neighbours."""

    def __init__(self, rows, near, first_dummy, precision, *smoothing):
        """rows: `Rows`; near: `Neighbourhood`; first_dummy: row from which on there are no values; smoothing: lanes of
        a pack, `lengths.Support`."""
        self._rows, self._near, self._first_dummy = rows, near, first_dummy
        self._real, self._numpy_real = DTYPES[precision]
        self._smoothing = smoothing

    def of(self, kind, values, parity=None):
        """Apply one operator to k fields on the particles, and return the result as a NumPy array.

        kind: one of SLOPES or FILTERS. values (n,), which is k = 1, or (n, k): one row a particle, in the order of the
        rows. parity: for each field the axes whose mirror turns its sign; none by default.
        Returns (n, k, dim) for "gradient" and "corrected_gradient" [unit of the values per cell], (n, k) for all others
        (Laplacians [per cell2], "coverage" [-], filters in the unit of the values).
        Raises ValueError before the particles have been sorted.
        """
        if not self._near.known:
            raise ValueError("the particles must be sorted first")
        values = np.asarray(values)
        values = values.reshape(len(values), -1)
        (n, k), dim = values.shape, self._rows.layout.dim
        fields = ti.ndarray(ti.types.vector(k, self._real), (max(1, n),))
        fields.from_numpy(np.ascontiguousarray(values, self._numpy_real))
        out = np.zeros((max(1, n), k * results(kind, dim)), self._numpy_real)
        self.write(kind, fields, out, parity or ((),) * k)
        return out[:n].reshape(n, k, dim) if results(kind, dim) > 1 else out[:n]

    def write(self, kind, fields, out, parity):
        """Apply the operator `kind` to `fields`, n vectors of k numbers, and write it to `out` (n, k * results).

        parity: as in `of`, one entry a field.
        """
        packs = self._near.packs
        operator_kernel(self._rows.layout, self._real, *self._smoothing, kind, tuple(parity))(
            self._near.of_particles, self._rows.moved, fields, out, self._first_dummy, packs.n, packs.chunk_bounds)
