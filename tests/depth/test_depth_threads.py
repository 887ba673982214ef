"""A depth-averaged flow to the bit for any number of threads, in both precisions; the kernels of a GPU to round-off."""

import hashlib
import json
import subprocess
import sys

import numpy as np
import pytest

from snowmpm.compiler import runtime
from snowmpm.components.forest_and_deposition.depth import Stopping
from tests.support.depth_flows import OPEN, WALL, Ground, Options, coulomb, flow, lattice, pore_water, run_to

DX = 0.25


def valley(plan):
    return 0.05 * plan[:, 1] ** 2 - 0.5 * plan[:, 0]


def wood(plan):
    """Drag and detrainment of trees on one side of the valley."""
    return np.where((plan[:, 1] > 0.0)[:, None], [0.01, 100.0], 0.0)


def avalanche(precision, lays_down=False):
    """12 800 columns, more than one thread takes alone, that flow down a valley and out at its end. lays_down: wet
    snow through trees, half of it from the start and the rest 0.4 s later; and what stops becomes ground."""
    plan, area = lattice((0.0, -2.4), (10.0, 2.6), DX / 4)
    ground = Ground(valley, (-2.0, -6.0), (11.0, 6.0), coulomb(12.0), (OPEN, WALL))
    pores, dry = pore_water(excess=0.5, consolidation=0.05, drained=lambda places: places[:, 1] < -1.0)
    solver = flow(plan, area * (0.5 + 0.3 * np.sin(plan[:, 0])), ground, DX, options=Options(precision=precision),
                  **(dict(starts=np.where(plan[:, 0] > 5.0, 0.0, 0.4), adapters=[Stopping(wood, 0.1)],
                          densities=(dry,), water=pores) if lays_down else {}))
    assert not solver._serial
    return run_to(solver, 1.0)


def columns(solver):
    """Positions and velocities by number."""
    store = solver.particles
    table = np.column_stack([store.positions(), store.column("velocity")])
    return table[np.argsort(store.snapshot().labels[:, 1])]


def digest(solver):
    totals = solver.totals
    numbers = np.concatenate([columns(solver).ravel(), totals.impulse, [totals.contact_work, solver.time],
                              solver.bed.heights.ravel(),
                              solver.particles.load.pores.profile().ravel() if solver.particles.load else []])
    return hashlib.sha256(numbers.tobytes()).hexdigest()


def elsewhere(*arguments):
    """`found` with so many threads and these kernels, in a process of its own."""
    done = subprocess.run([sys.executable, "-m", "tests.depth.test_depth_threads", *arguments], check=True,
                          capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def found():
    """Of a process: digests of both precisions, sums of the double one and how many columns left."""
    single, double, laying = avalanche("f32"), avalanche("f64"), avalanche("f32", lays_down=True)
    return {"digests": [digest(single), digest(double), digest(laying)], "sums": columns(double).sum(axis=0).tolist(),
            "removed": double.particles.removed["count"]}


def test_one_and_two_threads_agree():
    """This process has as many as there are cores."""
    laid = avalanche("f32", lays_down=True).particles.removed["laid"]
    assert laid > 0.01 * avalanche("f32").particles.mass
    here, there = found(), elsewhere("1" if runtime.threads() > 1 else "2", "usual")
    assert here["removed"] > 100
    assert here == there


@pytest.mark.slow
def test_three_threads_agree():
    assert elsewhere("3", "usual") == found()


@pytest.mark.slow
def test_kernels_of_a_gpu():
    """In float64, to what the order of sums changes in some 50 steps."""
    usual, fine_grained = found(), elsewhere("2", "fine_grained")
    assert fine_grained["removed"] == usual["removed"]
    np.testing.assert_allclose(fine_grained["sums"], usual["sums"], rtol=1e-9)


def test_single_precision_is_near_double():
    single, double = (columns(avalanche(precision)) for precision in ("f32", "f64"))
    assert abs(len(single) - len(double)) < 0.001 * len(double)
    np.testing.assert_allclose(single.mean(axis=0), double.mean(axis=0), atol=1e-4)


if __name__ == "__main__":
    runtime.start("cpu", int(sys.argv[1]), fine_grained=sys.argv[2] == "fine_grained")
    print(json.dumps(found()))
