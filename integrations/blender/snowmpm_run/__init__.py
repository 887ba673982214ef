"""Opens run folders of snowmpm in Blender: File > Import > snowmpm run."""

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import nodes, snow

DRAWN = [
    (nodes.SURFACE, "Surface", "A closed surface around the snow"),
    (nodes.POINTS, "Points", "Every particle as a sphere"),
    (nodes.CLODS, "Clods", "Lumps in place of loose particles"),
    (nodes.POWDER, "Powder", "A cloud around what moves fast: drawn, not computed"),
]


class ImportRun(bpy.types.Operator, ImportHelper):
    """Open a run of snowmpm: its snow in every frame, ground, obstacles, camera and light"""

    bl_idname = "import_scene.snowmpm"
    bl_label = "snowmpm run"
    bl_options = {"UNDO"}  # noqa: RUF012, of Blender

    filename_ext = ".vtkhdf"
    filter_glob: StringProperty(default="*.vtkhdf", options={"HIDDEN"})
    draw_as: EnumProperty(name="Draw", items=DRAWN, options={"ENUM_FLAG"}, default={nodes.SURFACE, nodes.CLODS})
    speed: FloatProperty(name="Speed", description="Simulated seconds in a second of film", default=1.0, min=1e-3)
    fps: FloatProperty(name="Frames a second", default=24.0, min=1.0, max=240.0)

    def execute(self, _context):
        try:
            snow.open_run(self.filepath, draw=self.draw_as, speed=self.speed, fps=self.fps)
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def entry(menu, _context):
    menu.layout.operator(ImportRun.bl_idname, text="snowmpm run (run.vtkhdf)")


def register():
    bpy.utils.register_class(ImportRun)
    bpy.types.TOPBAR_MT_file_import.append(entry)
    snow.listen()


def unregister():
    snow.forget()
    bpy.types.TOPBAR_MT_file_import.remove(entry)
    bpy.utils.unregister_class(ImportRun)
