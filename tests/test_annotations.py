"""What the public modules export has complete annotations, and so has what it hands out."""

import ast
import functools
import importlib
import inspect
import textwrap
import types
import typing

import pytest

from snowmpm.materials.law import Law

PUBLIC = ("snowmpm", "snowmpm.materials", "snowmpm.scenes", "snowmpm.render")
SPECIAL = {"__init__", "__call__", "__getitem__", "__contains__", "__iter__", "__len__"}

INNER = {"CrackRecord", "MaterialTable", "Model", "SortedParticles"}
"""What a simulation is made of behind its contracts: nothing is followed into them."""


def is_ours(thing):
    return getattr(thing, "__module__", "").startswith("snowmpm")


def written(name):
    return name in SPECIAL or not name.startswith("_")


def function_of(member):
    """The Python function of a method or property, None of what is none, such as a Taichi function."""
    for wrapper, inner in ((property, "fget"), (functools.cached_property, "func"), (staticmethod, "__func__"),
                           (classmethod, "__func__")):
        if isinstance(member, wrapper):
            member = getattr(member, inner)
    if hasattr(member, "_is_taichi_function") or not callable(member):
        return None
    member = inspect.unwrap(member)
    return member if inspect.isfunction(member) and is_ours(member) else None


def missing_of_function(function):
    signature = inspect.signature(function)
    found = [name for k, (name, parameter) in enumerate(signature.parameters.items())
             if parameter.annotation is parameter.empty and not (k == 0 and name in ("self", "cls"))]
    return found + (["return"] if signature.return_annotation is signature.empty else [])


def methods_of(cls):
    """(name, function) of what a class defines itself."""
    for name, member in vars(cls).items():
        function = function_of(member) if written(name) else None
        # Functions that a data class writes for itself have no file
        if function is not None and function.__code__.co_filename != "<string>":
            yield name, function


def attributes_of(cls):
    """Public names that methods of a class set on `self`."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(cls)))
    targets = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)]
    return {node.attr for node in targets if isinstance(node.value, ast.Name) and node.value.id == "self"
            and not node.attr.startswith("_")}


def bare(annotation):
    """Whether an annotation says nothing of what a container holds."""
    return annotation in (dict, list, tuple, set, object, "dict", "list", "tuple", "object")


def missing_of_class(cls):
    found = [f"{cls.__name__}.{name}: {', '.join(missing)}" for name, function in methods_of(cls)
             if (missing := missing_of_function(function))]
    declared = {name: kind for one in cls.__mro__ for name, kind in vars(one).get("__annotations__", {}).items()}
    unsaid = {name for name in attributes_of(cls) if name not in declared and not hasattr(cls, name)}
    unsaid |= {name for name, kind in vars(cls).get("__annotations__", {}).items() if written(name) and bare(kind)}
    return found + [f"{cls.__name__}.{name}" for name in sorted(unsaid)]


def classes_in(annotation, module):
    """Classes of ours that an annotation names, text within it included."""
    if isinstance(annotation, str | typing.ForwardRef):
        text = annotation if isinstance(annotation, str) else annotation.__forward_arg__
        names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
        found = (named(name, module) for name in names)
        return {one for one in found if inspect.isclass(one) and is_ours(one)}
    inner = [one for part in typing.get_args(annotation) for one in classes_in(part, module)]
    generic = typing.get_origin(annotation) is not None or isinstance(annotation, types.UnionType)
    return {*inner, annotation} if inspect.isclass(annotation) and is_ours(annotation) and not generic else {*inner}


def named(name, module):
    """What a name in a module means, also one that only type checkers import there."""
    if hasattr(module, name):
        return getattr(module, name)
    for node in ast.walk(ast.parse(inspect.getsource(module))):
        if isinstance(node, ast.ImportFrom) and any((one.asname or one.name) == name for one in node.names) \
                and node.module.startswith("snowmpm"):
            return getattr(importlib.import_module(node.module), name)
    return None


def handed_out(thing):
    """Classes that a function returns, or that a class's attributes and results are of."""
    if inspect.isclass(thing):
        kinds = [(kind, sys_module(one)) for one in thing.__mro__ if is_ours(one)
                 for name, kind in vars(one).get("__annotations__", {}).items() if written(name)]
        results = [function for one in thing.__mro__ if is_ours(one) for _, function in methods_of(one)]
        bases = {one for one in thing.__mro__ if is_ours(one)}
    else:
        kinds, results, bases = [], [function_of(thing)], set()
    kinds += [(function.__annotations__.get("return"), sys_module(function)) for function in results]
    return bases.union(*(classes_in(kind, module) for kind, module in kinds))


def sys_module(thing):
    return importlib.import_module(thing.__module__)


@functools.cache
def reached():
    """Functions that the public modules export, and all classes that one gets from them."""
    exported = [getattr(importlib.import_module(module), name) for module in PUBLIC
                for name in importlib.import_module(module).__all__]
    functions = [one for one in exported if function_of(one) is not None]
    queue = [one for one in exported if inspect.isclass(one)]
    queue += [type(value) for one in exported if isinstance(one, dict) for value in one.values()
              if is_ours(type(value))]
    queue += [one for function in functions for one in handed_out(function)]
    classes = set()
    while queue:
        cls = queue.pop()
        if cls not in classes and cls.__name__ not in INNER:
            classes.add(cls)
            queue += handed_out(cls)
    return functions, sorted(classes, key=lambda cls: (cls.__module__, cls.__name__))


def test_every_function_says_what_it_takes_and_gives():
    incomplete = {f"{one.__module__}.{one.__name__}": missing for one in reached()[0]
                  if (missing := missing_of_function(function_of(one)))}
    assert not incomplete


def test_every_class_that_one_gets_says_what_its_members_are():
    incomplete = {cls.__module__: missing for cls in reached()[1] if (missing := missing_of_class(cls))}
    assert not incomplete


def test_what_is_handed_out_is_found():
    names = {cls.__name__ for cls in reached()[1]}
    assert {"Run", "Frame", "Obstacle", "SawTest", "Method", "Motion", "ParticleFields", "Experiment", "Reached",
            "YieldSection", "Body"} <= names
    assert not INNER & names


def half_said(strain: float, stress) -> float:
    return strain


class HalfSaid(Law):
    speeds: list = []  # noqa: RUF012

    def __init__(self, speed: float) -> None:
        self.speed = speed

    def faster(self, by: float):
        return self.speed + by


@pytest.mark.parametrize("missing", ["HalfSaid.faster: return", "HalfSaid.speed", "HalfSaid.speeds"])
def test_a_member_without_annotation_is_found(missing, monkeypatch):
    monkeypatch.setattr(HalfSaid.faster, "__module__", "snowmpm.materials")
    monkeypatch.setattr(HalfSaid.__init__, "__module__", "snowmpm.materials")
    assert missing in missing_of_class(HalfSaid)


def test_an_argument_without_annotation_is_found():
    assert missing_of_function(half_said) == ["stress"]
