"""A specimen between two smooth plates, one of which is driven, under a pressure all around: a triaxial test as a body.

The pressure is that of a fluid behind a membrane without stiffness: `forces` of a scene, of kind "pressure". Plates
feel what exceeds it: their force over the section is sigma_1 - sigma_3. Without a pressure the compression is
unconfined. In 2-D the test is biaxial: plane strain.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.materials import LoadingStage, MixedControl
from snowmpm.materials.measurement import Driven, Measurement
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.solids.motion import RigidMotion
from tests.support.driven import loads

WIDTH, HEIGHT, CELLS = 0.1, 0.2, 8
"""Of the specimen [m]; cells over its width."""
DAMPING = 20.0
"""[1/s]: of what a plate that starts sets swinging; periods are of hundredths of a second."""


@dataclass
class Loaded:
    """Over the test: shortening -ln(l / l0) [-]; deviator: force over the section less the pressure [Pa]; volume:
    ln of the volume ratio; p, q: means over the specimen [Pa]. fields: particle fields at the end."""

    shortening: np.ndarray
    deviator: np.ndarray
    volume: np.ndarray
    p: np.ndarray
    q: np.ndarray
    fields: object


def scene_of(material, method, dim, pressure, speed, end):
    """Scene of the specimen; speed of the upper plate [m/s]."""
    dx = WIDTH / CELLS if method == "mpm" else 0.5 * WIDTH / CELLS
    margin, thick = 3.0 * WIDTH, 6.0 * dx
    margin, thick, over, top = (round(one, 9) for one in (margin, thick, HEIGHT + 2.0 * thick, HEIGHT + 4.0 * thick))
    beside = [round(WIDTH + margin, 9)] * (dim - 1)
    shape = ({"kind": "box", "min": [0.0, 0.0], "max": [WIDTH, HEIGHT]} if dim == 2 else
             {"kind": "cylinder", "base": [0.5 * WIDTH, 0.5 * WIDTH, 0.0], "axis": [0.0, 0.0, 1.0],
              "radius": 0.5 * WIDTH, "height": HEIGHT})
    tables = {
        "name": "specimen", "dimension": dim, "end_time": end, "gravity": 0.0,
        "solver": {"dx": dx, "method": method},
        "domain": {"min": [*[-margin] * (dim - 1), -thick], "max": [*beside, top]},
        "materials": {"sample": material}, "damping": {"coefficient": DAMPING},
        "bodies": [{"name": "specimen", "material": "sample", "shape": shape}],
        "obstacles": [
            {"name": "foot", "friction": 0.0, "shape": {"kind": "box", "min": [*[-margin] * (dim - 1), -thick],
                                                        "max": [*beside, 0.0]}},
            {"name": "head", "friction": 0.0, "shape": {"kind": "box", "min": [*[-margin] * (dim - 1), HEIGHT],
                                                        "max": [*beside, over]},
             "motion": {"velocity": [*[0.0] * (dim - 1), -speed], "ramp": round(0.1 * end, 9)}}]}
    if pressure:
        tables |= {"forces": [{"kind": "pressure", "value": pressure}],
                   "initial": {"stress": "isotropic", "pressure": pressure}}
    return Scene.model_validate(tables)


def compress(material, method, dim, pressure, strain, speed, samples=40):
    """`Loaded` of a specimen that is shortened by `strain`."""
    end = HEIGHT * (1.0 - np.exp(-strain)) / speed / 0.9
    scene = scene_of(material, method, dim, pressure, speed, end)
    simulation, head = Simulation(scene), RigidMotion.of(scene.obstacles[1].motion, np.zeros(dim))
    section = WIDTH if dim == 2 else 0.25 * np.pi * WIDTH**2
    rows, volume_at_start = [], simulation.particles["volume"].sum()
    for on_head in loads(simulation, 1, end * np.linspace(0.0, 1.0, samples + 1)[1:]):
        way = -head.pose(simulation.time).centre[-1]
        fields = simulation.particles
        volume = fields["volume"].sum() / volume_at_start
        length = 1.0 - way / HEIGHT
        rows.append((-np.log(length), abs(on_head[-1]) / (section * volume / length), np.log(volume),
                     np.average(fields["p"], weights=fields["volume"]),
                     np.average(fields["q"], weights=fields["volume"])))
    return Loaded(*np.array(rows).T, simulation.particles)


def of_point(law, dim, pressure, strain, steps=400):
    """`Measurement` of the same test at a point: lateral stress held; in plane strain in 2-D."""
    held = {"xx": -pressure, "yy": -pressure} if dim == 3 else {"xx": -pressure}
    driven = {"zz": -strain} if dim == 3 else {"zz": -strain, "yy": 0.0}
    control = MixedControl(law, "f64")
    start = control.consolidated(pressure)
    stages = control.follow_stages([LoadingStage(driven, held, steps, 1.0)], start)
    return Measurement("triaxial", law, Driven("strain_zz", -1.0, "axial shortening [-]"), [start, *stages])
