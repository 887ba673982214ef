"""Kernels whose arguments are groups: the same numbers as of flat ones, with all that stands around them."""

from typing import NamedTuple

import numpy as np
import pytest

from snowmpm.compiler import patches, ti
from snowmpm.compiler.groups import Array, Real, Vectors, grouped_kernel


class Sums(NamedTuple):
    """Numbers, and where they go."""

    values: Array
    total: Array
    n: int


class Line(NamedTuple):
    slope: Real
    offset: Real


@ti.func
def at(line: ti.template(), x):
    return line.slope * x + line.offset


def summing(real, factor):
    """Kernel of what it is defined among: an argument of the outer function, and a Taichi function of the module."""

    @grouped_kernel(real)
    def sum_up(sums: Sums, line: Line, start: Real):
        """Its docstring
        has two lines."""
        sums.total[0] = start
        ti.loop_config(serialize=True)
        for i in range(sums.n):
            sums.total[0] += factor * at(line, sums.values[i])

    return sum_up


@pytest.mark.parametrize("real", [ti.f32, ti.f64])
@pytest.mark.parametrize("patched", [True, False])
def test_groups_arrive_by_name(real, patched, monkeypatch):
    if not patched:
        monkeypatch.setattr(patches, "is_applied", lambda name: False)
    dtype = np.float32 if real == ti.f32 else np.float64
    values, total = np.arange(5, dtype=dtype), np.zeros(1, dtype)
    for factor in (1.0, 3.0):
        summing(real, factor)(Sums(values, total, 4), Line(2.0, 0.5), 10.0)
        assert total[0] == 10.0 + factor * (2.0 * 6.0 + 4 * 0.5)


def test_vectors_and_arrays_stand_alone_too():
    @grouped_kernel(ti.f64)
    def double(vectors: Vectors, out: Array):
        for i in range(2):
            out[i] = 2.0 * vectors[i][3]

    vectors, out = ti.ndarray(ti.types.vector(4, ti.f64), 2), np.zeros(2)
    vectors.from_numpy(np.arange(8.0).reshape(2, 4))
    double(vectors, out)
    assert out.tolist() == [6.0, 14.0]


def test_a_group_that_lacks_a_field_is_refused():
    with pytest.raises(TypeError, match="slope"):
        Line(offset=1.0)
    with pytest.raises(TypeError, match="missing 1 required"):
        summing(ti.f64, 1.0)(Sums(np.zeros(1), np.zeros(1), 1), Line(1.0, 0.0))
