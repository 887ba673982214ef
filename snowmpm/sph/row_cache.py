"""Rows of particles (`sph.rows`) from the store, before the first step and after a sort or a change by others."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.response import response_functions
from snowmpm.particles.store import accessors
from snowmpm.sph.lengths import kernel_functions
from snowmpm.sph.moment import inverse_function
from snowmpm.sph.neighbours import COUNT, FIRST
from snowmpm.sph.pairs import pair_functions
from snowmpm.sph.row_writing import row_functions


@functools.cache
def row_kernels(layout, row_layout, real, laws, kernel, radius, lengths, form, tension, volumes):
    """`write_rows(...)`, which fills the rows, and `correct(...)`, which makes their S what a `full` layout wants.

    tension, volumes: as `row_functions` takes them.
    """
    dim, sym_size, access, at = layout.dim, layout.sym_size, accessors(layout), layout.offsets
    pair, inverse = pair_functions(row_layout), inverse_function(dim, real)
    smooth = kernel_functions(kernel, radius, lengths, dim)
    stiffnesses = [law.stiffness for law in laws]
    stiffens = [function is not None for function in stiffnesses]
    particle = response_functions(layout, real, laws)
    store_row = row_functions(layout, row_layout, real, form, tension, volumes)

    @taichi_kernel
    def write_rows(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(),
                   materials: ti.types.ndarray(), law_of: ti.types.ndarray(), speeds: ti.types.ndarray(),
                   source: ti.types.ndarray(), moved: ti.types.ndarray(), dx: real, count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            own = ti.cast(material[p], ti.i32)
            tau, L = access.load(reals, places, p, at["stress"], sym_size), ti.Matrix.zero(real, dim, dim)
            slopes = access.load(reals, places, p, at["affine"], dim * dim)
            for a in ti.static(range(dim)):
                for b in ti.static(range(dim)):
                    L[a, b] = slopes[a * dim + b]
            state = access.load(reals, places, p, at["state"], layout.state_size)
            speed = ti.cast(speeds[own], real)
            for k in ti.static(range(len(stiffens))):
                if ti.static(stiffens[k]):  # noqa: SIM102 (one is compile time)
                    if law_of[own] == k:
                        modulus = stiffnesses[k](particle.parameters_of(k, materials, own), tau, state)
                        speed = ti.sqrt(modulus / materials[own, DENSITY])
            store_row(p, source, ti.Matrix.identity(real, dim), access.load(reals, places, p, at["position"], dim),
                      access.load(reals, places, p, at["velocity"], dim), dx * L, tau,
                      access.load(reals, places, p, at["volume_ratio"], 1)[0],
                      access.load(reals, places, p, at["volume"], 1)[0] / dx**dim, materials[own, DENSITY], speed)
            for a in ti.static(range(2 * dim)):
                moved[p][a] = source[p][a]
            moved[p][2 * dim] = source[p][row_layout.at["V"]]

    @taichi_kernel
    def correct(table: ti.types.ndarray(), source: ti.types.ndarray(), entries: ti.types.ndarray(),
                runs: ti.types.ndarray(), n_runs: ti.types.ndarray(), signs: ti.types.ndarray(), capacity: int,
                most_runs: int, n_packs: int):
        """S K^-1 for S in rows that `write_rows` filled."""
        for k in range(n_packs):
            for lane in range(table[k, COUNT]):
                i, K, begin = table[k, FIRST] + lane, ti.Matrix.zero(real, dim, dim), k * capacity
                x = ti.Vector([source[i][a] for a in ti.static(range(dim))])
                for q in range(n_runs[k]):
                    c, end = runs[k * most_runs + q, 0], k * capacity + runs[k * most_runs + q, 1]
                    for e in range(begin, end):
                        row = source[entries[e]]
                        d, V, b = pair.place(signs, c, row) - x, row[row_layout.at["V"]], ti.cast(1.0, real)
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
        store, materials = self._particles, self._particles.materials
        self._write_rows(store.reals, store.slot_offset, store.material, materials.numbers, materials.law_of,
                         self._speeds, self._rows.source, self._rows.moved, self._dx, store.count)
        self._seen, self._bare = store.changes, True

    def correct(self, packs, lists):
        """Make them so where `write_rows` has written them since."""
        if self._bare and self._rows.layout.full:
            self._correct(packs.table, self._rows.source, *lists.arguments, packs.n)
        self._bare = False

    def restored(self):
        """The rows have come from a checkpoint."""
        self._seen, self._bare = self._particles.changes, False

    @property
    def current_rows(self):
        """Rows of the particles as they are (n, columns)."""
        return self._rows.source.to_numpy()[: self._particles.count].copy()  # of all rows most may be dummies
