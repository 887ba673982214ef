"""How much a body may deform in one step: CSV.

    python tests/benchmarks/deformation_step.py [-o FOLDER]

A free block of 4 x 4 cells, 2 x 2 particles in each, in plane strain and double precision, is set going with a uniform
velocity gradient: collapse and expansion along both axes, squeezing along one, simple shear. The size of a step is
given by |dt grad v| (Frobenius norm) at the start and then fixed; the elastic limit plays no part, C = c dt / dx being
at most 0.8. It runs for 1.6 times as long as a wave takes to cross the block. A step is too long when the run fails or
ends with a fifth more energy than it began with. For each flow, transfer and stiffness, the largest |dt grad v| up to
which none of the steps tried was too long, and what ended the search: deformation, or C = 0.8.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.materials import Elastic
from snowmpm.stepping.time_step import DEFORMATION_LIMIT
from snowmpm.study.atlas.stirring import DX
from snowmpm.study.atlas.time_steps import FLOWS, GAIN, deformed

STIFFNESS = (1.5, 2.0, 3.0)
"""E / (rho dx^2) [1/s2], for a rate of 1/s."""
SIZES = np.arange(0.1, 1.05, 0.05)
LARGEST_C = 0.8
COLUMNS = ("transfer", "flow", "stiffness", "largest_step", "limited_by")


def holds(flow, stiffness, size, transfer):
    """Whether steps of |dt grad v| = size can be made; None where the elastic limit has a say."""
    law = Elastic(density=300.0, youngs_modulus=300.0 * stiffness * DX**2, poisson_ratio=0.3)
    if law.wave_speed() * size / np.linalg.norm(FLOWS[flow]) / DX > LARGEST_C:
        return None
    return deformed(size, flow, transfer, stiffness) <= GAIN


def largest(flow, stiffness, transfer):
    """-> (largest size up to which all hold, "deformation" or "elastic": what ended the search)."""
    found = 0.0
    for size in SIZES:
        verdict = holds(flow, stiffness, size, transfer)
        if not verdict:
            return found, "elastic" if verdict is None else "deformation"
        found = size
    return found, "nothing"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures", help="folder")
    arguments = parser.parse_args()
    runtime.start("cpu")
    rows = []
    for transfer in ("pic", "apic", "aflip"):
        for name in FLOWS:
            for stiffness in STIFFNESS:
                size, cause = largest(name, stiffness, transfer)
                rows.append((transfer, name, stiffness, f"{size:.2f}", cause))
                print(*rows[-1], flush=True)
    least = min(float(row[3]) for row in rows if row[4] == "deformation")
    print(f"least {least:.2f}, used {DEFORMATION_LIMIT}")
    arguments.output.mkdir(parents=True, exist_ok=True)
    with open(arguments.output / "deformation_step.csv", "w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])


if __name__ == "__main__":
    main()
