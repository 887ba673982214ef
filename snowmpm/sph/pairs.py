"""Taichi functions that every sum over neighbours uses: lanes of a pack, entries of symmetric tensors."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti


@functools.cache
def pair_functions(layout):
    """Functions for a `RowLayout`: place, velocity and tensor of a neighbour as a pack sees it (mirrored or not)."""
    dim, pairs, n_stress, force_pairs = layout.dim, layout.pairs, layout.n_stress, layout.force_pairs
    first = layout.at["S"]

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

    @ti.func
    def force(sign, row):
        """S of a neighbour, as rows carry it."""
        return ti.Vector([sign[force_pairs[k][0]] * sign[force_pairs[k][1]] * row[first + k]
                          for k in ti.static(range(len(force_pairs)))])

    @ti.func
    def symmetric(S):
        """The symmetric part of S as rows carry it, packed."""
        result = ti.Vector.zero(float, n_stress)
        for k in ti.static(range(n_stress)):
            if ti.static(layout.full):
                a, b = ti.static(pairs[k])
                result[k] = 0.5 * (S[a * dim + b] + S[b * dim + a])
            else:
                result[k] = S[k]
        return result

    @ti.func
    def times_force(S, d):
        """S d of S as rows carry it."""
        product = d * 0.0
        if ti.static(layout.full):
            for k in ti.static(range(len(force_pairs))):
                product[force_pairs[k][0]] += S[k] * d[force_pairs[k][1]]
        else:
            product = times(S, d)
        return product

    return SimpleNamespace(force=force, symmetric=symmetric, times_force=times_force, signs=signs, place=place,
                           vector=vector, tensor=tensor, times=times)
