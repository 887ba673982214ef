"""A digest of all that the source of a kernel may read while Taichi goes through it.

A kernel is a Python function: what it becomes follows from its source, from the functions that it calls, and from the
values of the names in all of them, those of modules and those of the functions around it. Two processes in which these
are alike make the same kernel. Files are taken whole: whoever edits one makes anew what is written in it.

Whether two kernels are alike is decided for good by the digest, so only what is understood exactly has one. All else is
`Unknown`: objects of classes that are more than a table of attributes, modules that answer to names they do not hold,
functions that import.
"""

import collections
import dis
import enum
import functools
import hashlib
import linecache
import os
import re
import sys
import types

import numpy as np

from snowmpm.compiler.backend import impl, ti

PLAIN = (type(None), bool, int, float, complex, str, bytes)
OTHERS = ("builtins", "collections", "functools", "itertools", "math", "numpy", "operator", "typing", ti.__name__)
"""Packages of which the name of a function, class or module is enough: they change with their version."""

Pair = collections.namedtuple("Pair", "one")
BUILT_IN = 1 << 8
"""Flag of classes that are not written in Python (Py_TPFLAGS_IMMUTABLETYPE)."""
DESCRIPTORS = (types.WrapperDescriptorType, types.MethodDescriptorType, types.ClassMethodDescriptorType,
               types.GetSetDescriptorType, types.MemberDescriptorType)
OF_EVERY_CLASS = ("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__", "_abc_impl",
                  "__dataclass_params__", "__dataclass_fields__", "__static_attributes__", "__firstlineno__")
ANSWERS = ("__getattr__", "__getattribute__")

READS, PADDING = ("LOAD_ATTR", "LOAD_METHOD"), ("CACHE", "NOP", "EXTENDED_ARG", "PUSH_NULL", "PRECALL")

ANNOTATED = re.compile(r"^\s+[\w.]+\s*:\s*([^=#\n]+?)\s*=(?!=)", re.MULTILINE)
"""An assignment to an annotated name within a function: no name of its code, but Taichi reads it."""


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
        if kind in PLAIN:
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
        if kind in (tuple, list, set, frozenset):  # of a set, in the order in which a loop meets them
            self._several(kind.__name__, value)
        elif kind is dict:
            self._items("dict", value)
        elif kind is types.ModuleType:
            self._module(value)
        elif kind is types.FunctionType:
            self._function(value)
        elif isinstance(value, type):
            self._class(value, kind)
        elif kind is types.MethodType:
            self._several("method", (value.__self__, value.__func__))
        elif kind is types.BuiltinFunctionType:
            self._builtin(value)
        elif kind in DESCRIPTORS:
            self._say("descriptor", f"{value.__objclass__.__module__}.{value.__qualname__}")
        elif kind is type(Pair.one):  # of a named tuple
            self._say(repr(value))
        elif kind is functools.partial:
            self._several("partial", (value.func, value.args, value.keywords))
        elif kind is functools._lru_cache_wrapper:
            self._several("cached", (value.__wrapped__,))
        elif kind in (staticmethod, classmethod):
            self._several(kind.__name__, (value.__func__,))
        elif kind is property:
            self._several("property", (value.fget,))
        elif kind is functools.cached_property:
            self._several("cached property", (value.func,))
        elif kind in (types.GenericAlias, types.UnionType) or kind.__module__ in ("typing", "collections.abc"):
            self._say("annotation", repr(value))
        elif kind is types.SimpleNamespace:
            self._items("namespace", vars(value))
        else:
            self._object(value, kind)

    def _object(self, value, kind):
        core = impl._ti_core
        if isinstance(value, np.generic) and kind.__module__ == "numpy" and not value.dtype.hasobject:
            self._say("number", str(value.dtype), value.tobytes().hex())
        elif kind is np.ndarray and not value.dtype.hasobject:
            self._say("array", str(value.dtype), str(value.shape))
            self.digest.update(np.ascontiguousarray(value).tobytes())
        elif isinstance(value, np.dtype) or (kind is np.ufunc and vars(np).get(value.__name__) is value):
            self._say(kind.__name__, repr(value))
        elif kind is core.DataType:
            self._say("type", value.to_string())
        elif kind.__module__ == core.__name__ and "__members__" in dir(kind):
            self._say("member", str(value))
        elif isinstance(value, enum.Enum):
            self._say("member", f"{kind.__module__}.{kind.__qualname__}.{value.name}", _source(kind.__module__))
            self.feed(value.value)
        elif kind.__bases__ == (tuple,) and "_fields" in vars(kind):
            self._several("named", (kind, *tuple(value)))
        elif _is_table(kind):
            self._several("object", (kind,))
            self._items("attributes", vars(value))
        else:
            raise Unknown(f"{kind.__module__}.{kind.__qualname__}")

    def _several(self, what, values):
        self._say(what, str(len(values)))
        for value in values:
            self.feed(value)

    def _items(self, what, values):
        self._say(what, str(len(values)))
        for key, value in values.items():
            self.feed(key)
            self.feed(value)

    def _module(self, value):
        if not _among(value.__name__):
            raise Unknown(f"module {value.__name__}, handed on")
        self._say("module", value.__name__)

    def _of_module(self, module, ways):
        """Feed what a function reads of a module, as `_ways` tells it."""
        for way in ways:
            found = module
            while isinstance(found, types.ModuleType) and not _among(found.__name__):
                if not way or way[0] not in vars(found):
                    raise Unknown(f"module {found.__name__}, handed on or asked for what it does not hold")
                self._say("of module", found.__name__, way[0])
                found, way = vars(found)[way[0]], way[1:]
            self.feed(found)

    def _class(self, value, kind):
        self._say("class", value.__module__, value.__qualname__)
        if _among(value.__module__):
            return
        if kind.__module__ not in ("builtins", "abc", "typing"):
            raise Unknown(f"{value.__module__}.{value.__qualname__}, a class of its own kind")
        self._say(_source(value.__module__))
        self._several("bases", value.__bases__)
        self._items("body", {name: part for name, part in vars(value).items() if name not in OF_EVERY_CLASS})

    def _builtin(self, value):
        owner = value.__self__
        self._say("builtin", str(value.__module__), value.__qualname__)
        if not (owner is None or isinstance(owner, (types.ModuleType, type))):
            self.feed(owner)

    def _function(self, value):
        code, space = value.__code__, value.__globals__
        self._say("function", value.__module__ or "", value.__qualname__)
        if _of_taichi(code) and "__wrapped__" in vars(value):  # `ti.func` and `ti.kernel`
            self.feed(value.__wrapped__)
            return
        if _among(space.get("__name__", "")):
            if value.__closure__ and space["__name__"] == "functools":  # `singledispatch`, for one
                raise Unknown(f"{value.__qualname__}, made of another function")
            return
        if any(isinstance(kind, str) for kind in value.__annotations__.values()):
            raise Unknown(f"{value.__qualname__}, whose annotations are texts")
        file = _file(code.co_filename)
        own, names, annotated = _described(code, file)
        self._say(file, own)
        self._several("usual", (value.__defaults__, value.__kwdefaults__, value.__annotations__, vars(value)))
        found = {name: space[name] for name in (*names, *annotated) if name in space}
        found |= zip(code.co_freevars, [cell.cell_contents for cell in value.__closure__ or ()], strict=True)
        for name, part in found.items():
            self._say(name)
            if isinstance(part, types.ModuleType) and not _among(part.__name__):
                self._of_module(part, [()] if name in annotated else _ways(code, name))
            else:
                self.feed(part)


