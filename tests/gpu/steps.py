"""A few steps of small scenes, by the kernels of a CPU, by those of a GPU on a CPU, or on a GPU.

    python tests/gpu/steps.py packs|fine|paired|cuda|cuda_paired f32|f64 FILE.npz

paired: with two numbers an entry, as of more particles than can be told apart otherwise (`particles.store`). One way a
process, since Taichi starts once. FILE gets positions [m], velocities [m/s] and loads (stress [Pa], depth [m] of
columns) of every case, by particle number, and how many particles yielded.
"""

import sys
from dataclasses import replace

import numpy as np

import snowmpm
from snowmpm.compiler import runtime
from snowmpm.particles.store import Layout

AT_ONCE = {"initial.stress": "geostatic"}
CASES = {
    "terrain, 3-D": ("slab_release_resolved", {"solver.dx": 0.5, "solver.particles_per_cell": 4, **AT_ONCE}, 25),
    "obstacle": ("impact_wedge_2d", {"solver.dx": 0.25, **AT_ONCE}, 40),
    "classical": ("column_collapse_2d", {"solver.dx": 0.025, "solver.transfer": "flip", "solver.kernel": "cubic",
                                         "solver.gradient": "shape", **AT_ONCE}, 60),
    "SPH": ("column_collapse_2d", {"solver.dx": 0.025, "solver.method": "sph", **AT_ONCE}, 40),
    "SPH, 3-D": ("column_collapse_3d", {"solver.dx": 0.05, "solver.method": "sph", **AT_ONCE}, 15),
    "columns": ("avalanche_depth_averaged", {"solver.dx": 10.0}, 60),
}

GROWTH = {("fine", "f64"): 1e-12, ("fine", "f32"): 1e-5, ("cuda", "f64"): 1e-9, ("cuda", "f32"): 1e-2}
"""Largest difference, of the largest number: round-off over a few dozen steps (measured: 4e-15 and 1.4e-6 of it on a
CPU). A GPU's compiler fuses multiply-adds besides: not measured, so that room is left for particles that yield in one
of two runs only."""


def state_after(scene, changes, steps, precision):
    """What the particles of a scene have come to after so many steps."""
    simulation = snowmpm.Simulation(snowmpm.load_scene(scene, {**changes, "solver.precision": precision}))
    for _ in range(steps):
        simulation.step()
    fields = simulation.particles
    order, load = np.argsort(fields["id"]), fields["depth"] if simulation.scene.solver.in_plan else fields.kirchhoff()
    layout = getattr(simulation.solver.particles, "layout", None)
    layout = getattr(simulation.solver.particles, "layout", None)
    return {"position": fields["position"][order], "velocity": fields["velocity"][order], "load": load[order],
            "plastic": np.array([getattr(simulation.solver, "n_plastic", 0)]),
            "paired": np.array([getattr(layout, "paired", False)])}


def main():
    way, precision, path = sys.argv[1:]
    runtime.start("cuda" if way.startswith("cuda") else "cpu", threads=1, fine_grained=way != "packs")
    if way.endswith("paired"):
        Layout.fitting = lambda self, *_: replace(self, paired=True)
    found = {}
    for name, (scene, changes, steps) in CASES.items():
        found |= {f"{name}/{key}": values for key, values in state_after(scene, changes, steps, precision).items()}
    np.savez(path, **found)


if __name__ == "__main__":
    main()
