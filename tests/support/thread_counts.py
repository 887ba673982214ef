"""What a module of cases says with one thread and with two."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMIT = 600
"""[s] that no process may take."""


def with_one_and_two_threads(module, *arguments):
    """[what `python -m MODULE THREADS ARGUMENTS` prints last, read as JSON, for 1 thread and for 2].

    One after the other: the second finds the kernels that the first has compiled.
    """
    told = []
    for threads in (1, 2):
        said = subprocess.run([sys.executable, "-m", module, str(threads), *map(str, arguments)], cwd=ROOT, text=True,
                              stdout=subprocess.PIPE, timeout=LIMIT, check=True).stdout
        told.append(json.loads(said.splitlines()[-1]))
    assert [one["threads"] for one in told] == [1, 2]
    return told
