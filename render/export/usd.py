"""A run as one USD file, ready for lighting in Blender, Houdini and Omniverse: snow, ground, obstacles, camera, sun.

https://openusd.org: `UsdGeomPoints` with velocities, widths and ids, or a `UsdGeomMesh` with normals; preview
materials, the camera and the sun of the film. Fields of particles are primvars.
"""

import numpy as np

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.render.export import usd_look
from snowmpm.render.export.usd_parts import Part, identifier
from snowmpm.stages import counted

HELD = 1e-3
"""Share of the time between two samples in which points without numbers jump from one to the other."""


def write(sequence, folder):
    """run.usdc, and pictures of a ground in 3-D and of obstacles with colours; -> paths.

    Raises InputError where the library is missing.
    """
    try:
        from pxr import Usd, UsdGeom
    except ImportError:
        raise InputError("--as usd needs the export extra: pip install 'snowmpm[export]'; ply and gltf need none"
                         ) from None
    path = folder / "run.usdc"
    with draft(path) as part:
        stage = Usd.Stage.CreateNew(str(part))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetTimeCodesPerSecond(sequence.fps)
        stage.SetFramesPerSecond(sequence.fps)
        codes = np.round(sequence.times / sequence.speed * sequence.fps, 6)  # 230, not 230.00000000000003
        stage.SetStartTimeCode(float(codes[0]))
        stage.SetEndTimeCode(float(codes[-1]))
        root = UsdGeom.Xform.Define(stage, "/run")
        stage.SetDefaultPrim(root.GetPrim())
        stage.GetRootLayer().customLayerData = {
            "generator": "snowmpm", "name": sequence.name, "speed": float(sequence.speed),
            "origin": ",".join(f"{value:.9g}" for value in sequence.origin),
            "crs": sequence.run.provenance.get("crs") or ""}
        pictures = _write(stage, sequence, codes, folder)
        stage.GetRootLayer().Save()
        del stage
    return [path, *pictures]


def _write(stage, sequence, codes, folder):
    look = usd_look.Look(stage, sequence)
    look.add_camera(codes)
    look.add_lights()
    pictures, ground = [], sequence.ground()
    if ground is not None:
        part = Part(stage, "/run/ground", ground, turn=sequence.turn)
        part.set(ground, None)
        pictures = look.cover_ground(part.prim, ground, folder)
    for name, (shape, poses) in sequence.solids().items():
        part = Part(stage, f"/run/{identifier(name)}", shape, turn=sequence.turn)
        part.set(shape, None)
        part.move(poses, codes)
        pictures += look.cover(part.prim, shape, identifier(name), folder)
    snow = None
    for k, i in enumerate(counted(sequence.indices, "writing USD", "frames")):
        shape = sequence.snow(i)
        if snow is None:
            snow = Part(stage, "/run/snow", shape, sequence.speed, sequence.units, sequence.turn)
            look.bind(snow.prim, "snow")
        snow.set(shape, codes[k])
        if not sequence.identified and k + 1 < len(codes):
            # Programs go from one sample to the next point by point, and these are other particles: nothing moves
            # until the next sample. An array that is written twice is stored once
            snow.set(shape, codes[k + 1] - HELD * (codes[k + 1] - codes[k]))
    return pictures
