"""Clay that loses strength over a length of its own: `python -m` and this module, with how many THREADS, prints what
came out."""

import hashlib
import json
import sys

from snowmpm.compiler import parallel, runtime
from snowmpm.components.nonlocal_averaging.layer import Layer

DX, HEIGHT, STEPS, AT = 0.05, 0.6, 12, 4000
"""Of a thin layer, which has passed its peak in so many steps of a speed that is `AT` times as high."""


def hurried():
    """Solver of a layer whose particles have the speed at which it yields in the first steps."""
    solver, clay = Layer(DX, height=HEIGHT, seconds=4.0).solver()
    table = solver.particles.table()
    for name in ("velocity", "affine"):
        table[:, solver.particles.layout.columns(name)] *= AT
    solver.particles.overwrite(table)
    return solver, clay


def main(threads):
    runtime.start("cpu", threads)
    parallel.LITTLE_WORK = 0.0
    solver, _ = hurried()
    for _ in range(STEPS):
        solver.step(1e-5)
    table = solver.particles.table()
    print(json.dumps({"threads": runtime.threads(), "alone": solver.serial, "yielding": solver.n_plastic,
                      "hash": hashlib.sha256(table.tobytes()).hexdigest()}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
