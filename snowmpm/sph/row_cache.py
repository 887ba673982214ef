"""Rows of particles (`sph.rows`) from the store, before the first step and after a sort or a change by others."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.particles.arrays import ParticleArrays
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.response import response_functions
from snowmpm.particles.store import accessors
from snowmpm.sph.lengths import kernel_functions
from snowmpm.sph.moment import inverse_function
from snowmpm.sph.neighbours import COUNT, FIRST, Lists
from snowmpm.sph.pairs import pair_functions
from snowmpm.sph.row_writing import Shown, row_functions
from snowmpm.sph.rows import RowTables


@functools.cache
def row_kernels(layout, row_layout, real, laws, support, form, tension, volumes):
    """`write_rows(...)`, which fills the rows, and `correct(...)`, which makes their S what a `full` layout wants.

    tension, volumes: as `row_functions` takes them.
    """
    dim, sym_size, access, at = layout.dim, layout.sym_size, accessors(layout), layout.offsets
    pair, inverse = pair_functions(row_layout), inverse_function(dim, real)
    smooth = kernel_functions(support, dim)
    stiffnesses = [law.stiffness for law in laws]
    stiffens = [function is not None for function in stiffnesses]
    particle = response_functions(layout, real, laws)
    store_row = row_functions(layout, row_layout, real, form, tension, volumes)

    @grouped_kernel(real)
    def write_rows(particles: ParticleArrays, rows: RowTables, speeds: Array, dx: Real, count: int):
        for p in range(count):
            places = access.places(particles.reals, particles.slot_offset)
            own = ti.cast(particles.material[p], ti.i32)
            tau = access.load(particles.reals, places, p, at["stress"], sym_size)
            slopes, L = access.load(particles.reals, places, p, at["affine"], dim * dim), ti.Matrix.zero(real, dim, dim)
            for a in ti.static(range(dim)):
                for b in ti.static(range(dim)):
                    L[a, b] = dx * slopes[a * dim + b]
            state = access.load(particles.reals, places, p, at["state"], layout.state_size)
            density, speed = particles.materials[own, DENSITY], ti.cast(speeds[own], real)
            for k in ti.static(range(len(stiffens))):
                if ti.static(stiffens[k]):  # noqa: SIM102 (one is compile time)
                    if particles.law_of[own] == k:
                        modulus = stiffnesses[k](particle.parameters_of(k, particles.materials, own), tau, state)
                        speed = ti.sqrt(modulus / density)
            x = access.load(particles.reals, places, p, at["position"], dim)
            v = access.load(particles.reals, places, p, at["velocity"], dim)
            ratio = access.load(particles.reals, places, p, at["volume_ratio"], 1)[0]
            volume = access.load(particles.reals, places, p, at["volume"], 1)[0] / dx**dim
            store_row(p, rows.source, ti.static(Shown(x, v, L, tau, ratio, volume, density, speed)),
                      ti.Matrix.identity(real, dim))
            for a in ti.static(range(2 * dim)):
                rows.moved[p][a] = rows.source[p][a]
            rows.moved[p][2 * dim] = rows.source[p][row_layout.at["V"]]

    @grouped_kernel(real)
    def correct(lists: Lists, source: Array, n_packs: int):
        """S K^-1 for S in rows that `write_rows` filled."""
        for k in range(n_packs):
            for lane in range(lists.table[k, COUNT]):
                i, K, begin = lists.table[k, FIRST] + lane, ti.Matrix.zero(real, dim, dim), k * lists.capacity
                x = ti.Vector([source[i][a] for a in ti.static(range(dim))])
                for q in range(lists.n_runs[k]):
                    c = lists.runs[k * lists.most_runs + q, 0]
                    end = k * lists.capacity + lists.runs[k * lists.most_runs + q, 1]
                    for e in range(begin, end):
                        row = source[lists.entries[e]]
                        d, V, b = pair.place(lists.reals, c, row) - x, row[row_layout.at["V"]], ti.cast(1.0, real)
                        if ti.static(smooth.varies):
                            b = smooth.narrowing(smooth.own(source[i][row_layout.at["V"]]), smooth.own(V))
                        K -= V * smooth.slope_over_r(ti.sqrt(d.norm_sqr()), b) * d.outer_product(d)
                    begin = end
                back, S = inverse(K), ti.Matrix.zero(real, dim, dim)
                for a in ti.static(range(dim)):
                    for b in ti.static(range(dim)):
                        S[a, b] = source[i][row_layout.at["S"] + a * dim + b]
                S = S @ back
                for a in ti.static(range(dim)):
                    for b in ti.static(range(dim)):
                        source[i][row_layout.at["S"] + a * dim + b] = S[a, b]

    return write_rows, correct


class RowCache:
    """Keeps the rows those of the particles: written anew when others have changed these."""

    def __init__(self, rows, particles, kernels, speeds, dx):
        """rows: `Rows`; particles: `SortedParticles`; kernels: `row_kernels`; speeds: of waves in each material
        [m/s]."""
        self._rows, self._particles, self._speeds, self._dx = rows, particles, speeds, dx
        self._write_rows, self._correct = kernels
        self._seen, self._bare = None, False

    @property
    def current(self):
        """Whether the rows are those of the particles as they are."""
        return self._seen == self._particles.changes

    def write_rows(self):
        """Write the rows, with stresses that `correct` has yet to make those of a `full` layout."""
        store = self._particles
        self._write_rows(store.arrays, self._rows.tables, self._speeds, self._dx, store.count)
        self._seen, self._bare = store.changes, True

    def correct(self, packs, lists):
        """Make them so where `write_rows` has written them since."""
        if self._bare and self._rows.layout.full:
            self._correct(lists.of(packs), self._rows.source, packs.n)
        self._bare = False

    def restored(self):
        """The rows have come from a checkpoint."""
        self._seen, self._bare = self._particles.changes, False

    @property
    def current_rows(self):
        """Rows of the particles as they are (n, columns)."""
        return self._rows.source.to_numpy()[: self._particles.count].copy()  # of all rows most may be dummies
