"""What Taichi's compiler was told of a kernel, kept beside the compiled kernels, and told again.

The compiled code of a kernel lies on disk, but its key is a digest of the kernel as Taichi's compiler has it, so at
every start Python goes through the source of all kernels, a second for those of a scene (measured). All that the
compiler learns then are calls of its functions, one for a constant, a sum, the beginning of a loop. They are written
down the first time, and made again wherever the kernel has the same `fingerprint`: a tenth of the time.

A record is kept only if the compiler takes the kernel that it makes for the same one, by that key. This is the patch
`front_end` (`snowmpm.compiler.patches`); a kernel of which something cannot be told is gone through each time.
"""

import contextlib
import enum
import functools
import hashlib
import marshal
import operator
import os
import platform
import sys
import time as clock
import zlib
from pathlib import Path

import numpy as np

from snowmpm.compiler import patches
from snowmpm.compiler.backend import impl, part, ti
from snowmpm.compiler.fingerprint import Unknown, fingerprint

ENDING = ".told"
MOST_BYTES = 1 << 28
"""Of all records in a folder; those least lately written give way."""

MOST_OF_ONE = 1 << 26
"""Bytes of a record, before and after it is packed."""

LEFT_BEHIND = 3600.0
"""Seconds after which a file that was begun belongs to no living process."""

_roomy: set[Path] = set()
"""Folders in which this process has made room."""

SETTINGS = ("default_fp", "default_ip", "default_up", "short_circuit_operators")
"""Of the process, which the way through a source depends on; those of a compilation, `OF_COMPILATION`, beside them."""
OF_COMPILATION = ("arch", "debug", "check_out_of_bound", "opt_level", "advanced_optimization", "fast_math",
                  "real_matrix_scalarize", "force_scalarize_matrix", "half2_vectorization")
CLASSES = ("ASTBuilder", "Expr", "ExprGroup", "Kernel", "TypeFactory")
"""Of the compiler, whose methods are written down as well as its functions."""

LEFT_OUT = ("Expr.set_dbg_info", "Expr.is_tensor", "Expr.is_lvalue", "Expr.is_external_tensor_expr", "Expr.get_shape",
            "Expr.get_rvalue_type", "Expr.get_ret_type", "promoted_type", "is_integral", "is_real", "is_signed",
            "is_tensor", "logging_effective")
"""Calls that change nothing: places in the source, and what Python asks of what it has made."""

MAPPER = "TaichiCallableTemplateMapper"
"""Class of what tells the kinds of the arguments of a kernel."""

KERNEL, SETTING, FACTORY, PLACE = "kernel", "setting", "factory", "place"
LIST, ITEM = "[]", "[i]"


def _look():
    """Look for all that is used here."""
    core, config = impl._ti_core, impl.current_cfg()
    for name in CLASSES:
        vars(core)[name]
    operator.attrgetter(*OF_COMPILATION)(config)
    if vars(part("lang.kernel_impl"))[MAPPER].lookup.__code__.co_varnames[:2] != ("self", "args"):
        raise patches.Misfit("kinds of arguments are looked up in another way")
    core.DebugInfo, core.DataType.to_string, core.get_type_factory_instance  # noqa: B018


def compiled(kernel, args):
    """A kernel of Taichi's compiler and its code, for the kinds of arrays among these arguments.

    kernel: `taichi.lang.kernel_impl.Kernel`, of numbers and arrays only. Raises what Taichi raises for arguments that
    it does not take.
    """
    start, config = impl.get_runtime(), impl.current_cfg()
    program, name = start.prog, None
    if patches.apply("front_end", _look) and config.offline_cache:
        _, kinds = kernel.mapper.lookup(args)
        name = _name(kernel, kinds)
    if name is None:
        return _code(program, kernel.compiled_kernels[kernel.ensure_compiled(*args)])
    start.materialize()
    path = Path(config.offline_cache_file_path).expanduser() / name
    told = _read(path)
    if told is not None:
        with contextlib.suppress(Exception):  # a file that is none of a kernel: gone through anew
            return _code(program, _made(program, kernel, told))
    with _Record() as record:
        made = kernel.compiled_kernels[kernel.ensure_compiled(*args)]
    found = _code(program, made)
    with contextlib.suppress(Exception):  # of what cannot be told; the kernel is there
        told = record.told()
        if _code(program, _made(program, kernel, told))[1] is found[1]:
            _write(path, told)
    return found


