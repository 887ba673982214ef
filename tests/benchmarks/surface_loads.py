"""Picture of the three kinds of forces on surfaces: snow that they bend and press, their points and loads.

    python tests/benchmarks/surface_loads.py [-o FILE]

Elastic snow by implicit steps in balance; colours are the stress along the line that bends or is pressed.
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2]))
from snowmpm import Simulation
from snowmpm.compiler import runtime
from snowmpm.scenes.schema import Scene

KPA = 1e-3
SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.2}
ARROW = 0.45
"""Longest arrow [m]."""

POST = {"size": [0.5, 2.0], "side": "z_min", "steps": 8, "force": {
    "kind": "traction", "value": ["5e3*t", 0.0], "within": {"min": [0.0, 0.0], "max": [0.0, 2.0]}}}
SHELF = {"size": [2.0, 0.4], "side": "x_min", "steps": 12, "force": {
    "kind": "follower_pressure", "value": "7e3*t", "within": {"min": [0.0, 0.4], "max": [2.0, 0.4]}}}
PLATE = {"size": [1.6, 1.0], "side": "z_min", "steps": 6, "force": {
    "kind": "displacement", "contact": "slip", "value": [0.0, "-t*(0.04 + 0.12*x/1.6)"],
    "within": {"min": [0.0, 1.0], "max": [1.6, 1.0]}}}
CASES = {
    "traction: keeps its direction": (POST, 1),
    "follower_pressure: stays normal": (SHELF, 0),
    "displacement, slip: a plate that tilts": (PLATE, 1)}


def loaded(size, side, steps, force):
    """`Simulation` of a block under a force, at its end."""
    sim = Simulation(Scene.model_validate({
        "name": "loaded", "dimension": 2, "end_time": 1.0, "gravity": 0.0, "output": {"interval": 1.0},
        "solver": {"method": "implicit", "dx": 0.1, "implicit": {"time": "quasi_static", "dt": 1.0 / steps}},
        "domain": {"min": [0.0 if side == "x_min" else -2.0, 0.0 if side == "z_min" else -3.0], "max": [4.0, 4.0],
                   "boundary": {side: "stick"}}, "materials": {"snow": SNOW},
        "bodies": [{"name": "snow", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0], "max": size}}],
        "forces": [{"name": "load", "body": "snow", **force}]}))
    while sim.time < 1.0 - 1e-9:
        sim.step(until=1.0)
    return sim


def draw(axes, title, case, along):
    sim = loaded(**case)
    fields, faces = sim.particles, sim.solver.adapters["face_loads"].faces
    x = fields["position"]
    stress = KPA * sim.solver.particles.column("stress")[:, along]  # xx, zz
    most = np.percentile(np.abs(stress), 99)
    dots = axes.scatter(*x.T, c=stress, s=9, lw=0.0, cmap="RdBu", vmin=-most, vmax=most)
    points, face = faces.points, faces.faces[0]
    loads = faces.forces(1.0, 1e-9, np.ones(faces.count, bool)) / points.size[:, None]  # Pa
    place, length = points.place, ARROW / np.linalg.norm(loads, axis=1).max()
    tail = place - length * loads
    axes.quiver(*tail.T, *(length * loads).T, angles="xy", scale_units="xy", scale=1.0, width=0.0035, color="0.15")
    axes.scatter(*place.T, s=7, color="black", zorder=3)
    axes.scatter(*points.rest.T, s=3, color="0.6", zorder=0)
    size = case["size"]
    axes.plot([0, size[0], size[0], 0, 0], [0, 0, size[1], size[1], 0], ":", color="0.6", lw=0.8, zorder=0)
    axes.set(aspect="equal")
    axes.set_axis_off()
    axes.set_title(title, fontsize=10)
    axes.figure.colorbar(dots, ax=axes, shrink=0.5, aspect=20, label=f"stress along {'xz'[along]} [kPa]",
                         location="bottom", pad=0.02)
    force = np.round(KPA * face.given.force, 2)
    print(title, "force on the snow [kN/m]", force, "points", faces.count, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("surface_loads.png"))
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    figure, axes = plt.subplots(1, 3, figsize=(11.0, 4.2), layout="constrained", width_ratios=(1.0, 1.2, 1.1))
    for ax, (title, (case, along)) in zip(axes, CASES.items(), strict=True):
        draw(ax, title, case, along)
    figure.savefig(options.output, dpi=110)
    Image.open(options.output).convert("RGB").quantize(128).save(options.output, optimize=True)


if __name__ == "__main__":
    main()
