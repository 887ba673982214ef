"""What a lighting artist expects of a USD file besides shapes: materials, the camera and the sun of the film."""

import io

import numpy as np
from PIL import Image

from snowmpm.draft import draft
from snowmpm.render import light
from snowmpm.render.ground import plan_colours
from snowmpm.render.run_film import nearest_frame
from snowmpm.render.section_view import SectionView

MATERIALS = {"snow": ((0.90, 0.93, 0.97), 0.75), "ground": ((0.30, 0.28, 0.26), 0.95),
             "obstacle": ((0.15, 0.21, 0.37), 0.6)}
"""Colour in linear light, and roughness."""

APERTURE = 0.36
"""Longer side of the film behind the lens, 36 mm, in tenths of a metre as USD has it."""

SHUTTER = (-0.25, 0.25)
"""Open and closed, in pictures about the time of one: half of the time, as film cameras have it."""

PICTURE = 1024
"""Pixels of the picture of the ground, along its longer side at most."""

SUN, SKY = 1.0, 0.35
"""Strength of the sun [W/m2] and of the sky, for a white that is just not blown out in the usual views of programs."""

DISC = 0.53
"""Diameter of the sun [deg]."""

SECTION_SUN = np.array([-0.45, -0.6, 0.66])
"""Towards the sun of a section, which is seen along +y."""

NEAREST, FARTHEST = 1e-3, 100.0
"""Nearest and farthest that a camera sees, in extents of what happens."""


