"""A cube of voxel snow with breaking ice under a load of fixed direction: pull, shear, push and what lies between.

The ice of the library's scene `microstructure`, made samples (`setup.random_microstructure`), periodic sides. The foot is
rough and still; a head of elastic ice grows on the sample, and a traction on it grows with time in one direction. The
periodic sides keep the head from turning. What the foot feels over the section of the cube is the homogenised stress:
sigma, positive in compression, and tau.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene
from snowmpm.setup.random_microstructure import random_microstructure
from tests.support.driven import loads

VOXEL, CORRELATION, SIDE, FRACTION = 5e-5, 3.0, 48, 0.30
"""Edge of a voxel [m], length of the structure and edge of the cube [voxels], share of ice: 275 kg/m3."""
DX = 8e-5
"""Of the grid [m]: that of the library's scene, 1.6 voxels."""
RATE = 1.5e9
"""Growth of the load [Pa/s]: the weakest path fails after some ten transits of a wave, the strongest after fifty."""
SOFT_START = 2e-5
"""In which the load takes up its rate [s]."""
DROP = 0.2
"""Relative fall of the load on the foot after its maximum that makes this the peak; as of `results.compression`."""
END, READINGS = 4e-4, 400
"""Longest test [s]; readings in it."""
PATHS = {"pull": (-1.0, 0.0), "shear and pull": (-0.5, 1.0), "shear": (0.0, 1.0), "shear and push": (0.5, 1.0),
         "as much push": (1.0, 1.0), "push and shear": (2.0, 1.0), "push": (1.0, 0.0)}
"""Direction of each load, (sigma, tau), from pull to push."""


@dataclass(frozen=True)
class Peak:
    """Largest load along the path: sigma, tau [Pa] on the foot, the load on the head then [Pa], time [s], shortening and
    shear of the sample, strains [-], whether the load fell after it."""

    sigma: float
    tau: float
    applied: float
    time: float
    shortening: float
    shear: float
    fell: bool


def scene_of(path, image, dx=DX, rate=RATE, end=END, side=SIDE):
    """`Scene` of a load along `path`, a key of `PATHS`, on the voxels of the file `image`."""
    direction = np.array(PATHS[path]) / np.hypot(*PATHS[path])
    edge, thick = round(side * VOXEL, 9), round(4.0 * DX, 9)
    top, deep = round(edge + thick, 9), round(4.0 * dx, 9)
    ice = load_scene("microstructure").materials["ice"].model_dump(exclude_none=True)
    head = {key: ice[key] for key in ("density", "youngs_modulus", "poisson_ratio")} | {"kind": "elastic"}
    load = f"{rate:g}*t*t/(t + {SOFT_START:g})"
    return Scene.model_validate({
        "name": "voxel_snow", "dimension": 3, "end_time": end, "gravity": 0.0, "output": {"interval": end},
        "solver": {"dx": dx, "transfer": "aflip", "cfl": 0.7},
        "domain": {"min": [0.0, 0.0, -deep], "max": [edge, edge, round(top + 6.0 * DX, 9)],
                   "boundary": {f"{axis}_{end}": "periodic" for axis in "xy" for end in ("min", "max")}},
        "materials": {"ice": ice, "head": head},
        "bodies": [
            {"name": "snow", "material": "ice",
             "shape": {"kind": "voxels", "file": str(image), "voxel_size": VOXEL, "phase": 1}},
            {"name": "head", "material": "head",
             "shape": {"kind": "box", "min": [0.0, 0.0, edge], "max": [edge, edge, top]}}],
        "obstacles": [{"name": "foot", "contact": "stick", "shape": {
            "kind": "box", "min": [-edge, -edge, -deep], "max": [2.0 * edge, 2.0 * edge, 0.0]}}],
        "forces": [{"kind": "traction", "name": "load", "body": "head",
                    "within": {"min": [0.0, 0.0, top], "max": [edge, edge, top]},
                    "value": [f"{direction[1]:.9g}*{load}", 0.0, f"{-direction[0]:.9g}*{load}"]}]})  # fmt: skip


def made(folder, seed, side=SIDE, fraction=FRACTION):
    """File in `folder` of the made sample of a seed."""
    file = folder / f"snow_{seed}.npz"
    np.savez_compressed(file, phase=random_microstructure((side,) * 3, fraction, CORRELATION, seed=seed))
    return file


def broken(path, image, rate=RATE, end=END, side=SIDE, readings=READINGS, **options):
    """`Peak` of a test, which ends once the load on the foot has fallen."""
    scene = scene_of(path, image, rate=rate, end=end, side=side, **options)
    simulation, direction = Simulation(scene), np.array(PATHS[path]) / np.hypot(*PATHS[path])
    section = (side * VOXEL) ** 2
    heads = np.asarray(simulation.particles["position"])[:, 2] > side * VOXEL
    start = np.asarray(simulation.particles["position"], float)[heads].mean(axis=0)
    rows, borne = [], []
    for on_foot in loads(simulation, 0, end * np.linspace(0.0, 1.0, readings + 1)[1:]):
        stress = np.array([-on_foot[2], on_foot[0]]) / section
        time = simulation.time
        moved = np.asarray(simulation.particles["position"], float)[heads].mean(axis=0) - start
        rows.append((*stress, rate * time**2 / (time + SOFT_START), time, *(moved[[2, 0]] / (side * VOXEL))))
        borne.append(stress @ direction)
        if time > 2.0 * SOFT_START and borne[-1] < (1.0 - DROP) * max(borne):
            break
    at = int(np.argmax(borne))
    sigma, tau, applied, time, grown, sheared = rows[at]
    return Peak(sigma, tau, applied, time, -grown, sheared, borne[-1] < (1.0 - DROP) * borne[at])
