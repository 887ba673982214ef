"""The device of a simulation in words."""

import ctypes
import os
import platform
from pathlib import Path


def device_name(backend, threads):
    """"1 thread of AMD EPYC", or the name of the GPU."""
    if backend == "cuda":
        return _gpu()
    return f"{threads} thread{'s' if threads > 1 else ''} of {_processor()}"


def _processor():
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, "") or platform.processor() or platform.machine() or "an unknown processor"


def _gpu():
    """Name of the first device, as the CUDA driver gives it."""
    name = ctypes.create_string_buffer(128)
    try:
        driver = ctypes.CDLL("nvcuda.dll" if os.name == "nt" else "libcuda.so.1")
        if driver.cuInit(0) == 0 and driver.cuDeviceGetName(name, len(name), 0) == 0:
            return name.value.decode(errors="replace")
    except OSError:
        pass
    return "a CUDA GPU"
