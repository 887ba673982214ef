"""A step at rest in 3-D with 1e5 particles: seconds, iterations, memory.

    python tests/benchmarks/static_step.py [--cells 50 50 5]

A layer of elastic snow on ground that holds it, between smooth sides, tilted by 20 degrees, from the unstrained state
to its balance. Times are those of the step alone, by the clock and of the processor, once without (the first) and once
with compiled kernels; memory is the most that the process had, and what it had before the step.
"""

import argparse
import resource
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

SNOW = {"density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3}


def layer(cells, dx=0.1):
    """Solver of a layer of cells (3,)."""
    from snowmpm.materials import Elastic
    from snowmpm.study.problems.schemes import lattice
    from tests.support.implicit_steps import implicit

    size = dx * np.asarray(cells, float)
    x, volumes = lattice([0.0] * 3, size, dx)
    tilt = np.radians(20.0)
    return implicit(x, volumes, Elastic(**SNOW), dx, upper=[size[0], size[1], size[2] + 0.5], time="quasi_static",
                    sides=[["slip", "slip"], ["slip", "slip"], ["stick", "open"]],
                    gravity=9.81 * np.array([np.sin(tilt), 0.0, -np.cos(tilt)]))


def measure(cells):
    """{what: number} of a step."""
    solver = layer(cells)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    clock, processor = time.perf_counter(), time.process_time()
    solver.step(1.0)
    found = {"particles": solver.particles.count, "seconds": time.perf_counter() - clock,
             "processor_seconds": time.process_time() - processor, "iterations": solver.passed.iterations}
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    weight = solver.particles.mass * np.linalg.norm(solver.gravity)
    carried = np.linalg.norm(solver.passed.force) / weight
    return found | {"memory_gib": most / 2**20, "before_gib": before / 2**20, "foretold_gib": solver.memory / 2**30,
                    "carried": carried}


def main():
    from snowmpm.compiler import runtime

    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cells", type=int, nargs=3, default=(50, 50, 5))
    options = parser.parse_args()
    runtime.start("cpu", threads=2)
    for words, cells in (("first, with compilation", (4, 4, 4)), ("compiled", options.cells)):
        print(words, {key: round(value, 3) for key, value in measure(cells).items()}, flush=True)


if __name__ == "__main__":
    main()