class Look:
    """Materials, lights and camera on a stage."""

    def __init__(self, stage, sequence):
        self._stage, self._sequence, self._known = stage, sequence, {}

    def bind(self, prim, name, picture=None):
        """Give a prim one of MATERIALS, by another name that of an obstacle; picture: file of its colours over the
        primvar st."""
        from pxr import Gf, Vt

        colour, _ = MATERIALS.get(name, MATERIALS["obstacle"])
        prim.CreateDisplayColorAttr(Vt.Vec3fArray([Gf.Vec3f(*colour)]))
        self._bind(prim, self._material(name, picture))

    def _bind(self, prim, material):
        from pxr import UsdShade

        UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)

    def _material(self, name, picture):
        from pxr import Gf, Sdf, UsdShade

        if name in self._known:
            return self._known[name]
        types, (colour, roughness) = Sdf.ValueTypeNames, MATERIALS.get(name, MATERIALS["obstacle"])
        path = f"/run/materials/{name}"
        material = UsdShade.Material.Define(self._stage, path)
        surface = UsdShade.Shader.Define(self._stage, f"{path}/surface")
        surface.CreateIdAttr("UsdPreviewSurface")
        surface.CreateInput("roughness", types.Float).Set(roughness)
        surface.CreateInput("metallic", types.Float).Set(0.0)
        diffuse = surface.CreateInput("diffuseColor", types.Color3f)
        diffuse.Set(Gf.Vec3f(*colour))
        if picture is not None:
            reader = UsdShade.Shader.Define(self._stage, f"{path}/place")
            reader.CreateIdAttr("UsdPrimvarReader_float2")
            reader.CreateInput("varname", types.String).Set("st")
            reader.CreateOutput("result", types.Float2)
            image = UsdShade.Shader.Define(self._stage, f"{path}/picture")
            image.CreateIdAttr("UsdUVTexture")
            image.CreateInput("file", types.Asset).Set(f"./{picture}")
            image.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
            for side in ("wrapS", "wrapT"):
                image.CreateInput(side, types.Token).Set("clamp" if name == "ground" else "repeat")
            image.CreateInput("st", types.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
            image.CreateOutput("rgb", types.Float3)
            diffuse.ConnectToSource(image.ConnectableAPI(), "rgb")
        material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
        self._known[name] = material
        return material

    def cover_ground(self, prim, shape, folder):
        """The colours of the film's ground, as they are before the flow, in ground.png, laid over it; -> paths."""
        view = self._sequence.view
        relief = None if self._sequence.run.dimension == 2 else view.whole_relief()
        if relief is None:
            self.bind(prim, "ground")
            return []
        colours, low, high = plan_colours(relief, view.cover, PICTURE)
        path = folder / "ground.png"
        _save(light.encode(colours)[::-1], path)
        places = self._sequence.upright(shape.points)[:, :2]
        st = ((places - low) / (high - low)).astype(np.float32)
        _lay(prim, st)
        self.bind(prim, "ground", path.name)
        return [path]

    def cover(self, prim, shape, name, folder):
        """The material of an obstacle's `Shape`, with its picture NAME.png where it has one; -> paths."""
        if shape.picture is None:
            self.bind(prim, "obstacle")
            return []
        path = folder / f"{name}.png"
        _save(shape.picture, path)
        _lay(prim, shape.st.astype(np.float32))
        self.bind(prim, name, path.name)
        return [path]

    def add_lights(self):
        """The sun where the film has it, and an even sky."""
        from pxr import Gf, UsdLux

        sun = UsdLux.DistantLight.Define(self._stage, "/run/sun")
        sun.CreateIntensityAttr(SUN)
        sun.CreateAngleAttr(DISC)
        sun.CreateColorAttr(Gf.Vec3f(*(light.SUN / light.SUN.max()).tolist()))
        out = SECTION_SUN if isinstance(self._sequence.view, SectionView) else self._sequence.view.sun
        right = np.cross([0.0, 1.0, 0.0] if abs(out[1]) < 0.9 else [1.0, 0.0, 0.0], out)
        right /= np.linalg.norm(right)
        sun.MakeMatrixXform().Set(_placed(np.stack([right, np.cross(out, right), out]), np.zeros(3)))
        sky = UsdLux.DomeLight.Define(self._stage, "/run/sky")
        sky.CreateIntensityAttr(SKY)
        sky.CreateColorAttr(Gf.Vec3f(*(light.SKY / light.SKY.max()).tolist()))

    def add_camera(self, codes):
        """The camera of the film; where it moves, at each of its pictures."""
        from pxr import Gf, Usd, UsdGeom

        view, speed = self._sequence.view, self._sequence.speed / self._sequence.fps
        camera = UsdGeom.Camera.Define(self._stage, "/run/camera")
        camera.CreateShutterOpenAttr(SHUTTER[0])
        camera.CreateShutterCloseAttr(SHUTTER[1])
        camera.CreateFStopAttr(0.0)
        place = camera.MakeMatrixXform()
        if not moves(view):
            codes = codes[:1]
        low, high = corners(view)
        reach = float(np.linalg.norm(high - low))
        for code in np.append(np.arange(codes[0], codes[-1]), codes[-1]):
            seen = camera_at(view, code * speed)
            code = Usd.TimeCode(float(code)) if len(codes) > 1 else Usd.TimeCode.Default()
            width, height = seen.size
            longer = max(width, height)
            right, up, forward = seen.axes
            # Without perspective it may stand anywhere along its view: where all that there is lies before it
            eye = seen.eye if seen.perspective else seen.eye - reach * forward
            place.Set(_placed(np.stack([right, up, -forward]), eye), code)
            apart = float(np.median((np.array([low, high, 0.5 * (low + high)]) - eye) @ forward))
            if seen.perspective:
                camera.CreateHorizontalApertureAttr().Set(APERTURE * width / longer, code)
                camera.CreateVerticalApertureAttr().Set(APERTURE * height / longer, code)
                camera.CreateFocalLengthAttr().Set(APERTURE * seen.scale / longer, code)
            else:
                # In tenths of the unit of the scene, as USD has it
                camera.CreateProjectionAttr(UsdGeom.Tokens.orthographic)
                camera.CreateHorizontalApertureAttr().Set(10.0 * width / seen.scale, code)
                camera.CreateVerticalApertureAttr().Set(10.0 * height / seen.scale, code)
            camera.CreateFocusDistanceAttr().Set(max(apart, NEAREST * reach), code)
        camera.CreateClippingRangeAttr(Gf.Vec2f(NEAREST * reach, FARTHEST * reach))


def _save(colours, path):
    data = io.BytesIO()
    Image.fromarray(colours).save(data, "PNG")
    with draft(path) as part:
        part.write_bytes(data.getvalue())


def _lay(prim, st):
    """Places (n, 2) of vertices on a picture."""
    from pxr import Sdf, UsdGeom, Vt

    variable = UsdGeom.PrimvarsAPI(prim.GetPrim()).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray,
                                                                 UsdGeom.Tokens.vertex)
    variable.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(st)))


def moves(view):
    """Whether the camera of a film does."""
    return view.track.close if isinstance(view, SectionView) else view.path is not None


def camera_at(view, time):
    """`Camera` of a film at a time [s] of the run."""
    if isinstance(view, SectionView):
        return view.track.camera(nearest_frame(view.run, time))
    return view.camera if view.path is None else view.path.camera(time, view.size)


def corners(view):
    """(lower, upper) corner (3,) [m] of what happens in a film."""
    if isinstance(view, SectionView):
        (x, z), (far, top) = view.track.low, view.track.high
        return np.array([x, 0.0, z]), np.array([far, 0.0, top])
    return view.action.points.min(axis=0).astype(float), view.action.points.max(axis=0).astype(float)


def _placed(axes, place):
    """Transform of a thing whose axes x, y, z are rows (3, 3), at a place (3,)."""
    from pxr import Gf

    rows = np.eye(4)
    rows[:3, :3], rows[3, :3] = axes, place
    return Gf.Matrix4d(*rows.ravel().tolist())
