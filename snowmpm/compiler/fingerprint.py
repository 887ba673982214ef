"""A digest of all that the source of a kernel may read while Taichi goes through it.

A kernel is a Python function: what it becomes follows from its source, from the functions that it calls, and from the
values of the names in all of them, those of modules and those of the functions around it. Two processes in which these
are alike make the same kernel. Files are taken whole: whoever edits one makes anew what is written in it.
"""

import collections
import enum
import functools
import hashlib
import linecache
import os
import types

import numpy as np

from snowmpm.compiler.backend import impl, ti

PLAIN = (type(None), bool, int, float, complex, str, bytes, np.generic)
DESCRIPTORS = (types.WrapperDescriptorType, types.MethodDescriptorType, types.ClassMethodDescriptorType,
               types.GetSetDescriptorType, types.MemberDescriptorType)
OF_EVERY_CLASS = ("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__", "_abc_impl",
                  "__dataclass_params__", "__dataclass_fields__")
OTHERS = ("builtins", "collections", "functools", "itertools", "math", "numpy", "operator", "typing", ti.__name__)
"""Packages of which the name of a function, class or module is enough: they change with their version."""


NOTHING: dict[str, object] = {}
Pair = collections.namedtuple("Pair", "one")


class Unknown(Exception):
    """A value that has no digest: what it holds cannot be told."""


def fingerprint(function, *more):
    """Digest of a Python function that is to become a kernel, and of `more` that the result depends on. Raises Unknown
    where something has none."""
    reader = _Reader()
    for value in (*more, function):
        reader.feed(value)
    return reader.digest.hexdigest()


class _Reader:
    def __init__(self):
        self.digest, self._met, self._kept = hashlib.sha256(), {}, []

    def feed(self, value):
        kind = type(value)
        if issubclass(kind, PLAIN):
            self._say(kind.__name__, repr(value))
        elif id(value) in self._met:
            self._say("met", str(self._met[id(value)]))
        else:
            self._met[id(value)] = len(self._met)
            self._kept.append(value)  # or its identity would be another's
            self._take(value, kind)

    def _say(self, *words):
        for word in words:
            self.digest.update(word.encode("utf-8", "surrogatepass") + b"\0")

    def _take(self, value, kind):
        own = vars(value) if "__dict__" in dir(value) else NOTHING
        if kind in (tuple, list):
            self._several(kind.__name__, value)
        elif kind in (set, frozenset):
            self._several("set", sorted(value, key=repr))
        elif kind is dict:
            self._several("dict", [part for item in value.items() for part in item])
        elif kind in (types.GenericAlias, types.UnionType) or kind.__module__ in ("typing", "collections.abc"):
            self._say("annotation", repr(value))
        elif isinstance(value, types.ModuleType):
            self._say("module", value.__name__)
        elif isinstance(value, types.MethodType):
            self._several("method", (value.__self__, value.__func__))
        elif kind is impl._ti_core.DataType:
            self._say("type", value.to_string())
        elif kind.__module__ == impl._ti_core.__name__ and "__members__" in dir(kind):
            self._say("member", str(value))
        elif "__wrapped__" in own:  # of a decorator: Taichi's, a cache
            self._several(kind.__name__, (own["__wrapped__"],))
        elif isinstance(value, functools.partial):
            self._several("partial", (value.func, value.args, value.keywords))
        elif isinstance(value, types.FunctionType):
            self._function(value)
        elif kind is type(Pair.one):  # of a named tuple
            self._say(repr(value))
        elif isinstance(value, types.BuiltinFunctionType):
            self._say("builtin", f"{value.__module__}.{value.__qualname__}")
        elif isinstance(value, DESCRIPTORS):
            self._say("descriptor", f"{value.__objclass__.__module__}.{value.__qualname__}")
        elif isinstance(value, type):
            self._class(value)
        elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
            self._say("array", str(value.dtype), str(value.shape))
            self.digest.update(np.ascontiguousarray(value).tobytes())
        elif isinstance(value, enum.Enum):
            self._several("member", (kind, value.name))
        elif isinstance(value, tuple):
            self._several("named", (kind, *value))
        elif isinstance(value, (property, staticmethod, classmethod)):
            self._several(kind.__name__, (value.fget if kind is property else value.__func__,))
        elif isinstance(value, functools.cached_property):
            self._several("cached", (value.func,))
        elif own is not NOTHING and not any("__slots__" in vars(base) for base in kind.__mro__):
            self._several("instance", (kind, dict(own)))
        else:
            raise Unknown(f"{kind.__module__}.{kind.__qualname__}")

    def _several(self, what, values):
        self._say(what, str(len(values)))
        for value in values:
            self.feed(value)

    def _class(self, value):
        self._say("class", value.__module__, value.__qualname__)
        if not _of_others(value):
            self._several("bases", value.__bases__)
            self._several("body", [part for item in vars(value).items() if item[0] not in OF_EVERY_CLASS
                                   for part in item])

    def _function(self, value):
        self._say("function", value.__module__ or "", value.__qualname__)
        if _of_others(value):
            return
        code, names = value.__code__, []
        _describe(code, self._say, names)
        self._several("usual", (value.__defaults__, value.__kwdefaults__, value.__annotations__))
        names = list(dict.fromkeys(names))
        space = {name: value.__globals__[name] for name in names if name in value.__globals__}
        space |= zip(code.co_freevars, [cell.cell_contents for cell in value.__closure__ or ()], strict=True)
        for name, part in space.items():
            self._say(name)
            self.feed(part)
            if isinstance(part, types.ModuleType) and not _among(part.__name__):
                for inner in names:
                    if inner in vars(part):
                        self._say(inner)
                        self.feed(vars(part)[inner])


def _describe(code, say, names):
    """Say what a code object is and collect the names that it and those within it read."""
    say("code", code.co_name, str(code.co_firstlineno), _file(code.co_filename), repr(code.co_varnames))
    say(code.co_code.hex())
    names += code.co_names
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _describe(constant, say, names)
        else:
            say(repr(sorted(constant, key=repr) if isinstance(constant, frozenset) else constant))


def _of_others(value):
    return _among(value.__module__ or "")


def _among(module):
    return module.partition(".")[0] in OTHERS


def _file(name):
    """Digest of a file of source."""
    try:
        state = os.stat(name)
        return _contents(name, state.st_mtime_ns, state.st_size)
    except OSError:  # text that was never in a file
        return hashlib.sha256("".join(linecache.getlines(name)).encode()).hexdigest()


@functools.cache
def _contents(name, changed, size):
    with open(name, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()
