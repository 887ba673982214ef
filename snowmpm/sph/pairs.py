"""Taichi functions that every sum over neighbours uses: lanes of a pack, entries of symmetric tensors."""

import functools
from types import SimpleNamespace

import taichi as ti


@functools.cache
def pair_functions(layout):
    """Functions for a `RowLayout`: place, velocity and tensor of a neighbour as a pack sees it (mirrored or not)."""
    dim, pairs, n_stress = layout.dim, layout.pairs, layout.n_stress

    @ti.func
    def signs(reals: ti.template(), c):
        return ti.Vector([reals[c, a] for a in ti.static(range(dim))])

    @ti.func
    def place(reals: ti.template(), c, row):
        """Position of a row [cells] from the pack's block, by candidate c."""
        return ti.Vector([reals[c, a] * row[a] + reals[c, dim + a] for a in ti.static(range(dim))])

    @ti.func
    def vector(sign, row, at: ti.template()):
        return ti.Vector([sign[a] * row[at + a] for a in ti.static(range(dim))])

    @ti.func
    def tensor(sign, row, at: ti.template()):
        return ti.Vector([sign[pairs[k][0]] * sign[pairs[k][1]] * row[at + k] for k in ti.static(range(n_stress))])

    @ti.func
    def times(S, d):
        """S d of a packed symmetric tensor."""
        product = d * 0.0
        for k in ti.static(range(n_stress)):
            a, b = ti.static(pairs[k])
            product[a] += S[k] * d[b]
            if ti.static(a != b):
                product[b] += S[k] * d[a]
        return product

    return SimpleNamespace(signs=signs, place=place, vector=vector, tensor=tensor, times=times)
