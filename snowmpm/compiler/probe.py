"""What the program needs of the installed Taichi, tried out where it starts.

Patches look for the names that they replace when they are applied. Whether they do what they are for, and whether
kernels compute in the float that is asked for, only kernels can tell. Those here take 0.5 s of a core to compile and
0.1 s to load (measured), so a Taichi that has passed is noted beside its kernels on disk, by all that the result
depends on: Taichi, Python, machine, backend, patches and our compiler folder. A start with this note takes 2 ms.
"""

import hashlib
import platform
import warnings
from pathlib import Path

import numpy as np

from snowmpm.compiler import launch, lifetime, patches
from snowmpm.compiler.backend import impl, ti
from snowmpm.compiler.settings import DTYPES, NUMBERS, OWN, SPREAD, working_precision
from snowmpm.errors import InputError

FILE = "snowmpm_probe.txt"
"""In the folder of Taichi's compiled kernels: a line for each Taichi that passed."""

MOST = 100
"""Lines in that file, after which it begins anew."""

PATIENCE = 10_000_000, 5
"""Looks that one thread takes for the other, and how often it is tried: 0.1 s each where only one of them runs."""

SETTINGS = ("advanced_optimization", *OWN)
"""Of a compilation, without which results would be others."""
OTHER_VERSION = "this version cannot be used; install taichi 1.7.3 or 1.7.4"

_passed = set()
"""Lines of that file, of this process."""


def probe(backend, threads, folder):
    """Try the Taichi that runs; folder: of its compiled kernels.

    A patch that fails is undone with a warning (`snowmpm.compiler.patches`). Warns where loops are not shared among
    threads. Raises InputError where a setting is missing or a kernel does not compute in the float that is asked for.
    """
    try_settings()
    try_lifetime()
    line, file = _identity(backend, threads > 1), Path(folder).expanduser() / FILE
    if line in _passed or line in _lines(file):
        return
    applied = _patches()
    try_function_trees()
    for name in DTYPES:
        try_precision(name)
    if backend == "cpu":
        try_array_memory()
    try_front_end()
    try_launch()
    if backend == "cpu":
        try_relaunch()
    if backend == "cpu" and threads > 1 and not two_threads_meet():
        warnings.warn(f"Taichi {_version()} does not hand {2 * SPREAD} iterations of a loop to two threads:\nthe"
                      " program runs on one of them, slower, with the same results", stacklevel=4)
    elif applied == _patches():
        _note(line, file)


def _version():
    return ".".join(map(str, ti.__version__))


def _patches():
    """Patches that are asked for and not left out so far."""
    return sorted(name for name in patches.GAINS if patches.wanted(name) and name not in patches.reasons())


def _identity(backend, threaded):
    """All that the result depends on, as a line."""
    code = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
    about = (_version(), str(Path(ti.__file__).parent), platform.python_version(), platform.node(),
             platform.machine(), backend, str(threaded), ",".join(_patches()), code.hexdigest())
    return f"{_version()} {hashlib.sha256(chr(10).join(about).encode()).hexdigest()}"


def _lines(file):
    try:
        return file.read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return []


def _note(line, file):
    _passed.add(line)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with open(file, "w" if len(_lines(file)) >= MOST else "a", encoding="ascii") as notes:
            notes.write(line + "\n")
    except OSError:
        pass  # a folder that cannot be written: every process tries anew


def _try(name, check):
    """Run the check of a patch that is applied; undo the patch where it fails. Others' failures show without it."""
    if patches.is_applied(name):
        try:
            check()
        except Exception as error:  # Taichi raises what its compiler meets
            patches.leave_out(name, error)


def _expect(found, expected, what):
    if not np.array_equal(found, expected):
        raise patches.Misfit(f"{what} gives {np.asarray(found).tolist()} instead of {np.asarray(expected).tolist()}")


def try_settings():
    """Raises InputError where Taichi has no such setting as kernels here are compiled with."""
    runtime, config = impl.get_runtime(), impl.current_cfg()
    for keeper, name in [(runtime, name) for name in NUMBERS] + [(config, name) for name in SETTINGS]:
        if not hasattr(keeper, name):
            raise InputError(f"Taichi {_version()} has no setting {name}:\n{OTHER_VERSION}")


