"""How kernels here are compiled and launched, whoever started Taichi: with our settings, by one thread at a time.

Taichi has one set of compiler settings for the whole process. A program that called `ti.init` with its own, such as
integers of 64 bits, keeps them for its own kernels; those here are compiled and launched with Taichi's defaults and
`OWN`, so that results are the same to the bit.
"""

import functools
import threading

import numpy as np

from snowmpm.compiler.backend import impl, ti

DTYPES = {"f32": (ti.f32, np.float32), "f64": (ti.f64, np.float64)}
"""Taichi's and NumPy's float by name."""

OWN = {"cfg_optimization": False}
"""What differs here from Taichi's defaults: this pass takes minutes for the longest kernels."""

SPREAD = 512
"""Iterations of a parallel loop that Taichi gives to a thread of a CPU at a time."""

NUMBERS = {"default_fp": ti.f32, "default_ip": ti.i32, "default_up": ti.u32}
"""Types of literals; the first one is another in `working_precision`."""

OF_PROCESS = ("arch", "cpu_max_num_threads", "random_seed", "gpu_max_reg", "cuda_stack_limit",
              "saturating_grid_dim", "kernel_profiler", "num_compile_threads", "timeline", "use_llvm", "vk_api_version")
OF_PROCESS_BEGIN = ("offline_cache", "device_memory", "print_", "verbose")
"""Settings that stay as they are, by name and by its beginning: of hardware, threads, files and messages."""

OF_FRONT_END = (*NUMBERS, "short_circuit_operators")
"""Settings that Taichi keeps where it reads the source of a kernel, all but the last beside the others as well."""

_turn, _entered, _ours = threading.RLock(), 0, None


class compiling:
    """Compile and launch with the settings of this package, while no other thread does. May be entered again.

    A class, since a generator would cost as much as a launch.
    """

    __slots__ = ("_before", "_lock", "_outer", "_runtime")

    def __enter__(self):
        global _entered
        self._lock, self._before = _turn, {}
        self._lock.acquire()
        self._outer, self._runtime = _entered, impl.get_runtime()
        try:
            if not _entered and self._runtime is not _ours and runs(self._runtime):
                self._before = _replace(self._runtime, _differences(self._runtime))
        except BaseException:
            self._lock.release()
            raise
        _entered += 1

    def __exit__(self, *error):
        global _entered
        _entered = self._outer
        try:
            if self._before and runs(self._runtime):
                _replace(self._runtime, self._before)
        finally:
            self._lock.release()


def keep_turn(seconds):
    """Let no other thread compile or launch from now on; -> whether none did so for longer than `seconds`."""
    return _turn.acquire(timeout=seconds)


def runs(start):
    """Whether a start of Taichi has not ended: it has a program. Some versions raise where it has none."""
    try:
        return start.prog is not None
    except RuntimeError:
        return False


def started_here():
    """Taichi was started with `OWN`, and what the environment adds for tests (TI_DEBUG) is meant for this package."""
    global _ours
    _ours = impl.get_runtime()


def forget_threads():
    """In a forked process: a thread that had its turn in the parent is not there to end it."""
    global _turn, _entered
    _turn, _entered = threading.RLock(), 0


@functools.lru_cache(maxsize=1)
def _differences(runtime):
    """{name: value} of each setting that Taichi was started with and that is another here."""
    config = runtime.prog.config()
    found = {name: value for name, value in _settings().items() if getattr(config, name) != value}
    return found if runtime.short_circuit_operators else found | {"short_circuit_operators": True}


def _replace(runtime, settings):
    """Set settings; -> what they were."""
    config, before = runtime.prog.config(), {}
    for name, value in settings.items():
        keepers = [runtime] * (name in OF_FRONT_END) + [config] * hasattr(config, name)
        before[name] = getattr(keepers[0], name)
        for keeper in keepers:
            setattr(keeper, name, value)
    return before


@functools.cache
def _settings():
    """The settings of this package by name. Taichi's defaults are to be had only by resetting what it starts with."""
    config = impl.default_cfg()
    before = {name: getattr(config, name) for name in dir(config) if not name.startswith("_")}
    impl._ti_core.reset_default_compile_config()
    defaults = {name: getattr(config, name) for name in before
                if name not in OF_PROCESS and not name.startswith(OF_PROCESS_BEGIN)}
    for name, value in before.items():
        setattr(config, name, value)
    return defaults | OWN | NUMBERS


def working_float():
    """Taichi's float that kernels are compiled for now."""
    return impl.get_runtime().default_fp


class working_precision:
    """Compile and launch kernels with "f32" or "f64" as the type of literals and of `float`.

    -> Taichi's and NumPy's float. Taichi reads its default float when a kernel is compiled, not when it is started, so
    one process can serve both; one thread at a time. Raises RuntimeError when Taichi has not been started. A class, as
    `compiling` is: each step enters it several times.
    """

    __slots__ = ("_before", "_floats", "_runtime", "_turn")

    def __init__(self, name):
        self._floats, self._turn = DTYPES[name], compiling()

    def __enter__(self):
        self._turn.__enter__()
        self._runtime = impl.get_runtime()
        if not runs(self._runtime):
            self._turn.__exit__()
            raise RuntimeError("Taichi is not running: call snowmpm.start() first")
        self._before, self._runtime.default_fp = self._runtime.default_fp, self._floats[0]
        return self._floats

    def __exit__(self, *error):
        self._runtime.default_fp = self._before
        self._turn.__exit__(*error)
