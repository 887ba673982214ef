"""The only `ti.init` of the program: backend, threads, and which float a kernel is compiled for."""

import contextlib
import ctypes
import os
import time as clock
from pathlib import Path

import taichi as ti
from taichi.lang import impl
from taichi.lang._ndarray import ScalarNdarray
from taichi.lang.matrix import MatrixNdarray, VectorNdarray

from snowmpm import array_memory, function_trees  # noqa: F401 (the second changes how Taichi compiles)
from snowmpm.materials import precision as floats

DTYPES, precision = floats.DTYPES, floats.working_precision
"""Taichi's and NumPy's float by name, "f32" or "f64", and the context in which kernels work with one of them."""

CACHE_BYTES = 1 << 30
"""Compiled kernels that are kept on disk: those of about 250 scenes. 25 would fill Taichi's own 100 MB."""

STALE_LOCK = 60.0
"""Seconds after which a lock on the kernels on disk belongs to no living program."""

_started = {}


def start(backend="auto", threads=None, fine_grained=False):
    """Start Taichi once for this process; later calls return the backend that runs.

    backend: "auto" (CUDA when there is one, else CPU), "cpu" or "cuda".
    threads: CPU worker threads, default every core that this process may use.
    fine_grained: use the kernels of a GPU on a CPU too, so that they can be tested without one.
    """
    if _started:
        return _started["backend"]
    _free_vector_arrays()
    # Left to choose for itself, Taichi also tries Vulkan and OpenGL, and dies where there is no display.
    cuda = backend == "cuda" or (backend == "auto" and _has_cuda())
    threads = threads or _cores()
    free_cache(impl.default_cfg().offline_cache_file_path)
    ti.init(arch=ti.cuda if cuda else ti.cpu, cpu_max_num_threads=threads, offline_cache=True,
            offline_cache_max_size_of_files=CACHE_BYTES, log_level=ti.WARN, cfg_optimization=False)
    running = "cuda" if impl.current_cfg().arch == ti.cuda else "cpu"
    if running == "cpu":
        array_memory.share()
    _started.update(backend=running, threads=threads, fine_grained=fine_grained or running == "cuda")
    return running


def free_cache(folder):
    """Remove the lock on Taichi's kernels on disk that a killed program left: Taichi holds it for milliseconds, but
    where it finds one it compiles every kernel anew, at every start, for good."""
    lock = Path(folder).expanduser() / "ticache.lock"
    with contextlib.suppress(OSError):
        if clock.time() - lock.stat().st_mtime > STALE_LOCK:
            lock.unlink()


def _free_vector_arrays():
    """Let arrays of vectors and matrices give their memory back when Python forgets them, as those of numbers do.

    Taichi 1.7 keeps them to the end of the program, and a grid that grows with the avalanche makes new ones again and
    again.
    """
    for kind in (VectorNdarray, MatrixNdarray):
        if "__del__" not in vars(kind):
            kind.__del__ = ScalarNdarray.__del__


def _has_cuda():
    try:
        driver = ctypes.CDLL("nvcuda.dll" if os.name == "nt" else "libcuda.so.1")
    except OSError:
        return False
    count = ctypes.c_int(0)
    return driver.cuInit(0) == 0 and driver.cuDeviceGetCount(ctypes.byref(count)) == 0 and count.value > 0


def _cores():
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def backend():
    """"cpu" or "cuda": what runs; starts the default when nothing has been started."""
    return start()


def threads():
    """Number of CPU worker threads Taichi was started with."""
    return _started.get("threads", 1)


def fine_grained():
    """Whether every thread takes a particle or a block and adds to what others add to, as a GPU wants; else a thread
    takes many of them, in packs."""
    return _started.get("fine_grained", False)


def is_started():
    """Whether Taichi runs."""
    return bool(_started)


@contextlib.contextmanager
def plain_compilation():
    """Compile and launch kernels without Taichi's own optimiser, leaving the work to LLVM's.

    Its passes take time with the square of the accesses to local arrays: 17 s instead of 2.5 s for a kernel that works
    on packs of particles (measured), for code as fast. Small kernels are faster with it. The setting is part of the key
    of a compiled kernel, so it must be the same at every launch.
    """
    config = impl.current_cfg()
    before = config.advanced_optimization
    config.advanced_optimization = False
    try:
        yield
    finally:
        config.advanced_optimization = before
