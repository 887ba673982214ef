"""Smoothing of the elastic strains of the particles, and so of their stresses, against noise.

    shepard, mls    h_i <- mean or linear fit of the neighbours', every so many steps (Bui & Nguyen 2021, Eq. 113)
    diffusion       h_i <- h_i + xi c h dt lap h_i in every step, h the smoothing length

h = b_e - I, which the law reads and makes the stress from: a stress that is smoothed alone would not be that of any
strain. In the mirror of a side the shear strains across it change their sign.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.runtime import DTYPES
from snowmpm.particles.store import accessors


@functools.cache
def column_kernels(layout, real):
    """`take(reals, slot_offset, fields, count)`: elastic strains of the particles as vectors, one each;
    `give(reals, slot_offset, out, kept_share, share, count)`: h <- kept_share h + share out."""
    access, first, n = accessors(layout), layout.offsets["elastic"], layout.sym_size

    @taichi_kernel
    def take(reals: ti.types.ndarray(), slot_offset: int, fields: ti.types.ndarray(), count: int):
        for p in range(count):
            fields[p] = access.load(reals, access.places(reals, slot_offset), p, first, n)

    @taichi_kernel
    def give(reals: ti.types.ndarray(), slot_offset: int, out: ti.types.ndarray(), kept_share: real, share: real,
             count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            h = kept_share * access.load(reals, places, p, first, n)
            for c in ti.static(range(n)):
                h[c] += share * out[p, c]
            access.store(reals, places, p, first, h)

    return take, give


class Regularisation:
    """Of the particles of one store, as the scheme asks for it."""

    def __init__(self, scheme, layout, pairs, precision):
        """scheme: `snowmpm.scenes.Sph`; layout: of the particles; pairs: axes of the entries of a stress (`RowLayout`);
        precision: "f32" or "f64"."""
        self.kind, self.interval = scheme.regularisation, scheme.regularisation_interval
        self._diffusion, self._length, self._n = scheme.diffusion, scheme.smoothing, layout.sym_size
        self._take, self._give = column_kernels(layout, DTYPES[precision][0])
        self._real = DTYPES[precision][0]
        self._parity = ((), (), (), *((a, b) for a, b in pairs if a != b))
        self._fields = self._out = None

    def due(self, step):
        """Whether step number `step`, from 1, smooths."""
        return self.kind != "none" and (self.kind == "diffusion" or step % self.interval == 0)

    def smooth(self, store, operate, courant):
        """Smooth once. operate(kind, fields, out, parity): the operators of `sph.operators`; courant: c dt / dx."""
        n = store.count
        if self._fields is None or self._fields.shape[0] < n:
            self._fields = ti.ndarray(ti.types.vector(self._n, self._real), (max(1, n),))
            self._out = ti.ndarray(self._real, (max(1, n), self._n))
        self._take(store.reals, store.slot_offset, self._fields, n)
        diffuses = self.kind == "diffusion"
        operate("laplacian" if diffuses else self.kind, self._fields, self._out, self._parity)
        # In cells
        share = self._diffusion * self._length * courant if diffuses else 1.0
        self._give(store.reals, store.slot_offset, self._out, float(diffuses), share, n)
