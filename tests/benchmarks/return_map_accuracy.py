"""Error against nanoseconds of the variants of the Cam-Clay update: CSV and chart.

    python tests/benchmarks/return_map_accuracy.py [-o FOLDER] [--repeat N]

Two strain paths of the reference cases (set A: E = 3 MPa, M = 1.5, beta = 0.3, xi = 1, p0 = 30 kPa), followed from the
stress-free state in 1 to 1000 equal steps: oedometric compression to 5 %, and simple shear to gamma = 0.05 after
isotropic compression to 27 kPa. Error: the largest of those of p and q at the end, relative to q, against an
integration of the equations with SciPy at 1e-12. Cost: least processor time over the repeats on one core of the whole
path, and of one update on it.
"""

import argparse
import csv
import sys
import time
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.materials import CohesiveCamClay, StressUpdate
from snowmpm.materials.symmetric import invariants, unpack

sys.path.insert(0, str(Path(__file__).parents[1] / "materials"))
from cam_clay_reference import Reference

SET = dict(youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=1.5, cohesion=0.3, hardening=1.0, p0=3e4)
VARIANTS = {
    "implicit": dict(return_map="implicit"),
    "frozen": dict(return_map="frozen"),
    "substepped 1e-2": dict(return_map="substepped", substep_tolerance=1e-2),
    "substepped 1e-4": dict(return_map="substepped", substep_tolerance=1e-4),
    "substepped 1e-6": dict(return_map="substepped", substep_tolerance=1e-6),
}
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
P_START = 27e3
PATHS = {"oedometer to 5 %": "oedometer", "simple shear to 0.05": "shear"}
COLUMNS = ("path", "variant", "precision", "steps", "error", "ns_per_path", "ns_per_update")


def increments(kind, law, steps):
    """A = f − I of equal steps of the path; the isotropic compression of the shear path comes first, as one step."""
    if kind == "oedometer":
        A = np.zeros((steps, 3, 3))
        A[:, 0, 0] = np.expm1(-0.05 / steps)
        return A
    A = np.zeros((steps + 1, 3, 3))
    A[0] = np.expm1(-P_START / law.bulk_modulus / 3.0) * np.eye(3)
    A[1:, 0, 1] = 0.05 / steps
    return A


def exact(kind, law):
    """p and q at the end of the path."""
    reference = Reference(**SET)
    if kind == "oedometer":
        gradient, duration = (lambda t: np.diag([-0.05, 0.0, 0.0])), 1.0
    else:
        volume = -P_START / law.bulk_modulus

        def gradient(t):
            shear = np.zeros((3, 3))
            shear[0, 1] = 0.05
            return volume / 3.0 * np.eye(3) if t < 1.0 else shear

        duration = 2.0
    _, _, p, q, _, _ = reference.integrate(gradient, duration)
    return p[-1], q[-1]


def measure(kind, law, precision, steps, repeat, p, q):
    """Relative error, ns of a path, ns of an update."""
    update = StressUpdate(law, 3, precision)
    A = increments(kind, law, steps)
    n = max(64, 40_000 // steps)
    run = update.prepare(np.zeros((n, 6)), update.initial_state(n), np.broadcast_to(A, (n, *A.shape)))
    result = run()
    times = []
    for _ in range(repeat):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    found = invariants(unpack(result.stress[0, -1].astype(float)))
    error = max(abs(found[0] - p), abs(found[1] - q)) / q
    return error, 1e9 * min(times) / n, 1e9 * min(times) / n / len(A)


def draw(rows, file):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(PATHS), figsize=(11, 5), sharey=True, layout="constrained")
    for axis, path in zip(axes, PATHS, strict=True):
        for k, variant in enumerate(VARIANTS):
            for precision, style in (("f64", "-o"), ("f32", "--s")):
                points = [row for row in rows if row[:3] == (path, variant, precision)]
                axis.loglog([r[5] for r in points], [r[4] for r in points], style, color=f"C{k}", markersize=4,
                            linewidth=1.2, fillstyle="full" if precision == "f64" else "none",
                            label=variant if precision == "f64" else None)
        axis.set(title=path, xlabel="time of the path on one core [ns a particle]")
        axis.grid(True, which="major", alpha=0.3)
    axes[0].set_ylabel("error of p, q relative to q")
    axes[0].plot([], [], "k--s", markersize=4, fillstyle="none", linewidth=1.2, label="the same in float32")
    axes[0].legend(frameon=False)
    figure.suptitle(f"Cohesive Cam-Clay: {STEPS[0]} to {STEPS[-1]} steps of the variants of the stress update")
    figure.savefig(file, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path(__file__).parent / "figures")
    parser.add_argument("--repeat", type=int, default=30)
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    rows = []
    for path, kind in PATHS.items():
        for variant, choice in VARIANTS.items():
            law = CohesiveCamClay(density=250.0, **SET, **choice)
            p, q = exact(kind, law)
            for precision in ("f64", "f32"):
                for steps in STEPS:
                    error, ns, each = measure(kind, law, precision, steps, options.repeat, p, q)
                    rows.append((path, variant, precision, steps, float(f"{error:.3g}"), round(ns), round(each, 1)))
    options.out.mkdir(parents=True, exist_ok=True)
    with open(options.out / "return_map_accuracy.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    draw(rows, options.out / "return_map_accuracy.png")
    for row in rows:
        print("{:22s} {:16s} {} {:5d} {:9.2e} {:9d} ns/path {:8.1f} ns/update".format(*row))


if __name__ == "__main__":
    main()
