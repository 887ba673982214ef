"""Formulas in a scene: arithmetic of positions, velocities and time, parsed without executing the text.

A formula is refused unless it consists of numbers, the names below and the operations below. Python's interpreter never
executes it: `Formula.compiled` walks the syntax tree.

    + - * / **, unary -, comparisons (1 where true, else 0), A if C else B
    x, y, z [m], t [s], vx, vy, vz [m/s], pi
    sin cos tan exp log sqrt abs tanh floor min(a, b) max(a, b) step(a, b, s): 0 below a, 1 above b, smooth between
"""

import ast
import functools
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from snowmpm.errors import did_you_mean
from snowmpm.scenes.space import AXES, dimension
from snowmpm.scenes.spec import SIZES, refuse

LONGEST = 400
"""Largest number of characters of a formula."""
MOST_PARTS = 150
"""Largest number of numbers, names and operations in a formula."""


def _step(low, high, s):
    with np.errstate(all="ignore"):
        u = np.clip((s - low) / (high - low), 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


FUNCTIONS = {
    "sin": (np.sin, 1), "cos": (np.cos, 1), "tan": (np.tan, 1), "exp": (np.exp, 1), "log": (np.log, 1),
    "sqrt": (np.sqrt, 1), "abs": (np.abs, 1), "tanh": (np.tanh, 1), "floor": (np.floor, 1), "min": (np.minimum, 2),
    "max": (np.maximum, 2), "step": (_step, 3),
}
OPERATORS = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power,
    ast.Lt: np.less, ast.LtE: np.less_equal, ast.Gt: np.greater, ast.GtE: np.greater_equal,
    ast.USub: np.negative, ast.UAdd: np.positive,
}


def variables(dim):
    """Names that a formula in a scene of this dimension may use, in the order of the arguments."""
    axes = AXES[dim]
    return (*axes, *(f"v{axis}" for axis in axes), "t")


@functools.lru_cache(maxsize=256)
def compiled(text, dim):
    """Function of the `variables` of this dimension, arrays or numbers, that a formula stands for; its `names`.

    Raises ValueError, whose text says what is wrong and what is allowed.
    """
    if len(text) > LONGEST:
        raise ValueError(f"must have at most {LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError('must be a formula such as "2.0*sin(3.0*t)"') from None
    if sum(1 for _ in ast.walk(tree)) > 2 * MOST_PARTS:
        raise ValueError(f"must have at most {MOST_PARTS} numbers, names and operations")
    function = _function(tree, variables(dim))
    function.names = frozenset(node.id for node in ast.walk(tree) if isinstance(node, ast.Name))
    return function


def _function(node, names):
    """Function of the values of `names` that a node stands for."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return _number(node.value)
    if isinstance(node, ast.Name):
        if node.id == "pi":
            return lambda *values: np.pi
        if node.id not in names:
            raise ValueError(f"{node.id}: a formula knows {', '.join([*names, 'pi', *FUNCTIONS])}"
                             f"{did_you_mean(node.id, [*names, 'pi', *FUNCTIONS])}")
        place = names.index(node.id)
        return lambda *values: values[place]
    if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATORS:
        return _applied(OPERATORS[type(node.op)], [node.operand], names)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        return _applied(OPERATORS[type(node.op)], [node.left, node.right], names)
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in OPERATORS:
        true = _applied(OPERATORS[type(node.ops[0])], [node.left, node.comparators[0]], names)
        return lambda *values: np.multiply(true(*values), 1.0)
    if isinstance(node, ast.IfExp):
        return _applied(lambda c, a, b: np.where(np.not_equal(c, 0.0), a, b), [node.test, node.body, node.orelse],
                        names)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        function, count = FUNCTIONS.get(node.func.id, (None, 0))
        if function is None:
            raise ValueError(f"{node.func.id}: a formula has the functions {', '.join(FUNCTIONS)}"
                             f"{did_you_mean(node.func.id, FUNCTIONS)}")
        if len(node.args) != count:
            raise ValueError(f"{node.func.id} takes {count} number{'s' * (count > 1)}")
        return _applied(function, node.args, names)
    raise ValueError("a formula is made of numbers, names, + - * / **, comparisons, A if C else B and functions")


def _number(value):
    if value and not SIZES[0] <= abs(value) <= SIZES[1]:
        raise ValueError(f"a number of it is out of reach: sizes are from {SIZES[0]:g} to {SIZES[1]:g}")
    number = np.float64(value)
    return lambda *values: number


def _applied(function, arguments, names):
    parts = [_function(argument, names) for argument in arguments]
    return lambda *values: function(*(part(*values) for part in parts))


def _check(text):
    try:
        compiled(text, dimension() or 3)
    except ValueError as error:
        raise refuse(str(error)) from None
    return text


Formula = Annotated[str, Field(strict=True), AfterValidator(_check)]
"""Text that is a formula of `variables` (see the module)."""
