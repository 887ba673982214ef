"""Do two checkouts compute the same, bit by bit? Run after a change that must not change any result.

    python .ci/same_bits.py OLD NEW [--steps 60] [--only TEXT]

OLD and NEW are folders of the repository (a second one: `git worktree add ../old main`). Library scenes by both
methods, coarse, and a column of every law run for some steps from each folder, in a process of their own. A table shows
the hash of positions, velocities, stresses and states; the exit code is 1 where one differs. Hashes depend on the
machine, so none is kept.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

COLUMN = {"solver.dx": 0.02, "initial.stress": "none"}
SOIL = {"density": 1500.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
CLAY = {**SOIL, "critical_slope": 1.2, "hardening": 1.0, "p0": 500.0}
MATERIALS = {
    "elastic": SOIL,
    "von_mises": {**SOIL, "yield_stress": 500.0, "hardening_modulus": 1e4},
    "drucker_prager": {**SOIL, "friction_angle": 30.0, "cohesion": 100.0, "softening_strain": 0.01},
    "mohr_coulomb": {**SOIL, "friction_angle": 30.0, "dilation_angle": 5.0, "cohesion": 50.0},
    "mu_i": {**SOIL, "static_friction": 0.38, "limit_friction": 0.64, "grain_diameter": 1e-3, "grain_density": 2500.0},
    "modified_cam_clay": CLAY,
    "cohesive_cam_clay": {**CLAY, "cohesion": 0.1},
    "anticrack_cam_clay": {**CLAY, "cohesion": 0.1, "softening": 0.5},
    "stomakhin_snow": {**SOIL, "hardening": 10.0, "critical_compression": 1e-3, "critical_stretch": 5e-4},
    "critical_state_hypoplastic": {
        **SOIL, "poisson_ratio": 0.0, "reference_pressure": 5e3, "friction_angle": 30.0, "least_void_ratio": 0.5,
        "void_ratio": 0.7, "critical_void_ratio_limit": 0.55, "critical_void_ratio_drop": 0.25, "density_effect": 0.2},
}
CASES = {
    "slab_release_2d": ("slab_release_2d", {"solver.dx": 0.2}),
    "column_collapse_2d": ("column_collapse_2d", {"solver.dx": 0.02}),
    "column_collapse_2d sph": ("column_collapse_2d", {"solver.dx": 0.02, "solver.method": "sph"}),
    "column_collapse_3d": ("column_collapse_3d", {"solver.dx": 0.04}),
    "sand_between_plates": ("sand_between_plates", {"solver.dx": 0.02}),
    "sand_between_plates sph": ("sand_between_plates", {"solver.dx": 0.02, "solver.method": "sph"}),
    **{kind: ("column_collapse_2d", {**COLUMN, "materials.sand": {"kind": kind, **numbers}})
       for kind, numbers in MATERIALS.items()},
    "cohesive_cam_clay sph": ("column_collapse_2d", {
        **COLUMN, "solver.method": "sph",
        "materials.sand": {"kind": "cohesive_cam_clay", **MATERIALS["cohesive_cam_clay"]}}),
    "cohesive_cam_clay substepped": ("column_collapse_2d", {**COLUMN, "materials.sand": {
        "kind": "cohesive_cam_clay", "return_map": "substepped", **MATERIALS["cohesive_cam_clay"]}}),
}
PACKAGES = ("materials", "scenes", "render")
"""Packages that lie beside snowmpm in the repository and are parts of it when installed."""


def outcome(name, overrides, steps):
    """Hash of a scene after some steps, and what shows that something happened."""
    import snowmpm

    if overrides.get("solver.method") == "sph":
        overrides = {**overrides, "solver": {"dx": overrides["solver.dx"], "method": "sph"}}
        overrides = {key: value for key, value in overrides.items() if not key.startswith("solver.")}
    simulation = snowmpm.Simulation(snowmpm.load_scene(name, overrides))
    for _ in range(steps):
        simulation.step()
    digest, fields = hashlib.sha256(), simulation.particles
    for values in (fields["id"], *(fields[field] for field in ("position", "velocity", "stress", "J")), fields.state()):
        digest.update(values.tobytes())
    digest.update(repr(simulation.time).encode())
    return {"hash": digest.hexdigest()[:16], "time": simulation.time, "plastic": simulation.solver.plastic_work}


def outcomes_of(checkout, steps, names):
    """`outcome` of each case, computed by the code of a checkout."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "snowmpm"
        package.mkdir()
        parts = [*(checkout / "snowmpm").iterdir(), *(checkout / name for name in PACKAGES)]
        for part in parts:
            (package / part.name).symlink_to(part)
        environment = {**os.environ, "PYTHONPATH": folder, "PYTHONDONTWRITEBYTECODE": "1"}
        done = subprocess.run([sys.executable, __file__, "--steps", str(steps), "--cases", json.dumps(names)],
                              env=environment, stdout=subprocess.PIPE, text=True, check=True, cwd=folder)
    return json.loads(done.stdout.splitlines()[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkouts", nargs="*", type=Path, metavar="OLD NEW")
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--only", default="", help="cases whose name has this text")
    parser.add_argument("--cases", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.cases:
        print(json.dumps({name: outcome(*CASES[name], arguments.steps) for name in json.loads(arguments.cases)}))
        return 0
    if len(arguments.checkouts) != 2:
        parser.error("two checkouts are needed, OLD and NEW")
    names = [name for name in CASES if arguments.only in name]
    with ThreadPoolExecutor() as pool:
        old, new = pool.map(lambda path: outcomes_of(path.resolve(), arguments.steps, names), arguments.checkouts)
    for name in names:
        same = old[name]["hash"] == new[name]["hash"]
        print(f"{name:32} {old[name]['hash']} {new[name]['hash']} {'same' if same else 'DIFFERENT'}"
              f"  t = {new[name]['time']:.4g} s, plastic work {new[name]['plastic']:.3g} J")
    return int(any(old[name]["hash"] != new[name]["hash"] for name in names))


if __name__ == "__main__":
    sys.exit(main())
