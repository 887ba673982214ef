"""Do two checkouts compute the same, bit by bit? Run after a change that must not change any result.

    python .ci/same_bits.py OLD NEW [--steps 60] [--only TEXT]

OLD and NEW are folders of the repository (a second one: `git worktree add ../old main`). All methods, both precisions,
a column of every law and a scene of every optional feature, coarse, run for some steps from each folder, in a process
of its own; each case runs a second time from its state half-way. A table shows what differs of the public fields of the
particles, the audit and the time; the exit code is 1 where something does. Hashes depend on the machine, so none is
kept.
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

DOCS, TESTS = (Path(__file__).resolve().parents[1] / name for name in ("docs", "tests"))

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
VALLEY = {"solver.dx": 20.0}
CASES = {
    "slab_release_2d": ("slab_release_2d", {"solver.dx": 0.2}),
    "column_collapse_2d": ("column_collapse_2d", {"solver.dx": 0.02}),
    "column_collapse_2d double": ("column_collapse_2d", {"solver.dx": 0.02, "solver.precision": "f64"}),
    "column_collapse_2d sph": ("column_collapse_2d", {"solver.dx": 0.02, "solver.method": "sph"}),
    "column_collapse_2d sph double": ("column_collapse_2d", {
        "solver.dx": 0.02, "solver.method": "sph", "solver.precision": "f64"}),
    "column_collapse_3d": ("column_collapse_3d", {"solver.dx": 0.04}),
    "column_collapse_3d aflip cubic": ("column_collapse_3d", {
        "solver.dx": 0.06, "solver.transfer": "aflip", "solver.kernel": "cubic"}),
    "sand_between_plates": ("sand_between_plates", {"solver.dx": 0.02}),
    "sand_between_plates sph": ("sand_between_plates", {"solver.dx": 0.02, "solver.method": "sph"}),
    **{kind: ("column_collapse_2d", {**COLUMN, "materials.sand": {"kind": kind, **numbers}})
       for kind, numbers in MATERIALS.items()},
    "cohesive_cam_clay sph": ("column_collapse_2d", {
        **COLUMN, "solver.method": "sph",
        "materials.sand": {"kind": "cohesive_cam_clay", **MATERIALS["cohesive_cam_clay"]}}),
    "cohesive_cam_clay substepped": ("column_collapse_2d", {**COLUMN, "materials.sand": {
        "kind": "cohesive_cam_clay", "return_map": "substepped", **MATERIALS["cohesive_cam_clay"]}}),
    "depth-averaged": ("avalanche_depth_averaged", VALLEY),
    "depth-averaged double": ("avalanche_depth_averaged", {**VALLEY, "solver.precision": "f64"}),
    "depth-averaged with water": ("slushflow", VALLEY),
    "depth-averaged, two phases": (DOCS / "dam_break_two_phases.toml", {}),
    "forest, deposition, snow cover": ("avalanche_depth_averaged", {
        **VALLEY, "terrain.deposition": {"law": "stopped", "time": 0.5},
        "terrain.entrainment": {"law": "rate", "growth_rate": 0.01, "thickness": 0.3, "density": 150.0},
        "terrain.forest": [{"name": "larches", "region": {"x": [600200.0, 600500.0], "y": [200100.0, 200400.0]},
                            "drag": 0.02, "detrainment": 60.0}]}),
    "bodies that part": ("slab_release_2d", {
        "solver.dx": 0.2, "bodies.2.contact": "separate", "initial.stress": "geostatic"}),
    "implicit": (DOCS / "terzaghi_column.toml", {"solver.dx": 0.1}),
    "implicit, poroelastic": (DOCS / "poroelastic_cantilever.toml", {"solver.dx": 0.1}),
    "interface": ("slab_release", {"solver.dx": 1.0}),
    "saw test": ("pst_2d", {"solver.dx": 0.05, "saw_test.length": 2.0}),
    "avalanche on a raster": ("avalanche_on_raster", {"solver.dx": 3.0}),
    "moving obstacles": ("oedometer", {}),
    "rigid bodies": ("boulders_2d", {"solver.dx": 0.4}),
    "wall of blocks": ("block_wall_2d", {}),
    "structure": ("fence_2d", {"solver.dx": 0.2}),
    "structure, strong coupling": ("flexible_wall_2d", {"structures.0.coupling": "strong"}),
    "loads on surfaces, damping": (DOCS / "membrane_test.toml", {"solver.dx": 0.025}),
    "mean volumes of cells": (DOCS / "sensitive_clay.toml", {"solver.dx": 1.0}),
    "pore water": (TESTS / "components" / "pore_water" / "soaked_slope.toml", {}),
    "two velocities": ("slush_dam_2d", {"solver.dx": 0.1}),
    "seepage": (DOCS / "rockfill_dam.toml", {"solver.dx": 0.1}),
    "means over a length": ("column_collapse_2d", {**COLUMN, "materials.sand": {
        **SOIL, "kind": "softening_cone", "cohesion": 500.0, "residual_cohesion": 50.0, "softening_strain": 0.1,
        "friction_angle": 20.0,
        "residual_friction_angle": 10.0, "nonlocal_length": 0.1}}),
    "ice": ("microstructure_2d", {"solver.dx": 1e-4}),
    "loads": ("skier_trigger", {"solver.dx": 0.1}),
}
LONG = {"column_collapse_3d aflip cubic": 0.25, "interface": 0.5, "avalanche on a raster": 0.25, "two velocities": 0.5,
        "seepage": 0.25, "implicit": 0.1, "implicit, poroelastic": 0.1, "depth-averaged, two phases": 0.5}
"""Shares of the steps for cases whose steps take long."""
PACKAGES = ("materials", "scenes", "render")
"""Packages that lie beside snowmpm in the repository and are parts of it when installed."""


def outcome(name, overrides, steps):
    """Hashes of a scene after some steps by name of a field, of its audit and time, and whether a run that goes on from
    its state half-way has the same."""
    import snowmpm

    if overrides.get("solver.method") == "sph":
        kept = {key: value for key, value in overrides.items() if key in ("solver.precision",)}
        overrides = {key: value for key, value in overrides.items() if not key.startswith("solver.")} | {
            "solver": {"dx": overrides["solver.dx"], "method": "sph"}} | kept
    scene = snowmpm.load_scene(str(name), overrides)
    straight, half = snowmpm.Simulation(scene), max(1, steps // 2)
    for _ in range(half):
        straight.step()
    state = straight.state()
    found = _after(straight, steps - half)
    resumed = snowmpm.Simulation(scene)
    resumed.restore(state)
    again = _after(resumed, steps - half)
    return {"hashes": found, "resumed": found == again, "time": straight.time,
            "plastic": straight.audit().get("plastic_work", 0.0)}


def _after(simulation, steps):
    for _ in range(steps):
        simulation.step()
    fields = simulation.particles
    order = fields["id"].argsort(kind="stable")
    found = {name: _hash(fields[name][order].tobytes()) for name in fields}
    audit = {key: repr(value) for key, value in sorted(simulation.audit(fields).items())}
    return {**found, "audit": _hash(repr(audit).encode()), "time": _hash(repr(simulation.time).encode())}


def _hash(content):
    return hashlib.sha256(content).hexdigest()[:12]


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
        print(json.dumps({name: outcome(*CASES[name], max(2, round(LONG.get(name, 1.0) * arguments.steps)))
                          for name in json.loads(arguments.cases)}))
        return 0
    if len(arguments.checkouts) != 2:
        parser.error("two checkouts are needed, OLD and NEW")
    for path in arguments.checkouts:
        if not (path / "snowmpm").is_dir():
            parser.error(f"{path}: no checkout of the repository, but a folder of one is needed (git worktree add)")
    names = [name for name in CASES if arguments.only in name]
    with ThreadPoolExecutor() as pool:
        old, new = pool.map(lambda path: outcomes_of(path.resolve(), arguments.steps, names), arguments.checkouts)
    wrong = 0
    for name in names:
        one, other = old[name]["hashes"], new[name]["hashes"]
        differ = [key for key in one if key in other and one[key] != other[key]]
        gone = sorted(set(one) ^ set(other))
        words = "same" if not differ else f"DIFFERENT: {', '.join(differ)}"
        words += "" if new[name]["resumed"] else "; NOT THE SAME when resumed half-way"
        words += f"; only in one: {', '.join(gone)}" if gone else ""
        print(f"{name:32} t = {new[name]['time']:.4g} s, plastic work {new[name]['plastic']:.3g} J: {words}")
        wrong += bool(differ) or not new[name]["resumed"]
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
