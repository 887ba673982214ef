"""Largest stable C = c dt / dx of every basis, gradient and transfer: CSV, and a table of the smallest.

    python tests/benchmarks/critical_step.py [-o FOLDER] [--only WORD]

Bodies of Hencky elasticity (nu = 0.3 unless said) at rest are given random velocities (and strains) of 1e-6 c; a step
is stable when the motion does not grow out of 100 times their energy within 300 steps, and C is bisected to 1 %. In
double precision, 2-D and some 3-D:

    lone        one grain at three places of a cell (four with averaged hats), the nodes around it its own
    lone 0.45   the same with nu = 0.45
    sparse      1 grain per cell, in the middle between nodes, where a wave of two cells is stiffest
    2, 3, 4     full lattices of so many grains per cell and axis; 2 at two offsets to the grid
    random      60 grains thrown on 25 cells
    wall        2 per axis, stuck to a side that lies a third of a cell off the nodes
    squeezed    4 x 2 per cell, periodic, F = diag(1/2, 1); C with the speed c_0 sqrt(1 + ln 2) of `timestep`
    passing     lone grain and lattice of 2 that cross half a cell a step, or a whole one
    hardened    lone grain of Stomakhin's snow at J_P = 0.7, C with the speed at that state

`C sqrt(s)` takes out Poisson's ratio and dimension, see `snowmpm.stepping.time_step`, whose CRITICAL
holds the least of it.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.materials import Elastic
from snowmpm.scenes import material_card
from snowmpm.schemes import BASES, SCHEMES
from snowmpm.stepping.time_step import grain_stiffness
from snowmpm.study.atlas.stirring import DX, blows_up, lone_grain, spread, stirred

STEPS = 300
ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
SOFT = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.45)
LOWEST, HIGHEST, RESOLUTION = 0.05, 3.0, 1.01
IN_3D = [("quadratic", "affine", "apic"), ("quadratic", "affine", "pic"), ("quadratic", "shape", "flip"),
         ("cubic", "affine", "apic"), ("cubic", "shape", "flip"), ("gimp", "shape", "flip"),
         ("linear", "shape", "flip")]
COLUMNS = ("kernel", "gradient", "transfer", "dimension", "body", "offset", "poisson_ratio", "C", "C_sqrt_s")


def bodies(dim, box=None):
    """{(name, offset [cells]): (grains, law, options of `stirred`, speed of waves over c_0, cells crossed a step)}.

    box: width of that of an averaged hat, which is stiffest half of it off a node."""
    dense, rng = 5 if dim == 2 else 3, np.random.default_rng(3)
    found = {}
    for offset in (0.0, 0.25, 0.4999, *([0.4999 * box] if box else [])):
        found["lone", offset] = lone_grain(dim, offset), ICE, {}, 1.0, 0.0
        found["lone 0.45", offset] = lone_grain(dim, offset), SOFT, {}, 1.0, 0.0
    found["sparse", 0.0] = spread(1, dense, dim, 0.0), ICE, {}, 1.0, 0.0
    found["2", 0.0] = spread(2, dense, dim, 0.0), ICE, {}, 1.0, 0.0
    if dim == 3:
        return found
    found["2", 0.25] = spread(2, dense, dim, 0.25), ICE, {}, 1.0, 0.0
    for per_axis in (3, 4):
        found[str(per_axis), 0.0] = spread(per_axis, dense, dim, 0.0), ICE, {}, 1.0, 0.0
    thrown = DX * rng.uniform(0.0, dense, (60, dim)), np.full(60, (0.5 * DX) ** dim)
    found["random", 0.0] = thrown, ICE, {}, 1.0, 0.0
    wall = {"origin": np.full(2, -(8.0 + 1.0 / 3.0) * DX), "lower": np.array([-8.0 * DX, 0.0]),
            "sides": [["open", "open"], ["stick", "open"]]}
    found["wall", 0.333] = spread(2, dense, dim, 0.0), ICE, wall, 1.0, 0.0
    periodic = {"origin": np.zeros(2), "lower": np.zeros(2), "upper": np.full(2, 8.0 * DX),
                "sides": [["periodic", "periodic"]] * 2}
    positions, _ = spread(4, 8, dim, 0.0)
    positions, row = positions.reshape(32, 32, 2)[:, ::2].reshape(-1, 2).copy(), np.arange(16)
    positions[:, 1] = np.tile(DX * (row + 0.5) / 2.0, 32)
    squeezed = positions, np.full(len(positions), DX**2 / 4.0)
    found["squeezed", 0.0] = squeezed, ICE, {**periodic, "strain": np.log([0.5, 1.0])}, np.sqrt(1.0 + np.log(2.0)), 0.0
    for cells in (0.5, 1.0):
        found[f"passing lone {cells:g}", 0.1] = lone_grain(dim, 0.1), ICE, periodic, 1.0, cells
        found[f"passing 2 {cells:g}", 0.0] = spread(2, dense, dim, 0.0), ICE, periodic, 1.0, cells
    snow, hard = material_card("stomakhin"), 0.7
    faster = snow.wave_speed_at(np.zeros((1, 6)), np.array([[hard]]))[0] / snow.wave_speed()
    found["hardened", 0.25] = lone_grain(dim, 0.25), snow, {"state": hard}, faster, 0.0
    return found


def critical(scheme, grains, law, options, faster, cells):
    """Largest C that is stable; options, faster and cells as in `bodies`."""
    kernel, gradient, transfer = scheme
    lowest, highest = LOWEST, HIGHEST
    while highest / lowest > RESOLUTION:
        C = np.sqrt(lowest * highest)
        dt = C * DX / (law.wave_speed() * faster)
        drift = cells * DX / dt
        solver, energy = stirred(grains, law, kernel=kernel, gradient=gradient, transfer=transfer, drift=drift,
                                 **options)
        if blows_up(solver, faster**2 * energy, dt, STEPS, drift):
            highest = C
        else:
            lowest = C
    return lowest


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures", help="folder")
    parser.add_argument("--only", default="", help="schemes whose kernel-gradient-transfer-dimension holds this")
    arguments = parser.parse_args()
    runtime.start("cpu")
    rows = []
    everything = [(*scheme, 2) for scheme in SCHEMES] + [(*scheme, 3) for scheme in IN_3D]
    for *scheme, dim in everything:
        if arguments.only not in f"{'-'.join(scheme)}-{dim}":
            continue
        found = {}
        for (name, offset), (grains, law, *how) in bodies(dim, BASES[scheme[0]].box).items():
            C = critical(scheme, grains, law, *how)
            found[name, offset] = C * np.sqrt(grain_stiffness(law, dim))
            rows.append((*scheme, dim, name, offset, law.poisson_ratio, f"{C:.3f}", f"{found[name, offset]:.3f}"))
        worst = min(found, key=found.get)
        full = min(value for (name, _), value in found.items() if name in ("2", "3", "4"))
        print(f"{' '.join(scheme):24s} {dim}-D  C sqrt(s) {found[worst]:.3f} ({worst[0]} at {worst[1]:g}),"
              f" full lattices {full:.3f}", flush=True)
    arguments.output.mkdir(parents=True, exist_ok=True)
    path = arguments.output / "critical_step.csv"
    measured = {tuple(map(str, row[:7])) for row in rows}  # rows of other schemes stay
    kept = [row for row in list(csv.reader(path.open(newline="")))[1:] if tuple(row[:7]) not in measured] \
        if arguments.only and path.exists() else []
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *kept, *rows])


if __name__ == "__main__":
    main()
