"""Cost of one stress update, ns per particle on one core: trial, logarithm, return map, new state, loads and stores.

    python tests/benchmarks/stress_update.py [--particles N] [--repeat N] [--csv FILE]

States lie on or inside the yield surface under random stresses; the increments have strains of 1e-4 (a step of an
explicit solver), random rotation included. Half of the particles yield, in random order, unless --yielding says
otherwise. The least processor time over the repeats is reported, since other programs may use the machine. "copy" loads
and stores the same arrays and computes nothing.
"""

import argparse
import csv
import time

import numpy as np
import taichi as ti

from snowmpm import runtime
from snowmpm.materials import AnticrackCamClay, CohesiveCamClay, Elastic, ModifiedCamClay, StressUpdate, pack


@ti.func
def copy_update(prm, h, state, A, dt):
    return h, h, state, A.sum(), 0


class Copy(Elastic):
    """No law at all: what it costs to load and store."""

    update = staticmethod(copy_update)


SLAB = {"density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3}
CRITICAL = {**SLAB, "critical_slope": 1.5, "hardening": 1.0, "p0": 3e4}
LAWS = {
    "copy": Copy(**SLAB),
    "elastic": Elastic(**SLAB),
    "modified_cam_clay": ModifiedCamClay(**CRITICAL),
    "cohesive_cam_clay": CohesiveCamClay(**CRITICAL, cohesion=0.3),
    "anticrack_cam_clay": AnticrackCamClay(**CRITICAL, cohesion=0.3, softening=0.5),
}


def states(law, dimension, n, rng, strain=1e-4, yielding=0.5):
    """h, state and A of n particles, of which the given share yields in the step."""
    update = StressUpdate(law, dimension, "f64")
    state = update.initial_state(n)
    p0 = getattr(law, "p0", 1e4)
    beta, slope = getattr(law, "beta", 0.3), getattr(law, "critical_slope", 1.0)
    angle = rng.uniform(0.0, np.pi, n)
    q = slope * (1.0 + beta) * p0 / (2.0 * np.sqrt(1.0 + 2.0 * beta)) * np.sin(angle)
    p = 0.5 * (1.0 - beta) * p0 + 0.5 * (1.0 + beta) * p0 * np.cos(angle)
    deviator = np.zeros((n, 3, 3))
    deviator[:, :dimension, :dimension] = rng.normal(size=(n, dimension, dimension))
    deviator += deviator.transpose(0, 2, 1)
    deviator -= np.trace(deviator, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    deviator /= np.sqrt(1.5 * np.einsum("nij,nij->n", deviator, deviator))[:, None, None]
    A = strain * rng.normal(size=(n, dimension, dimension))
    yields = rng.random(n) < yielding
    # Moving out along the stress direction yields; a stress well inside does not
    stress = q[:, None, None] * deviator - p[:, None, None] * np.eye(3)
    stress *= np.where(yields, 1.0, 0.5)[:, None, None]
    A += np.where(yields, 3.0 * strain / p0, 0.0)[:, None, None] * stress[:, :dimension, :dimension]
    return pack(law.h_from_stress(stress), dimension), state, A


def measure(law, dimension, precision, n, repeat, yielding):
    """ns per update, share of particles that yielded, mean iterations of those."""
    update = StressUpdate(law, dimension, precision)
    inputs = states(law, dimension, n, np.random.default_rng(1), yielding=yielding)
    h, state, A = inputs
    run = update.prepare(h, state, A[:, None])
    result = run()
    times = []
    for _ in range(repeat):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    plastic = result.iterations[:, 0] > 0
    return 1e9 * min(times) / n, plastic.mean(), result.iterations[plastic].mean() if plastic.any() else 0.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--particles", type=int, default=40_000)
    parser.add_argument("--repeat", type=int, default=100)
    parser.add_argument("--yielding", type=float, default=0.5)
    parser.add_argument("--law", choices=LAWS, action="append")
    parser.add_argument("--csv")
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    rows = []
    for name in options.law or LAWS:
        for dimension in (2, 3):
            for precision in ("f32", "f64"):
                start = time.perf_counter()
                ns, share, count = measure(
                    LAWS[name], dimension, precision, options.particles, options.repeat, options.yielding
                )
                rows.append((name, dimension, precision, round(ns, 1), round(share, 3), round(count, 2)))
                print(
                    f"{name:20s} {dimension}-D {precision}  {ns:6.1f} ns   yielding {share:.2f}"
                    f"   iterations {count:.2f}   ({time.perf_counter() - start:.1f} s in all)"
                )
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(("law", "dimension", "precision", "ns_per_update", "yielding", "iterations"))
            writer.writerows(rows)


if __name__ == "__main__":
    main()
