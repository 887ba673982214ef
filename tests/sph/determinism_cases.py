"""Small flows of SPH: `python -m tests.sph.determinism_cases THREADS` prints what came out.

In each a body falls on rough curved ground between periodic or mirrored sides, against a turning bar.
"""

import hashlib
import json
import sys

import numpy as np

from snowmpm.compiler import parallel, runtime
from snowmpm.materials import CohesiveCamClay
from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion, Uniform
from snowmpm.solids.primitives import BOX
from snowmpm.solids.shape import SolidShape
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import jittered, solver_of
from tests.support.waves import Waves

DX, STEPS = 0.05, 60
SNOW = CohesiveCamClay(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2, cohesion=0.3,
                       hardening=1.0, p0=2e3)
CASES = {"2-D": (2, {"regularisation": "mls", "regularisation_interval": 7}),
         "2-D tension": (2, {"artificial_stress": 0.3, "walls": "most_compressive", "confining_pressure": 50.0}),
         "3-D": (3, {"kernel": "cubic_spline", "smoothing": 1.2})}


def stage(dim, scheme, haste=1.0):
    """Solver of one case; haste: factor of all velocities."""
    rng, across = np.random.default_rng(17), [0.4] * (dim - 2)
    floor = [0.0] * (dim - 2)
    positions, volumes = lattice([0.2, *floor, 0.05], [0.8, *across, 0.45], DX, 1)
    velocities = rng.normal(0.0, 0.5, positions.shape)
    velocities[:, 0] += 6.0
    velocities[:, -1] -= 2.0
    velocities *= haste
    middle, omega = np.array([1.0, *across, 0.2]), haste * (2.0 if dim == 2 else np.array([0.5, 2.0, 1.0]))
    turning = RigidMotion(middle, Uniform(haste * np.array([-2.0, *floor, 0.0]), omega))
    bar = Obstacle("bar", SolidShape(BOX, middle, np.eye(dim), np.full(dim, 0.1)), turning, "separate", 0.3)
    gravity = np.zeros(dim)
    gravity[-1] = -9.81
    return solver_of(jittered(positions, DX, 0.1), volumes, SNOW, dx=DX, velocity=lambda x: velocities,
                     precision="f32", lower=[0.0, *floor, -0.5], upper=[1.6, *across, 2.0], gravity=gravity,
                     terrain=Waves(), terrain_contact="separate", terrain_friction=0.5,
                     sides=[["periodic", "periodic"], *[["slip", "slip"]] * (dim - 2), ["stick", "open"]],
                     obstacles=[bar], scheme=scheme)


def numbers(solver):
    """Everything that a run leaves."""
    return [solver.particles.table(), solver.particles.labels(), solver.particles.blocks.keys, solver.impulse,
            solver.obstacle_totals, [solver.contact_work, solver.plastic_work, solver.time],
            *(surface.total for surface in solver.surfaces)]


def outcome(case):
    """Hash of all numbers that a run leaves, and what shows that every part of the case had its part in it."""
    solver = stage(*case)
    for _ in range(STEPS):
        solver.step(solver.stable_dt()[0])
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in numbers(solver))).hexdigest()
    return {"hash": digest, "sorts": solver.particles.sorts, "plastic_work": solver.plastic_work,
            "terrain": float(np.abs(solver.surfaces[0].total).max()),
            "obstacle": float(np.abs(solver.obstacle_totals).max())}


def main(threads):
    """Every case."""
    runtime.start("cpu", threads)
    parallel.LITTLE_WORK = 0.0  # scenes as small as these would be left to one thread of the two
    print(json.dumps({"threads": runtime.threads(), "cases": {name: outcome(case) for name, case in CASES.items()}}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
