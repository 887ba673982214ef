"""Small flows through every basis and transfer: `python -m tests.mpm.determinism_cases THREADS CASE ...` prints what
came out.

In each of them two bodies with velocity fields of their own slide over curved ground between periodic sides against a
turning obstacle, and particles change blocks.
"""

import hashlib
import itertools
import json
import sys

import numpy as np

from snowmpm.compiler import parallel, runtime
from snowmpm.components.body_contact.mpm import BodyContact
from snowmpm.materials import CohesiveCamClay
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion, Uniform
from snowmpm.solids.primitives import BOX
from snowmpm.solids.shape import SolidShape
from tests.support.waves import Waves

DX = 0.1
STEPS = 40
SNOW, OLD_SNOW = (CohesiveCamClay(density=density, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2,
                                  cohesion=0.3, hardening=1.0, p0=2e3) for density in (250.0, 350.0))
CASES = {f"2-D {kernel} {transfer}": (2, kernel, transfer, "affine")
         for kernel, transfer in itertools.product(("quadratic", "cubic"), ("apic", "pic", "flip", "aflip"))}
CASES["2-D cubic flip shape"] = 2, "cubic", "flip", "shape"
CASES["2-D cubic pic shape"] = 2, "cubic", "pic", "shape"
CASES["3-D quadratic apic"] = 3, "quadratic", "apic", "affine"
CASES["3-D cubic aflip"] = 3, "cubic", "aflip", "affine"
QUICK = ("2-D quadratic flip", "2-D cubic pic shape", "3-D quadratic apic")
"""Both bases, gradients and dimensions, and the transfers by themselves; the others take minutes to compile."""


def box(lower, upper, rng):
    """Particles at random, 2^dim a cell of a box: positions, volumes."""
    size = np.subtract(upper, lower)
    n = int(np.prod(2 * size / DX))
    return np.asarray(lower) + rng.uniform(size=(n, len(size))) * size, np.full(n, np.prod(size) / n)


def stage(dim, kernel, transfer, gradient):
    """Solver of one case."""
    rng, across = np.random.default_rng(17), [0.4] * (dim - 2)
    floor = [0.0] * (dim - 2)
    (x_1, v_1), (x_2, v_2) = (box([0.0, *floor, 0.04], [1.0, *across, 0.3], rng),
                              box([0.1, *floor, 0.3], [0.7, *across, 0.6], rng))
    velocities = rng.normal(0.0, 0.5, (len(v_1) + len(v_2), dim))
    velocities[:, 0] += 8.0
    velocities[len(v_1) :, -1] -= 3.0
    which = np.repeat([0, 1], [len(v_1), len(v_2)])
    middle, omega = np.array([1.3, *across, 0.3]), 2.0 if dim == 2 else np.array([0.5, 2.0, 1.0])
    turning = RigidMotion(middle, Uniform(np.array([-4.0, *floor, 0.0]), omega))
    bar = Obstacle("bar", SolidShape(BOX, middle, np.eye(dim), np.full(dim, 0.12)), turning, "separate", 0.3)
    lower, upper = np.array([0.0, *floor, -0.5]), np.array([1.6, *across, 2.0])
    sides = [["periodic", "periodic"], *[["slip", "slip"]] * (dim - 2), ["stick", "open"]]
    pull = np.zeros(dim)
    pull[-1] = -9.81
    return MpmSolver(Population(np.concatenate([x_1, x_2]), np.concatenate([v_1, v_2]), which, velocities, field=which),
                     [SNOW, OLD_SNOW], dx=DX, precision="f32", origin=lower,
                     lower=lower, upper=upper, gravity=pull, terrain=Waves(), terrain_contact="separate",
                     terrain_friction=0.5, sides=sides, obstacles=[bar],
                     adapters=[BodyContact(np.full((2, 2), 0.3), ["", ""])],
                     kernel=kernel, transfer=transfer, gradient=gradient, flip_ratio=0.97)


def outcome(case):
    """Hash of all numbers that a run leaves, and what shows that every part of the case had its part in it."""
    solver = stage(*case)
    for _ in range(STEPS):
        solver.step(solver.stable_dt()[0])
    numbers = [solver.particles.table(), solver.particles.labels(), solver.particles.blocks.keys, solver.impulse,
               solver.obstacle_totals, solver.grid.fields.totals,
               [solver.contact_work, solver.plastic_work, solver.time],
               *(surface.total for surface in solver.surfaces)]
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in numbers)).hexdigest()
    return {"hash": digest, "sorts": solver.particles.sorts, "blocks": len(solver.particles.blocks),
            "plastic_work": solver.plastic_work, "alone": solver.serial,
            "between_bodies": solver.grid.fields.lost,
            "terrain": float(np.abs(solver.surfaces[0].total).max()),
            "obstacle": float(np.abs(solver.obstacle_totals).max())}


def main(threads, *names):
    """The named cases twice, in one process: kernels are compiled once."""
    runtime.start("cpu", threads)
    parallel.LITTLE_WORK = 0.0  # scenes as small as these would be left to one thread of the two
    runs = [{name: outcome(CASES[name]) for name in names} for _ in range(2)]
    print(json.dumps({"threads": runtime.threads(), "runs": runs}))


if __name__ == "__main__":
    main(int(sys.argv[1]), *sys.argv[2:])
