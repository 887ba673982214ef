"""Snow that falls asleep and wakes: `python -m tests.mpm.sleep_cases THREADS CASE` prints what came out.

A layer on curved ground comes to rest; then a box of snow falls on one end of it. In the middle the particles of some
run are saved, and another solver goes on from there.
"""

import hashlib
import json
import sys

import numpy as np

from snowmpm.compiler import parallel, runtime
from snowmpm.materials import DruckerPrager
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.schemes import lattice
from tests.support.waves import Waves

DX, LONG, DEEP = 0.1, 6.4, 0.2
SAND = DruckerPrager(density=300.0, youngs_modulus=3e6, poisson_ratio=0.3, friction_angle=35.0)
CASES = {"2-D f64 apic": (2, "f64", "apic"), "3-D f32 aflip": (3, "f32", "aflip")}
CALM, IMPACT, END = 0.03, 0.44, 0.5


def stage(dim, precision, transfer, *, sleeping=CALM, drop=True, deep=DEEP, long=LONG, closed=False, **options):
    """Solver of a layer, and a box that falls on its left end; closed: between smooth walls."""
    across = [2 * DX] * (dim - 2)
    floor = [0.0] * (dim - 2)
    parts = [lattice([0.0, *floor, 0.03], [long, *across, 0.03 + deep], DX)]
    if drop:
        parts.append(lattice([0.2, *floor, 1.0], [0.6, *across, 1.4], DX))
    x, volumes = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    pull, lower, upper = np.zeros(dim), np.array([-1.0, *floor, -0.5]), np.array([LONG + 1.0, *across, 4.0])
    pull[-1] = -9.81
    if closed:
        lower[0], upper[0] = 0.0, long
    return MpmSolver(Population(x, volumes, 0), [SAND], dx=DX, precision=precision, origin=lower, lower=lower,
                     upper=upper, gravity=pull, terrain=Waves(), terrain_contact="separate", terrain_friction=0.6,
                     sides=[["slip" if closed else "open"] * 2, *[["slip", "slip"]] * (dim - 2), ["open", "open"]],
                     transfer=transfer, sleeping=sleeping, **options)


def settle(solver):
    """Damped steps to rest, then undamped ones until all of it sleeps, for a second at most; -> solver, its state and
    the momentum at the start."""
    for k in range(300):
        solver.damp(0.95 if k < 299 else 1.0)
        solver.step(solver.stable_dt()[0])
    solver.restart_clock()
    start = solver.particles.masses() @ solver.particles.column("velocity")
    while solver.totals.asleep < 1.0 and solver.time < 1.0:
        solver.step(solver.stable_dt()[0])
    return solver, solver.state(), start


def advance(solver, until):
    """Steps up to this number; -> share asleep after each."""
    shares = []
    while solver.steps < until:
        solver.step(solver.stable_dt()[0])
        shares.append(solver.totals.asleep)
    return shares


def digest(solver):
    """Hash of all numbers that a run leaves."""
    totals = solver.totals
    numbers = [solver.particles.table(), solver.particles.labels(), solver.particles.blocks.keys, totals.impulse,
               totals.held_impulse, [totals.slept_energy, totals.asleep, solver.time], solver.sleep.asleep]
    return hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in numbers)).hexdigest()


def outcome(case, resumes):
    """Hashes of a run, and if it `resumes` of one that goes on from the middle of it; when how much slept."""
    solver, shares = stage(*case), []
    while not shares or (shares[-1] < 0.2 and solver.time < IMPACT):
        shares += advance(solver, solver.steps + 10)
    saved = solver.state()
    while solver.time < END:
        shares += advance(solver, solver.steps + 1)
    found = {"hash": digest(solver), "shares": shares, "saved": float(saved["sleep"]["asleep"].mean())}
    if resumes:
        other = stage(*case)
        other.restore(saved)
        while other.time < END:
            advance(other, other.steps + 1)
        found["resumed"] = digest(other)
    return found


def main(threads, name):
    runtime.start("cpu", threads)
    parallel.LITTLE_WORK = 0.0  # scenes as small as these would be left to one thread of the two
    print(json.dumps({"threads": runtime.threads(), **outcome(CASES[name], resumes=threads == 1)}))


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