def _code(program, made):
    return made, program.compile_kernel(program.config(), program.get_device_caps(), made)


def _made(program, kernel, told):
    """The kernel of a record."""
    return program.create_kernel(lambda made: _tell(told, made), kernel.func.__name__, kernel.autodiff_mode)


def _name(kernel, kinds):
    """File of the record of a kernel, None where it cannot have one."""
    start, config = impl.get_runtime(), impl.current_cfg()
    about = (_version(), str(kernel.autodiff_mode), operator.attrgetter(*SETTINGS)(start),
             operator.attrgetter(*OF_COMPILATION)(config), kinds)
    try:
        return fingerprint(kernel.func, *about) + ENDING
    except Exception:  # of objects that do not let themselves be read, among others
        return None


@functools.cache
def _version():
    here = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
    return (ti.__name__, *ti.__version__, impl._ti_core.get_commit_hash(), np.__version__, sys.version,
            platform.machine(), here.hexdigest())


class _Record:
    """Context in which the calls of the compiler's functions are written down."""

    def __init__(self):
        self._calls, self._labels, self._constants = [], {}, {}
        self._places, self._alive, self._replaced, self._unknown = {}, [], [], None
        self._typed, self._built = set(), set()

    def __enter__(self):
        core = impl._ti_core
        owners = [(core, "", name) for name, value in vars(core).items()
                  if type(value).__name__ == "builtin_function_or_method"]
        owners += [(vars(core)[kind], f"{kind}.", name) for kind in CLASSES
                   for name, value in vars(vars(core)[kind]).items()
                   if callable(value) and ((name == "__init__" and kind == "ExprGroup") or not name.startswith("__"))]
        for owner, of, name in owners:
            before = vars(owner)[name]
            if (label := of + name) not in LEFT_OUT:
                self._replaced.append((owner, name, before))
                setattr(owner, name, self._noting(label, before))
        return self

    def __exit__(self, *error):
        for owner, name, before in self._replaced:
            setattr(owner, name, before)

    def told(self):
        """The record: labels of functions, constants, calls, each a label and the places of its arguments among
        constants and results of calls. Raises Unknown where something cannot be told."""
        if self._unknown:
            raise self._unknown
        first = len(self._constants)
        calls = [(label, *[first + place if of_call else place for of_call, place in args])
                 for label, args in self._calls]
        return list(self._labels), list(self._constants), calls

    def _noting(self, label, function):
        """The function, which also writes down each call of it."""
        creates = label.endswith("__init__")
        once = {"Expr.type_check": self._typed, "Kernel.ast_builder": self._built}.get(label)

        def noted(*args, **named):
            result = function(*args, **named)
            if self._unknown is None:
                if once is not None:
                    if id(args[0]) in once:
                        return result
                    once.add(id(args[0]))
                try:
                    places = [self._place(arg) for arg in (args[1:] if creates else args)]
                    places += [self._place(arg) for arg in named.values()]
                    number = self._add(":".join((label, *named)) if named else label, places)
                    self._keep(args[0] if creates else result, number)
                except Unknown as error:
                    self._unknown = error
            return result

        return noted

    def _add(self, label, places):
        labels = self._labels
        self._calls.append((labels.setdefault(label, len(labels)), places))
        return len(self._calls) - 1

    def _keep(self, result, number):
        """Know the result of a call again where it is an argument."""
        if result is None:
            return
        core = impl._ti_core.__name__
        if isinstance(result, (list, tuple)):
            for i, one in enumerate(result):
                if type(one).__module__ == core:
                    self._keep(one, self._add(ITEM, [(1, number), self._constant(i)]))
        elif type(result).__module__ == core:
            self._places[id(result)] = number
            self._alive.append(result)  # or its identity would be another's

    def _place(self, value):
        """(0, number of a constant) or (1, number of a call)."""
        number = self._places.get(id(value))
        if number is not None:
            return 1, number
        value = value.item() if isinstance(value, np.generic) else value
        core, kind = impl._ti_core, type(value)
        if value is None or kind in (bool, int, float, str):
            return self._constant(value)
        if kind in (list, tuple):
            return 1, self._add(LIST, [self._place(one) for one in value])
        if kind in (core.DebugInfo, core.Kernel, core.CompileConfig, core.TypeFactory):
            name = {core.DebugInfo: PLACE, core.Kernel: KERNEL, core.CompileConfig: SETTING, core.TypeFactory: FACTORY}
            return self._constant((name[kind],))
        if kind is core.DataType:
            return self._constant(_type_told(value))
        if kind.__module__ == core.__name__ and "__members__" in dir(kind):
            return self._constant((kind.__name__, int(value)))
        if isinstance(value, enum.Enum):
            return self._place(value.value)
        raise Unknown(f"{kind.__module__}.{kind.__qualname__}")

    def _constant(self, value):
        key = value if isinstance(value, tuple) else (type(value).__name__, repr(value), value)
        return 0, self._constants.setdefault(key, len(self._constants))


