"""What a step and a frame cost, from the tables of the benchmarks (`tests/benchmarks/check_costs.py` collects them).

One thread of the machine that the README names. On another one take ratios: they hardly change.
"""

import csv
import functools
from dataclasses import dataclass
from pathlib import Path

TABLE = Path(__file__).parent / "study" / "data" / "costs.csv"
USUAL_LAW = "cohesive_cam_clay"
"""Law of the steps in the table, half of the particles yielding."""


@dataclass(frozen=True)
class Scheme:
    """What the cost of a step hangs on."""

    dimension: int
    precision: str = "f32"
    kernel: str = "quadratic"
    gradient: str = "affine"
    transfer: str = "apic"
    method: str = "mpm"

    @classmethod
    def of(cls, scene):
        solver = scene.solver
        return cls(scene.dimension, solver.precision, solver.kernel, solver.gradient, solver.transfer, solver.method)


@functools.cache
def table():
    """Rows of the table: {(what, dimension, precision, name): ns}."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        return {(row["what"], int(row["dimension"]), row["precision"], row["name"]): float(row["ns"])
                for row in csv.DictReader(file)}


def transfers(scheme):
    """ns a particle of scatter and gather, or of the sums of SPH, with the usual law but without the grid."""
    found = table()
    if scheme.method == "sph":
        return found["step", scheme.dimension, scheme.precision, "sph"]
    base = found["step", scheme.dimension, scheme.precision, "quadratic affine apic"]
    for name in (f"{scheme.kernel} {scheme.gradient}", scheme.transfer):
        # Measured in float32; what they add in float64 is more by as much as the whole step is
        single = found["step", scheme.dimension, "f32", "quadratic affine apic"]
        base += found.get(("more", scheme.dimension, "f32", name), 0.0) * (
            found["step", scheme.dimension, scheme.precision, "quadratic affine apic"] / single)
    return base


def usual_law(scheme):
    """ns of the update of `USUAL_LAW`."""
    return table()["law", scheme.dimension, scheme.precision, USUAL_LAW]


def law(scheme, kind):
    """ns of a law's update more than that of `USUAL_LAW`; none for a law that is not in the table."""
    usual = usual_law(scheme)
    return table().get(("law", scheme.dimension, scheme.precision, kind), usual) - usual


def block(scheme):
    """ns a block of cells."""
    return 0.0 if scheme.method == "sph" else table()["block", scheme.dimension, scheme.precision, ""]


def call(scheme):
    """Seconds of a step that do not go with the number of particles: calls of kernels, and what is kept of a step."""
    return 1e-9 * table()["call", scheme.dimension, "f32", scheme.method]


def step(scheme, particles, blocks, laws):
    """Seconds of a step; particles: of each law, laws: their kinds."""
    ns = sum(n * (transfers(scheme) + law(scheme, kind)) for n, kind in zip(particles, laws, strict=True))
    return call(scheme) + 1e-9 * (ns + blocks * block(scheme))


def frame(particles, numbers, dimension):
    """Seconds of a frame of particles with so many numbers each, beside their positions, audit included."""
    found = table()
    return 1e-9 * particles * (found["frame", dimension, "f32", "audit"]
                               + (numbers + 3) * found["frame", dimension, "f32", "number"])
