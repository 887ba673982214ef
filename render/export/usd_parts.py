"""Points and triangles of a USD file."""

import numpy as np

from snowmpm.render.snow_surface import vertex_normals

WIDE = ("u4", "i8", "u8")
"""Whole numbers that 32 bits with a sign do not hold."""

FILM_VELOCITY = "velocity"
"""Field that is no primvar: programs call USD's velocities so, which are metres in a second of film."""

RUN_VELOCITY = "run_velocity"
"""The primvar that holds it instead [m/s]."""


def identifier(name):
    """A name as the last part of a path."""
    from pxr import Tf

    return Tf.MakeValidIdentifier(name)


class Part:
    """A prim of points or triangles; turn (3, 3): from its frame to that of the file, None where they are the same."""

    def __init__(self, stage, path, shape, speed=1.0, units=None, turn=None):
        from pxr import UsdGeom

        self._mesh, self._speed, self._units, self._turn = shape.faces is not None, speed, units or {}, turn
        self.prim = (UsdGeom.Mesh if self._mesh else UsdGeom.Points).Define(stage, path)
        self._faces = None
        if self._mesh:
            self.prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
            self.prim.CreateDoubleSidedAttr(True)
            self.prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        if turn is not None:
            self.prim.MakeMatrixXform().Set(_matrix(turn, np.zeros(3)))

    def move(self, poses, codes):
        """Poses (rotation (k, 3, 3), translation (k, 3)) at time codes (k,); None: it stays."""
        if poses is None:
            return
        turn = np.eye(3) if self._turn is None else self._turn
        place = self.prim.MakeMatrixXform()
        for rotation, translation, code in zip(*poses, codes, strict=True):
            place.Set(_matrix(turn @ rotation, turn @ translation), float(code))

    def set(self, shape, code):
        """What it is at a time code; None: always."""
        from pxr import Gf, Usd, UsdGeom, Vt

        code = Usd.TimeCode.Default() if code is None else Usd.TimeCode(float(code))
        points = np.ascontiguousarray(shape.points, np.float32)
        self.prim.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), code)
        if len(points):
            low, high = (end.tolist() for end in (points.min(axis=0) - shape.radius, points.max(axis=0) + shape.radius))
            self.prim.CreateExtentAttr().Set(Vt.Vec3fArray([Gf.Vec3f(*low), Gf.Vec3f(*high)]), code)
        if self._mesh:
            if self._faces is None or not np.array_equal(self._faces, shape.faces):
                counts = np.full(len(shape.faces), 3, np.int32)
                self.prim.CreateFaceVertexCountsAttr().Set(Vt.IntArray.FromNumpy(counts), code)
                faces = np.ascontiguousarray(shape.faces, np.int32).ravel()
                self.prim.CreateFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(faces), code)
                self._faces = shape.faces
            normals = vertex_normals(points, shape.faces)
            self.prim.CreateNormalsAttr().Set(Vt.Vec3fArray.FromNumpy(normals), code)
        else:
            widths = np.full(len(points), 2.0 * shape.radius, np.float32)
            self.prim.CreateWidthsAttr().Set(Vt.FloatArray.FromNumpy(widths), code)
            self.prim.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
            if shape.numbers is not None:
                numbers = np.ascontiguousarray(shape.numbers, np.int64)
                self.prim.CreateIdsAttr().Set(Vt.Int64Array.FromNumpy(numbers), code)
        if shape.velocity is not None:
            blur = np.ascontiguousarray(shape.velocity * self._speed, np.float32)
            self.prim.CreateVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(blur), code)
        for name, values in shape.fields.items():
            self._field(RUN_VELOCITY if name == FILM_VELOCITY else name, values, code, self._units.get(name))

    def _field(self, name, values, code, unit):
        """A field as a primvar, whole numbers as such."""
        from pxr import Sdf, UsdGeom, Vt

        types = Sdf.ValueTypeNames
        kinds = {1: (types.FloatArray, Vt.FloatArray, np.float32), 3: (types.Vector3fArray, Vt.Vec3fArray, np.float32)}
        if values.dtype.kind in "iub":
            kinds = {1: (types.Int64Array, Vt.Int64Array, np.int64) if values.dtype in WIDE
                     else (types.IntArray, Vt.IntArray, np.int32)}
        variables = UsdGeom.PrimvarsAPI(self.prim.GetPrim())
        columns = 1 if values.ndim == 1 else values.shape[1]
        parts = {"": values} if columns in kinds else {f"_{k}": values[:, k] for k in range(columns)}
        for end, part in parts.items():
            kind, array, number = kinds[1 if part.ndim == 1 else part.shape[1]]
            one = variables.CreatePrimvar(name + end, kind, UsdGeom.Tokens.vertex)
            if not one.GetAttr().HasAuthoredMetadata("customData") and unit:
                one.GetAttr().SetCustomDataByKey("units", unit)
            one.Set(array.FromNumpy(np.ascontiguousarray(part, number)), code)


def _matrix(rotation, translation):
    """Of rotation @ x + translation, as USD has it: rows are where the axes go, then the translation."""
    from pxr import Gf

    rows = np.eye(4)
    rows[:3, :3], rows[3, :3] = np.asarray(rotation).T, translation
    return Gf.Matrix4d(*rows.ravel().tolist())
