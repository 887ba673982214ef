"""No kernel and no Taichi function takes more than eight arguments: groups with names instead (`compiler.groups`).

What is left is listed with its reason. An entry whose function has been grouped, or is gone, fails as a new one does.
"""

import ast

import pytest

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from tests.support.project import ROOT

MOST = 8
FORMULA = "scalars of one formula, each with the name that the source gives it"
LAW = "what the update of a law takes and gives, as NumPy's arrays of tensors, of which each wants a type of its own"
EXCEPTIONS = {
    "materials/ellipse.py": (FORMULA, {"return_to_ellipse", "straight_step", "straight_point", "newton_step"}),
    "materials/rate_integration.py": (FORMULA, {"integrate"}),
    "materials/stress_update.py": (LAW, {"update_all", "update_packs"}),
}


def long_ones(path):
    """Names of the kernels and Taichi functions of a file with more arguments than `MOST`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef) and len(node.args.args) > MOST:
            decorators = [ast.unparse(decorator) for decorator in node.decorator_list]
            if any(one == "ti.func" or "kernel" in one for one in decorators):
                yield node.name


def test_kernels_and_functions_take_few_arguments():
    found = {}
    for folder in ("snowmpm", "materials"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if names := set(long_ones(path)):
                found[path.relative_to(ROOT).as_posix()] = names
    assert found == {file: names for file, (_, names) in EXCEPTIONS.items()}


def test_a_group_is_checked_when_a_kernel_is_defined():
    with pytest.raises(KeyError, match="float"):

        @grouped_kernel(ti.f64)
        def wrong(values: Array, factor: float):
            values[0] = factor
