"""A kernel that reads beyond an array (see test_array_bounds.py); Taichi wants the source of a kernel in a file."""

from snowmpm.compiler import ti


@ti.kernel
def past_the_end(a: ti.types.ndarray()) -> ti.i32:
    return a[a.shape[0]]
