"""Cost of one stress update, ns per particle on one core: trial, logarithm, return map, new state, loads and stores.

    python tests/benchmarks/stress_update.py [--particles N] [--repeat N] [--law NAME ...] [-o FOLDER]

Every particle is first compressed and sheared by 1 % (more or less where a law asks for it), each in a direction of its
own, so that it yields; then half of them, in random order, go on in their direction and yield again, and half go back
and do not (--yielding sets the share). The measured increments have strains of 1e-4 (a step of an explicit solver) and
a random rotation. The least processor time over the repeats is taken, since other programs may use the machine, and of
two counts of particles the difference, which leaves out what starting a kernel costs. "copy" loads and stores the same
arrays and computes nothing. Laws with a straight-line form (`Law.vector_update`) are measured in packs too.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import taichi as ti

from snowmpm import materials as m
from snowmpm.compiler import runtime


@ti.func
def copy_update(prm, h, state, A, dt):
    return h, h, state, A.sum(), 0


class Copy(m.Elastic):
    """No law at all: what it costs to load and store."""

    update = staticmethod(copy_update)
    vector_update = staticmethod(copy_update)


SLAB = {"density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3}
CRITICAL = {**SLAB, "critical_slope": 1.5, "hardening": 1.0, "p0": 3e4}
SAND = {"density": 1850.0, "youngs_modulus": 2e7, "poisson_ratio": 0.2, "friction_angle": 30.0}
LAWS = {
    "copy": Copy(**SLAB),
    "elastic": m.Elastic(**SLAB),
    "neo_hookean": m.NeoHookean(**SLAB),
    "st_venant_kirchhoff": m.StVenantKirchhoff(**SLAB),
    "cohesive_crack": m.CohesiveCrack(**SLAB, strength=3e3, fracture_energy=1.0, friction_angle=30.0, length=0.05),
    "von_mises": m.VonMises(**SLAB, yield_stress=2e4),
    "drucker_prager": m.DruckerPrager(**SAND),
    "drucker_prager, softening": m.DruckerPrager(**SAND, cohesion=1e4, softening_strain=0.1),
    "softening_cone": m.SofteningCone(**SAND, residual_friction_angle=25.0, softening_strain=0.05),
    "wet_snow": m.WetSnow(**SAND, cohesion=1e4, softening_strain=0.1, water_weakening=23.5),
    "mohr_coulomb": m.MohrCoulomb(**SAND),
    "mu_i": m.MuI(density=1500.0, youngs_modulus=1e7, poisson_ratio=0.3, static_friction=0.38, limit_friction=0.64,
                  grain_diameter=1e-3, grain_density=2500.0),
    "mu_phi_i": m.MuPhiI(density=1500.0, youngs_modulus=1e7, poisson_ratio=0.3, static_friction=0.38,
                         limit_friction=0.64, grain_diameter=1e-3, grain_density=2600.0),
    "modified_cam_clay": m.ModifiedCamClay(**CRITICAL),
    "cohesive_cam_clay": m.CohesiveCamClay(**CRITICAL, cohesion=0.3),
    "cohesive_cam_clay, frozen": m.CohesiveCamClay(**CRITICAL, cohesion=0.3, return_map="frozen"),
    "cohesive_cam_clay, substepped": m.CohesiveCamClay(**CRITICAL, cohesion=0.3, return_map="substepped"),
    "anticrack_cam_clay": m.AnticrackCamClay(**{**CRITICAL, "hardening": 0.1}, cohesion=0.3, softening=0.05),
    "stomakhin_snow": m.StomakhinSnow(density=400.0, youngs_modulus=1.4e5, poisson_ratio=0.2, hardening=10.0,
                                      critical_compression=0.025, critical_stretch=0.0075),
    "hypoplastic": m.Hypoplastic(**SAND),
    "critical_state_hypoplastic": m.CriticalStateHypoplastic(
        **SAND, void_ratio=0.6, least_void_ratio=0.4, critical_void_ratio_limit=0.9, critical_void_ratio_drop=0.3,
        density_effect=0.2),
    "solid_to_gas": m.SolidToGas(
        **SAND, void_ratio=0.6, least_void_ratio=0.4, critical_void_ratio_limit=0.9, critical_void_ratio_drop=0.3,
        density_effect=0.2, collision_time=8e-4),
}
COLUMNS = ("law", "dimension", "precision", "ns_per_update", "ns_in_packs", "yielding", "iterations")


def states(law, dimension, n, rng, strain=1e-4, yielding=0.5):
    """h, state and A of n particles, of which about the given share yields in the step."""
    if hasattr(law, "return_map"):  # a frozen return ends inside its new surface
        law = law.model_copy(update={"return_map": "implicit"})
    update = m.StressUpdate(law, dimension, "f64")
    direction = rng.normal(size=(n, dimension, dimension))
    direction += direction.transpose(0, 2, 1)
    direction /= np.linalg.norm(direction, axis=(1, 2))[:, None, None]
    direction -= 0.5 * np.eye(dimension)
    h, first = np.zeros((n, 4 if dimension == 2 else 6)), 0.01
    if isinstance(law, m.Hypoplastic | m.CriticalStateHypoplastic):
        h, first = m.pack(np.tile(law.h_from_stress(-1e4 * np.eye(3)), (n, 1, 1)), dimension), 0.001
    if isinstance(law, m.StomakhinSnow):
        first = 0.05  # its elastic range is wide
    before = update(h, update.initial_state(n), first * direction, 1e-3)
    spin = rng.normal(size=(n, dimension, dimension))
    onward = np.where(rng.random(n) < yielding, 1.0, -1.0)[:, None, None]
    return before.h, before.state, strain * (onward * direction + 0.5 * (spin - spin.transpose(0, 2, 1)))


def measure(law, dimension, precision, n, repeat, yielding, packed=False):
    """ns per update, share of particles that yielded, mean iterations of those."""
    update = m.StressUpdate(law, dimension, precision, packed)
    h, state, A = states(law, dimension, 2 * n, np.random.default_rng(1), yielding=yielding)
    runs = [update.prepare(h[:k], state[:k], A[:k, None], 1e-3) for k in (n, 2 * n)]
    result = [run() for run in runs][1]
    least = [np.inf, np.inf]
    for _ in range(repeat):
        for k, run in enumerate(runs):
            start = time.process_time()
            run()
            least[k] = min(least[k], time.process_time() - start)
    plastic = result.iterations[:, 0] > 0
    return 1e9 * (least[1] - least[0]) / n, plastic.mean(), result.iterations[plastic].mean() if plastic.any() else 0.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--particles", type=int, default=20_000)
    parser.add_argument("--repeat", type=int, default=100)
    parser.add_argument("--yielding", type=float, default=0.5)
    parser.add_argument("--law", choices=LAWS, action="append")
    parser.add_argument("-o", "--out", type=Path)
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    measure(LAWS["elastic"], 3, "f64", options.particles, options.repeat, 0.5)  # wakes the processor up
    rows = []
    for name in options.law or LAWS:
        for dimension in (2, 3):
            for precision in ("f32", "f64"):
                ns, share, count = measure(
                    LAWS[name], dimension, precision, options.particles, options.repeat, options.yielding
                )
                packs = np.nan
                if LAWS[name].vector_update is not None:
                    packs, _, _ = measure(
                        LAWS[name], dimension, precision, options.particles, options.repeat, options.yielding, True
                    )
                rows.append((name, dimension, precision, *(round(x, d) for x, d in zip(
                    (ns, packs, share, count), (1, 1, 3, 2), strict=True))))
                print("{:30s} {}-D {}  {:6.1f} ns   in packs {:6.1f} ns   yielding {:.2f}   iterations {:.2f}".format(
                    *rows[-1]), flush=True)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        with open(options.out / "stress_update.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows(rows)


if __name__ == "__main__":
    main()