def _type_told(kind):
    name = kind.to_string()
    if vars(impl._ti_core).get(f"DataType_{name}") == kind:
        return "DataType", name
    shape = list(kind.shape() or ())
    if not shape:
        raise Unknown(name)
    return "tensor", tuple(shape), _type_told(kind.element_type())


def _constant_of(told, made):
    """The value of a constant of a record; made: the kernel."""
    core, kind = impl._ti_core, told[0]
    if kind == "DataType":
        return vars(core)[f"DataType_{told[1]}"]
    if kind == "tensor":
        return core.get_type_factory_instance().get_tensor_type(list(told[1]), _constant_of(told[2], made))
    if len(told) == 3:
        return told[2]
    if len(told) == 2:
        return vars(core)[kind](told[1])
    return {KERNEL: made, SETTING: impl.get_runtime().prog.config(), PLACE: core.DebugInfo(""),
            FACTORY: core.get_type_factory_instance()}[kind]


def _function_of(label):
    """The function of a label of a record."""
    if label == LIST:
        return lambda *values: list(values)
    if label == ITEM:
        return lambda values, i: values[i]
    label, *named = label.split(":")
    owner, _, name = label.rpartition(".")
    owner = vars(impl._ti_core)[owner] if owner else impl._ti_core
    function = owner if name == "__init__" else vars(owner)[name]
    if not named:
        return function
    n = len(named)
    return lambda *args: function(*args[:-n], **dict(zip(named, args[-n:], strict=True)))


def _tell(told, made):
    """Tell the compiler all calls of a record, of the kernel that it is making."""
    labels, constants, calls = told
    functions, values = [_function_of(label) for label in labels], [_constant_of(one, made) for one in constants]
    keep = values.append
    for call in calls:
        keep(functions[call[0]](*[values[place] for place in call[1:]]))


def _read(path):
    """The record of a file, None where it is not whole: as it was written, under this name."""
    try:
        if path.stat().st_size > MOST_OF_ONE:
            return None
        digest, data = path.read_bytes().split(b"\n", 1)
        if digest != _digest(path, data):
            return None
        return marshal.loads(zlib.decompressobj().decompress(data, MOST_OF_ONE))
    except (OSError, ValueError, EOFError, TypeError, MemoryError, zlib.error):
        return None


def _digest(path, data):
    return hashlib.sha256(path.name.encode() + data).hexdigest().encode()


def _write(path, told):
    """Write a record whole or not at all, and make room for it."""
    data, begun = zlib.compress(marshal.dumps(told), 1), path.with_suffix(f"{ENDING}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        begun.write_bytes(_digest(path, data) + b"\n" + data)
        os.replace(begun, path)
    except OSError:
        with contextlib.suppress(OSError):
            begun.unlink()
    if path.parent not in _roomy:
        _roomy.add(path.parent)
        with contextlib.suppress(OSError):
            _make_room(path.parent)


def records(folder):
    """Files of records in a folder, the last written one first."""
    return sorted(folder.glob("*" + ENDING), key=lambda path: path.stat().st_mtime, reverse=True)


def _make_room(folder):
    for begun in folder.glob(f"*{ENDING}.*"):  # by a process that was killed
        if clock.time() - begun.stat().st_mtime > LEFT_BEHIND:
            begun.unlink()
    sizes = 0
    for path in records(folder):
        sizes += path.stat().st_size
        if sizes > MOST_BYTES:
            path.unlink()
