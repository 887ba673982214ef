"""Trees of functions that are parsed once for a kernel: calls in calls, recursion, closures, and where an error is."""

import inspect

import numpy as np
import pytest

from snowmpm.compiler import (
    function_trees,  # noqa: F401 (what is tested)
    ti,
)

pytestmark = pytest.mark.usefixtures("taichi")


@ti.func
def twice(x):
    return 2 * x


@ti.func
def power(x, n: ti.template()):
    """xⁿ, by itself: its tree is gone through while it is being gone through."""
    result = x
    if ti.static(n > 1):
        result = x * power(x, n - 1)
    return result


def plus(number):
    @ti.func
    def add(x):
        return x + number

    return add


def test_a_function_called_in_its_own_argument_and_by_itself():
    @ti.kernel
    def compute(values: ti.types.ndarray()):
        values[0] = twice(twice(3) + twice(4))
        values[1] = power(power(2, 2), 3) + power(3, 4)

    values = np.zeros(2, np.int32)
    compute(values)
    np.testing.assert_array_equal(values, [2 * (6 + 8), 64 + 81])


def test_functions_of_one_source_keep_what_they_close_over():
    one, ten = plus(1), plus(10)

    @ti.kernel
    def compute(values: ti.types.ndarray()):
        values[0] = one(0) + ten(one(ten(0)))

    values = np.zeros(1, np.int32)
    compute(values)
    assert values[0] == 1 + 21


def test_an_error_names_file_line_and_function():
    @ti.func
    def wrong(x):
        return x + missing  # noqa: F821

    @ti.kernel
    def compute(values: ti.types.ndarray()):
        values[0] = wrong(1)

    lines, first = inspect.getsourcelines(test_an_error_names_file_line_and_function)
    line = first + next(i for i, text in enumerate(lines) if "+ missing" in text)
    with pytest.raises(ti.TaichiCompilationError, match=rf"test_function_trees.py\", line {line}, in wrong") as raised:
        compute(np.zeros(1, np.int32))
    assert 'Name "missing" is not defined' in str(raised.value)
