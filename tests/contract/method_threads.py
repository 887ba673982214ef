"""The eventful scene of every method: `python -m tests.contract.method_threads THREADS [DIMENSION]` prints what came
out of it, in the least dimension of each method if none is given."""

import hashlib
import json
import sys

import numpy as np

from snowmpm.compiler import parallel, runtime
from snowmpm.methods import METHODS
from snowmpm.running.simulation import Simulation
from tests.contract.method_examples import able, eventful, least_dimension
from tests.contract.method_suite import END, reach


def arrays(state):
    """All arrays and numbers of a nested state, in order."""
    if isinstance(state, dict):
        return [array for name in sorted(state) for array in arrays(state[name])]
    if isinstance(state, list | tuple):
        return [array for one in state for array in arrays(one)]
    return [np.asarray(state)]


def outcome(method, dim):
    """Hash of all that a run leaves, and what shows that something happened."""
    simulation = reach(Simulation(eventful(method, dim, precision=able(method).precisions[0])), END)
    numbers = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays(simulation.state())
                       if array.dtype.kind in "biuf")
    return {"hash": hashlib.sha256(numbers).hexdigest(), "sorts": simulation.solver.particles.sorts,
            "impulse": float(np.abs(simulation.solver.totals.impulse).max())}


def main(threads, dim=None):
    runtime.start("cpu", threads)
    parallel.LITTLE_WORK = 0.0  # scenes as small as these would be left to one thread of the two
    dims = {method: dim or least_dimension(method) for method in METHODS}
    cases = {method: outcome(method, of) for method, of in dims.items() if of in able(method).dimensions}
    print(json.dumps({"threads": runtime.threads(), "cases": cases}))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
