"""The Python of an installed QGIS, which is never that of a virtual environment. SNOWMPM_QGIS_PYTHON names another."""

import json
import os
import subprocess
from functools import lru_cache

import pytest

PYTHON = os.environ.get("SNOWMPM_QGIS_PYTHON", "/usr/bin/python3")


@lru_cache(maxsize=1)
def has_qgis():
    """Whether PyQGIS can be imported there."""
    try:
        return subprocess.run([PYTHON, "-c", "import qgis.core, processing"], capture_output=True, timeout=60,
                              env=surroundings("/nonexistent", ["/usr/share/qgis/python/plugins"])).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


needs_qgis = pytest.mark.skipif("not __import__('tests.support.qgis', fromlist=['']).has_qgis()",
                                reason="needs QGIS with its Python: apt-get install qgis python3-qgis")


def surroundings(home, more=()):
    """Environment for a QGIS without a display, with its profile in `home`; more: folders with Python modules."""
    kept = {name: value for name, value in os.environ.items()
            if name not in ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH", "VIRTUAL_ENV", "DISPLAY")}
    return {**kept, "QT_QPA_PLATFORM": "offscreen", "HOME": str(home), "XDG_RUNTIME_DIR": str(home),
            **({"PYTHONPATH": os.pathsep.join(map(str, more))} if more else {})}


def in_qgis(script, arguments, home, timeout=300):
    """What a script prints in QGIS's own Python as its last line, which is JSON. Fails with its output otherwise."""
    done = subprocess.run([PYTHON, str(script), *map(str, arguments)], capture_output=True, text=True, timeout=timeout,
                          env=surroundings(home))
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return {"stderr": done.stderr, **json.loads(done.stdout.strip().splitlines()[-1])}
