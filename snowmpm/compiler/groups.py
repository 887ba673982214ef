"""Kernels whose arguments come in groups with names.

    class Lists(NamedTuple):
        entries: Array
        capacity: int

    @grouped_kernel(real)
    def kick(lists: Lists, dt: Real):
        ... lists.entries[k * lists.capacity] ...

    kick(Lists(entries, capacity), dt)

Taichi knows flat lists of arguments only. A kernel with groups is therefore written anew when it is defined: each group
becomes its fields, `lists_entries, lists_capacity`, and the first lines of the body put them together again, at compile
time. What Taichi compiles is the same as of a flat kernel. Functions take a group whole, as ti.template().
"""

import functools
import inspect
import linecache
import types
from typing import TYPE_CHECKING, Any, TypeAlias

from snowmpm.compiler.backend import ti
from snowmpm.compiler.function_trees import source_of
from snowmpm.compiler.launch import grouped, taichi_kernel

if TYPE_CHECKING:  # what Taichi makes of them knows all that kernels ask
    Array: TypeAlias = Any
    Vectors: TypeAlias = Any
    Real: TypeAlias = Any
    Double: TypeAlias = Any
else:

    class Array:
        """Of the annotation of a field or an argument: an array of numbers."""

    class Vectors:
        """An array of vectors of four numbers of the kernel's precision."""

    class Real:
        """A number of the kernel's precision."""

    class Double:
        """A number in double precision."""


def grouped_kernel(real, plain=False):
    """Decorator: a `taichi_kernel` of a function whose arguments are groups, arrays and numbers. real: its precision;
    plain: by `plain_compilation`.

    Each argument is annotated with a NamedTuple, with `Array`, `Vectors`, `Real`, `Double` or int; so are the fields of
    a NamedTuple.
    """
    kinds = {Array: ti.types.ndarray(), Real: real, Double: ti.f64, int: int,
             Vectors: ti.types.ndarray(dtype=ti.types.vector(4, real), ndim=1)}

    def decorate(function):
        groups = {name: _fields(annotation) for name, annotation in inspect.get_annotations(function).items()}
        kernel = taichi_kernel(_flat(function, groups, kinds), plain)
        return functools.wraps(function)(grouped(kernel, [fields is None for fields in groups.values()]))

    return decorate


def _fields(annotation):
    """{field: annotation} of a NamedTuple, None of anything else."""
    return annotation.__annotations__ if hasattr(annotation, "_fields") else None


def _flat(function, groups, kinds):
    """The function with the fields of its groups as arguments."""
    annotations, lines = {}, []
    for name, fields in groups.items():
        if fields is None:
            annotations[name] = kinds[function.__annotations__[name]]
            continue
        annotations |= {f"{name}_{field}": kinds[kind] for field, kind in fields.items()}
        members = ", ".join(f"{name}_{field}" for field in fields)
        lines.append(f"{name} = _static(_{name}({members}))")
    code = function.__code__
    text, first = source_of(code)
    body = [*("        " + line for line in lines), *("    " + line for line in text[first:])]
    free = ", ".join(code.co_freevars)
    file = f"{code.co_filename}, {function.__qualname__} with its groups"
    source = f"def outer({free}):\n    def {function.__name__}({', '.join(annotations)}):\n" + "\n".join(body) + "\n"
    linecache.cache[file] = len(source), None, source.splitlines(keepends=True), file
    outer = next(part for part in compile(source, file, "exec").co_consts if isinstance(part, types.CodeType))
    inner = next(part for part in outer.co_consts if isinstance(part, types.CodeType))
    cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
    space = {**function.__globals__, "_static": ti.static,
             **{f"_{name}": function.__annotations__[name] for name, fields in groups.items() if fields}}
    flat = types.FunctionType(inner, space, function.__name__, None, tuple(cells[name] for name in inner.co_freevars))
    flat.__annotations__, flat.__qualname__, flat.__module__ = annotations, function.__qualname__, function.__module__
    return flat
