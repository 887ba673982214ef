"""A run as one USD file: particles or surface, obstacles and ground over time, for Blender, Houdini, Omniverse.

https://openusd.org: `UsdGeomPoints` with velocities, widths and ids, `UsdGeomMesh` for the rest; every field is a
primvar.
"""

import numpy as np

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.stages import counted

HELD = 1e-3
"""Share of the time between two samples in which points without numbers jump from one to the other."""
WIDE = ("u4", "i8", "u8")
"""Whole numbers that 32 bits with a sign do not hold."""
COLOURS = {"snow": (0.95, 0.97, 1.0), "ground": (0.45, 0.42, 0.38), "obstacle": (0.35, 0.35, 0.4)}


def write(sequence, folder):
    """run.usdc; -> [path]. InputError where the library is missing."""
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
        times = sequence.times / sequence.speed * sequence.fps
        stage.SetStartTimeCode(float(times[0]))
        stage.SetEndTimeCode(float(times[-1]))
        root = UsdGeom.Xform.Define(stage, "/run")
        stage.SetDefaultPrim(root.GetPrim())
        stage.GetRootLayer().customLayerData = {
            "generator": "snowmpm", "name": sequence.name, "speed": float(sequence.speed),
            "origin": ",".join(f"{value:.9g}" for value in sequence.origin),
            "crs": sequence.run.provenance.get("crs") or ""}
        _write(stage, sequence, times)
        stage.GetRootLayer().Save()
        del stage
    return [path]


def _write(stage, sequence, times):
    ground = sequence.ground()
    if ground is not None:
        _Part(stage, "/run/ground", ground, "ground").set(ground, None)
    snow, obstacles = None, {}
    for k, i in enumerate(counted(sequence.indices, "writing USD", "frames")):
        shape = sequence.snow(i)
        snow = snow or _Part(stage, "/run/snow", shape, "snow", sequence.speed, sequence.units)
        snow.set(shape, times[k])
        if not sequence.identified and k + 1 < len(times):
            # Programs go from one sample to the next point by point, and these are other particles: nothing moves
            # until the next sample. An array that is written twice is stored once
            snow.set(shape, times[k + 1] - HELD * (times[k + 1] - times[k]))
        for name, one in sequence.obstacles(i).items():
            if name not in obstacles:
                obstacles[name] = _Part(stage, f"/run/{_identifier(name)}", one, "obstacle")
            obstacles[name].set(one, times[k])


def _identifier(name):
    from pxr import Tf

    return Tf.MakeValidIdentifier(name)


class _Part:
    """A prim of points or triangles."""

    def __init__(self, stage, path, shape, kind, speed=1.0, units=None):
        from pxr import Gf, UsdGeom

        self._mesh, self._speed, self._units = shape.faces is not None, speed, units or {}
        self._prim = (UsdGeom.Mesh if self._mesh else UsdGeom.Points).Define(stage, path)
        self._prim.CreateDisplayColorAttr([Gf.Vec3f(*COLOURS[kind])])
        self._faces = None
        if self._mesh:
            self._prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
            self._prim.CreateDoubleSidedAttr(True)

    def set(self, shape, time):
        """What it is at a time code; None: always."""
        from pxr import Gf, Usd, UsdGeom, Vt

        time = Usd.TimeCode.Default() if time is None else Usd.TimeCode(float(time))
        points = np.ascontiguousarray(shape.points, np.float32)
        self._prim.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), time)
        if len(points):
            low, high = (end.tolist() for end in (points.min(axis=0) - shape.radius, points.max(axis=0) + shape.radius))
            self._prim.CreateExtentAttr().Set(Vt.Vec3fArray([Gf.Vec3f(*low), Gf.Vec3f(*high)]), time)
        if self._mesh:
            if self._faces is None or not np.array_equal(self._faces, shape.faces):
                counts = np.full(len(shape.faces), 3, np.int32)
                self._prim.CreateFaceVertexCountsAttr().Set(Vt.IntArray.FromNumpy(counts), time)
                faces = np.ascontiguousarray(shape.faces, np.int32).ravel()
                self._prim.CreateFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(faces), time)
                self._faces = shape.faces
        else:
            widths = np.full(len(points), 2.0 * shape.radius, np.float32)
            self._prim.CreateWidthsAttr().Set(Vt.FloatArray.FromNumpy(widths), time)
            self._prim.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
            if shape.numbers is not None:
                numbers = np.ascontiguousarray(shape.numbers, np.int64)
                self._prim.CreateIdsAttr().Set(Vt.Int64Array.FromNumpy(numbers), time)
        for name, values in shape.fields.items():
            self._field(name, values, time)

    def _field(self, name, values, time):
        """A field as a primvar, whole numbers as such. Velocity is what USD has an attribute for, too."""
        from pxr import Sdf, UsdGeom, Vt

        types = Sdf.ValueTypeNames
        kinds = {1: (types.FloatArray, Vt.FloatArray, np.float32), 3: (types.Vector3fArray, Vt.Vec3fArray, np.float32)}
        if values.dtype.kind in "iub":
            kinds = {1: (types.Int64Array, Vt.Int64Array, np.int64) if values.dtype in WIDE
                     else (types.IntArray, Vt.IntArray, np.int32)}
        variables = UsdGeom.PrimvarsAPI(self._prim.GetPrim())
        columns = 1 if values.ndim == 1 else values.shape[1]
        if name == "velocity" and columns == 3:  # in metres a second of film: what blurs moving things
            blur = np.ascontiguousarray(values * self._speed, np.float32)
            self._prim.CreateVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(blur), time)
        parts = {"": values} if columns in kinds else {f"_{k}": values[:, k] for k in range(columns)}
        for end, part in parts.items():
            kind, array, number = kinds[1 if part.ndim == 1 else part.shape[1]]
            one = variables.CreatePrimvar(name + end, kind, UsdGeom.Tokens.vertex)
            if not one.GetAttr().HasAuthoredMetadata("customData") and self._units.get(name):
                one.GetAttr().SetCustomDataByKey("units", self._units[name])
            one.Set(array.FromNumpy(np.ascontiguousarray(part, number)), time)
