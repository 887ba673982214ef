"""A cube of voxel snow with breaking ice under a load of fixed direction: pull, shear, push and what lies between.

The ice of the library's scene `microstructure`, made samples (`setup.random_microstructure`), periodic sides. The foot
is rough and still. A head of elastic ice has grown on the sample, and a traction on it grows with time in one
direction; the periodic sides keep it from turning. What the foot feels over the section of the cube is the homogenised
stress: sigma, positive in compression, and tau.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene
from snowmpm.setup.random_microstructure import random_microstructure
from tests.support.driven import loads

VOXEL, CORRELATION, SIDE, FRACTION = 5e-5, 3.0, 32, 0.25
"""Edge of a voxel [m], length of the structure and edge of the cube [voxels], share of ice: 229 kg/m3."""
DX = 8e-5
"""Of the grid [m]: that of the library's scene, 1.6 voxels. A periodic side must be a multiple of four cells long."""
RATE = 2e9
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

SEEDS, CHECKED = (1, 3, 4, 5, 6), ("pull", "shear", "push")
"""The first five seeds that give ice connected from bottom to top; paths of the checks."""
VARIANTS = {"half the rate": {"rate": 0.5 * RATE, "end": 2.0 * END}, "larger cube": {"side": 48, "dx": 7.5e-5},
            "finer cells": {"dx": 5e-5}}
"""With the first seed along the paths `CHECKED`; the larger cube, another sample, is not pushed."""


@dataclass(frozen=True)
class Peak:
    """Largest load along the path: sigma, tau [Pa] on the foot; then the load applied on the head [Pa], time [s],
    shortening and shear of the sample [-]; whether the load fell after it."""

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
    edge, thick = round(side * VOXEL, 9), round(2.0 * DX, 9)
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
            "kind": "box", "min": [0.0, 0.0, -deep], "max": [edge, edge, 0.0]}}],
        "forces": [{"kind": "traction", "name": "load", "body": "head",
                    "within": {"min": [0.0, 0.0, top], "max": [edge, edge, top]},
                    "value": [f"{direction[1]:.9g}*{load}", 0.0, f"{-direction[0]:.9g}*{load}"]}]})  # fmt: skip


def made(folder, seed, side=SIDE, mirrored=False):
    """File in `folder` of the made sample of a seed; mirrored: along x, so that it is sheared the other way."""
    file = folder / f"snow_{seed}{'_mirrored' * mirrored}.npz"
    phase = random_microstructure((side,) * 3, FRACTION, CORRELATION, seed=seed)
    np.savez_compressed(file, phase=phase[::-1] if mirrored else phase)
    return file


def broken(path, image, rate=RATE, end=END, side=SIDE, readings=READINGS, **options):
    """`Peak` of a test, which ends once the load on the foot has fallen."""
    scene = scene_of(path, image, rate=rate, end=end, side=side, **options)
    simulation, direction = Simulation(scene), np.array(PATHS[path]) / np.hypot(*PATHS[path])
    edge = side * VOXEL
    start = np.asarray(simulation.particles["position"], float)
    heads = start[:, 2] > edge
    rows, borne = [], []
    for on_foot in loads(simulation, 0, end * np.linspace(0.0, 1.0, readings + 1)[1:]):
        stress = np.array([-on_foot[2], on_foot[0]]) / edge**2
        time = simulation.time
        moved = (np.asarray(simulation.particles["position"], float) - start)[heads]
        moved[:, :2] = (moved[:, :2] + 0.5 * edge) % edge - 0.5 * edge  # periodic
        strains = moved.mean(axis=0)[[2, 0]] / edge
        rows.append((*stress, rate * time**2 / (time + SOFT_START), time, *strains))
        borne.append(stress @ direction)
        if time > 2.0 * SOFT_START and borne[-1] < (1.0 - DROP) * max(borne):
            break
    at = int(np.argmax(borne))
    sigma, tau, applied, time, grown, sheared = rows[at]
    return Peak(sigma, tau, applied, time, -grown, sheared, borne[-1] < (1.0 - DROP) * borne[at])