def _is_table(kind):
    """Whether objects of a class are no more than their attributes: none of its bases brings content of its own, and
    none answers to names that it does not hold."""
    bases = [vars(base) for base in kind.__mro__ if base is not object]
    return any("__dict__" in base for base in bases) and not any(
        name in base for base in bases for name in ("__slots__", *ANSWERS)) and all(
        isinstance(base, type) and not base.__flags__ & BUILT_IN for base in kind.__mro__ if base is not object)


@functools.cache
def _described(code, file):
    """-> digest of a code object in a file of this digest, names that it and those within it may read, and those in
    annotations. Raises Unknown for one that imports."""
    if dis.opmap["IMPORT_NAME"] in code.co_code[::2]:
        raise Unknown(f"{code.co_name}, which imports")
    words = ["code", code.co_name, str(code.co_firstlineno), repr(code.co_varnames), repr(code.co_names),
             repr(code.co_freevars), repr((code.co_argcount, code.co_kwonlyargcount, code.co_flags)),
             code.co_code.hex()]
    names = dict.fromkeys(code.co_names)
    annotated = dict.fromkeys(re.findall(r"[A-Za-z_]\w*", " ".join(ANNOTATED.findall(_text(code)))))
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            inner, more, texts = _described(constant, file)
            words.append(inner)
            names |= dict.fromkeys(more)
            annotated |= dict.fromkeys(texts)
        else:
            words.append(repr(sorted(constant, key=repr) if isinstance(constant, frozenset) else constant))
    return hashlib.sha256("\0".join(words).encode("utf-8", "surrogatepass")).hexdigest(), tuple(names), tuple(annotated)


def _ways(code, name):
    """For each time that code reads a name, the attributes that it goes on to: [("C",), ("mod", "C")] of `pkg.C` and
    `pkg.mod.C`; () where it does anything else with it. Nothing where the name is that of an attribute only."""
    steps = [step for step in dis.get_instructions(code) if step.opname not in PADDING]
    ways = []
    for i, step in enumerate(steps):
        if step.argval == name and step.opname.startswith("LOAD_") and step.opname not in READS:
            way = []
            while steps[i + 1 + len(way)].opname in READS:
                way.append(steps[i + 1 + len(way)].argval)
            ways.append(tuple(way))
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType) and name in (*constant.co_names, *constant.co_freevars):
            ways += _ways(constant, name)
    return ways


def _text(code):
    """Source of a code object, of its file."""
    last = max((line for _, _, line in code.co_lines() if line), default=code.co_firstlineno)
    return "".join(linecache.getlines(code.co_filename)[code.co_firstlineno - 1 : last])


def _of_taichi(code):
    return code.co_filename.startswith(os.path.dirname(ti.__file__) + os.sep)


def _among(module):
    return (module or "").partition(".")[0] in OTHERS


def _source(module):
    """Digest of the file of a module."""
    file = vars(sys.modules[module]).get("__file__") if module in sys.modules else None
    return _file(file) if file else "no file"


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