def try_lifetime():
    """An array knows its Taichi, and gives its memory back without a word."""

    def check():
        array = ti.Vector.ndarray(2, ti.f64, 3)
        if array._start is not lifetime.current():
            raise patches.Misfit("an array does not know its Taichi")

    _try("array_lifetime", check)


def try_function_trees():
    """A function in the argument of its own call, and one that calls itself."""

    def check():
        found = np.zeros(2)
        _nested_calls()(found)
        _expect(found, [28.0, 81.0], "a function within functions")

    _try("function_trees", check)


def try_precision(name):
    """Raises InputError where a kernel under this precision does not compute in it."""
    expected = DTYPES[name][1](1) / DTYPES[name][1](3)
    found = np.zeros(1)
    with working_precision(name):
        _third()(found, 3)
    if found[0] != expected:
        raise InputError(f"Taichi {_version()} computes 1/3 as {found.item()!r} where {name} is asked for, not"
                         f" {float(expected)!r}:\n{OTHER_VERSION}")


def try_front_end():
    """A kernel that the compiler is told from the disk computes what the one that was gone through does."""

    def check():
        for kernel in (launch.taichi_kernel(_double()) for _ in range(2)):
            _expect(_doubled(kernel), [3.0, 5.0], "a kernel told from the disk")

    _try("front_end", check)


def try_array_memory():
    """What is filled from NumPy reaches a kernel, and what it writes comes back."""

    def check():
        _expect(_doubled(ti.kernel(_double())), [3.0, 5.0], "a kernel on arrays filled from NumPy")

    _try("array_memory", check)


def try_launch():
    """Arrays and numbers arrive in their places."""

    kernel = launch.taichi_kernel(_double())

    def check():
        _expect(_doubled(kernel), [3.0, 5.0], "a launched kernel")

    _try("launch", check)


def try_relaunch():
    """What changed since the last launch arrives, an array or a number, and so does what stayed."""

    kernel = launch.taichi_kernel(_double())

    def check():
        if not patches.is_applied("launch"):
            return
        array, other = ti.ndarray(ti.f64, 2), ti.ndarray(ti.f64, 3)
        array.from_numpy(np.array([1.0, 2.0]))
        other.from_numpy(np.array([1.0, 2.0, 3.0]))
        for values, more in ((array, 1.0), (array, 1.0), (array, 2.0), (other, 2.0), (array, 2.0)):
            kernel(values, more, 2)
        _expect(array.to_numpy(), [34.0, 50.0], "a kernel launched again")
        _expect(other.to_numpy(), [4.0, 6.0, 8.0], "a kernel launched again with another array")

    _try("relaunch", check)


def two_threads_meet():
    """Whether 2 x `SPREAD` iterations run on two threads at a time: the first ones of each half wait for each other."""
    meet, (looks, times) = _meet(), PATIENCE
    for _ in range(times):
        flags = np.zeros(4, np.int32)
        meet(flags, looks)
        if flags[2:].all():
            return True
    return False


def _doubled(kernel):
    array = ti.ndarray(ti.f64, 2)
    array.from_numpy(np.array([1.0, 2.0]))
    kernel(array, 1.0, 2)
    return array.to_numpy()


# Each kernel is made anew, since what Taichi has compiled of one under a patch stays with it


def _third():
    @ti.kernel
    def third(found: ti.types.ndarray(), three: ti.i32):
        for _ in range(1):
            found[0] = 1.0 / three

    return third


def _nested_calls():
    @ti.func
    def twice(x):
        return 2 * x

    @ti.func
    def power(x, n: ti.template()):
        result = x
        if ti.static(n > 1):
            result = x * power(x, n - 1)
        return result

    @ti.kernel
    def nested(found: ti.types.ndarray()):
        for _ in range(1):
            found[0] = twice(twice(3) + twice(4))
            found[1] = power(power(3, 2), 2)

    return nested


def _double():
    def double(values: ti.types.ndarray(), more: ti.f64, factor: ti.i32):
        for i in range(values.shape[0]):
            values[i] = factor * values[i] + more

    return double


def _meet():
    @ti.kernel
    def meet(flags: ti.types.ndarray(), looks: ti.i32):
        for i in range(2 * SPREAD):
            if i % SPREAD == 0:
                half = i // SPREAD
                ti.atomic_max(flags[half], 1)
                look = 0
                while look < looks and ti.atomic_max(flags[1 - half], 0) == 0:
                    look += 1
                if look < looks:
                    flags[2 + half] = 1

    return meet
