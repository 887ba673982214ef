"""A few linear equations within a kernel."""

import functools

from snowmpm.compiler import ti

from .precision import by_precision


@functools.cache
def solve_equations(n):
    """Taichi function (matrix (n, n), right (n,)) -> x (n,): Gaussian elimination with partial pivoting."""

    @ti.func
    def solve(matrix, right):
        a, x = matrix, right
        for k in range(n):
            pivot = k
            for i in range(k + 1, n):
                if ti.abs(a[i, k]) > ti.abs(a[pivot, k]):
                    pivot = i
            for j in range(n):
                held = a[k, j]
                a[k, j] = a[pivot, j]
                a[pivot, j] = held
            other = x[k]
            x[k] = x[pivot]
            x[pivot] = other
            if ti.abs(a[k, k]) < ti.static(by_precision(1e-30, 1e-200)):
                a[k, k] += ti.static(by_precision(1e-30, 1e-200))
            for i in range(k + 1, n):
                share = a[i, k] / a[k, k]
                x[i] -= share * x[k]
                for j in range(k, n):
                    a[i, j] -= share * a[k, j]
        for back in range(n):
            k = n - 1 - back
            for j in range(k + 1, n):
                x[k] -= a[k, j] * x[j]
            x[k] /= a[k, k]
        return x

    return solve
