"""A slab that enters a zone: `python -m tests.handover.zone_threads THREADS` prints what came out of it."""

import hashlib
import json
import sys

import numpy as np

from snowmpm.compiler import parallel, runtime
from snowmpm.running.simulation import Simulation
from tests.handover.slab_in_zone import WALL, zoned


def main(threads):
    runtime.start("cpu", threads)
    parallel.LITTLE_WORK = 0.0  # a scene as small as this would be left to one thread of the two
    simulation = Simulation(zoned(obstacles=[WALL]))
    while simulation.time < 2.0 - 1e-9:
        simulation.step(until=2.0)
    solver, digest = simulation.solver, hashlib.sha256()
    for part in (solver.outer.state()["columns"], solver.inner.state()):
        for name in ("reals", "labels"):
            digest.update(np.ascontiguousarray(part[name]).tobytes())
    print(json.dumps({"threads": runtime.threads(), "hash": digest.hexdigest(),
                      "particles": solver.inner.particles.count}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
