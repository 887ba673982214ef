"""The only `ti.init` of the program: backend, threads, and which float a kernel is compiled for."""

import atexit
import contextlib
import ctypes
import os
import threading
import time as clock
import warnings
from pathlib import Path

from snowmpm.compiler import array_memory, lifetime, probe
from snowmpm.compiler.backend import impl, part, ti
from snowmpm.compiler.cache_folder import VARIABLE, cache_folder
from snowmpm.compiler.settings import DTYPES, OWN, compiling, forget_threads, keep_turn, runs, started_here
from snowmpm.compiler.settings import working_precision as precision
from snowmpm.cores import available_cores
from snowmpm.errors import InputError

__all__ = ["DTYPES", "precision", "start"]

CACHE_BYTES = 1 << 30
"""Compiled kernels that are kept on disk: those of about 250 scenes. 25 would fill Taichi's own 100 MB."""

WRITING = 10.0
"""Seconds that a program which ends waits for others to write their kernels."""

STALE_LOCK = 60.0
"""Seconds after which a lock on the kernels on disk belongs to no living program."""

_running = {}
"""What was started: backend, threads, `start`, the Python object of this start of Taichi, and `thread`, the identity of
the thread that did."""

_kernels = {}
"""fine_grained: what kernels ask for while they are compiled, apart from what differs between processes
(`compiler.fingerprint`)."""


def start(backend: str = "auto", threads: int | None = None, fine_grained: bool = False) -> str:
    """Start Taichi once for this process, or use the one that runs; -> its backend, "cpu" or "cuda".

    backend: "auto" (CUDA when there is one, else CPU), "cpu" or "cuda".
    threads: CPU worker threads, default every core that this process may use.
    fine_grained: use the kernels of a GPU on a CPU too, so that they can be tested without one.
    A Taichi that the caller has started by `ti.init` is used as it is, with its backend, threads, fields and arrays;
    kernels here are compiled with settings of their own all the same (`snowmpm.compiler.settings`). After `ti.init`
    or `ti.reset`, and in a forked process, it is started anew: simulations made before raise EndedError. Warns where
    what runs is not what is asked for. Raises InputError for a Taichi on another backend than these two, EndedError
    where a forked process cannot have one.
    """
    with compiling():
        if not is_started():
            lifetime.watch_arrays()
            own = not runs(impl.get_runtime())
            if own:
                _start(backend, threads)
            _note(fine_grained, threading.current_thread() if own else threading.main_thread())
        else:
            _say_what_differs(backend, threads)
    return _running["backend"]


@contextlib.contextmanager
def _without_greeting():
    """Context: `ti.init` does not print "Starting on arch=..."; what others print meanwhile is not held up."""
    module = part("lang.misc")
    module.print = lambda *_, **__: None
    try:
        yield
    finally:
        del module.print


def _start(backend, threads):
    """Call `ti.init` for "auto", "cpu" or "cuda", with `threads` CPU threads, by default one a core.

    "auto" takes CUDA where there is a device, else the CPU.
    """
    # Left to choose for itself, Taichi also tries Vulkan and OpenGL, and dies where there is no display.
    cuda = backend == "cuda" or (backend == "auto" and _has_cuda())
    lifetime.end_parents()
    folder = cache_folder(impl.default_cfg().offline_cache_file_path)
    free_cache(folder)
    where = {} if os.environ.get(VARIABLE) == folder else {"offline_cache_file_path": folder}
    with _without_greeting():
        ti.init(arch=ti.cuda if cuda else ti.cpu, cpu_max_num_threads=threads or available_cores(), offline_cache=True,
                **where, offline_cache_max_size_of_files=CACHE_BYTES, log_level=ti.WARN, **OWN)
    started_here()


@atexit.register
def keep_kernels():
    """End the Taichi that runs, unless a thread is at work with it: it writes the kernels that it compiled to the disk
    then.

    Where anything still refers to it when Python ends, Taichi is not ended, and every kernel is compiled anew the next
    time: so it was with the command line, 4 s of each run of a small block (measured).
    """
    if is_started() and keep_turn(1.0):
        from filelock import FileLock, Timeout  # slow to import

        # Taichi does not wait for another program that writes, but leaves its own kernels out
        lock = FileLock(Path(impl.current_cfg().offline_cache_file_path).expanduser() / "snowmpm.lock")
        with contextlib.suppress(OSError, Timeout):
            lock.acquire(timeout=WRITING)
        ti.reset()
        lock.release()


def _note(fine_grained, thread):
    """Note the Taichi that runs in `_running`, with the thread that started it, and prepare it for the program.

    fine_grained: as in `start`. Raises InputError for a backend that is neither CPU nor CUDA.
    """
    config = impl.current_cfg()
    if config.arch not in (ti.cuda, ti.x64, ti.arm64):
        raise InputError(f"Taichi runs on {config.arch.name}, where a ti.init before has started it: snowmpm needs"
                         " ti.init(arch=ti.cpu) or ti.cuda there,\nor none: it starts Taichi itself")
    running = "cuda" if config.arch == ti.cuda else "cpu"
    array_memory.share(running == "cpu")
    if not _running:
        os.register_at_fork(after_in_child=_after_fork)
    probe.probe(running, config.cpu_max_num_threads, config.offline_cache_file_path)
    _running.update(start=impl.get_runtime(), backend=running, threads=config.cpu_max_num_threads, thread=thread.ident)
    _kernels.update(fine_grained=fine_grained or running == "cuda")


def _say_what_differs(backend, threads):
    """Warn where the Taichi that runs has another backend or number of threads than asked for."""
    asked = [f"backend {backend!r}"] * (backend not in ("auto", _running["backend"]))
    asked += [f"{threads} threads"] * (_running["backend"] == "cpu" and threads not in (None, _running["threads"]))
    if asked:
        warnings.warn(f"Taichi runs already, on the {_running['backend']} with {_running['threads']} threads: no"
                      f" {' and no '.join(asked)}; call snowmpm.start before anything else", stacklevel=3)


def _after_fork():
    """In a forked child: forget the parent's threads, and leave its Taichi alone."""
    forget_threads()
    if is_started():
        lifetime.part_after_fork(_running["thread"])


def free_cache(folder):
    """Remove the lock on Taichi's kernels on disk that a killed program left: Taichi holds it for milliseconds, but
    where it finds one it compiles every kernel anew, at every start, for good."""
    lock = Path(folder).expanduser() / "ticache.lock"
    with contextlib.suppress(OSError):
        if clock.time() - lock.stat().st_mtime > STALE_LOCK:
            lock.unlink()


def _has_cuda():
    """Whether the CUDA driver loads and finds a device."""
    try:
        driver = ctypes.CDLL("nvcuda.dll" if os.name == "nt" else "libcuda.so.1")
    except OSError:
        return False
    count = ctypes.c_int(0)
    return driver.cuInit(0) == 0 and driver.cuDeviceGetCount(ctypes.byref(count)) == 0 and count.value > 0


def backend():
    """"cpu" or "cuda": what runs; starts the default when nothing has been started."""
    return start()


def threads():
    """Number of CPU worker threads Taichi was started with."""
    return _running.get("threads", 1)


def fine_grained():
    """Whether every thread takes a particle or a block and adds to what others add to, as a GPU wants; else a thread
    takes many of them, in packs."""
    return _kernels.get("fine_grained", False)


def is_started():
    """Whether Taichi runs, and as it was when `start` was called last."""
    return runs(impl.get_runtime()) and _running.get("start") is impl.get_runtime()
