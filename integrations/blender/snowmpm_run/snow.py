"""The snow of a run in a Blender file: one mesh of points, read anew for each frame, and the objects that draw it."""

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import nodes, stage
from .run_file import RunFile

FOLDER, SPEED = "snowmpm_run", "snowmpm_speed"
"""Custom properties of the mesh: folder of its run, and simulated seconds in a second of film."""

KINDS = {np.dtype(np.float32): "FLOAT", np.dtype(np.int32): "INT"}
_open = {}


def run_of(folder):
    """The `RunFile` of a folder, read once."""
    if folder not in _open:
        _open[folder] = RunFile(folder)
    return _open[folder]


def open_run(folder, *, draw=(nodes.SURFACE, nodes.CLODS), speed=1.0, fps=24.0, with_stage=True):
    """Add a run to the scene; -> the mesh of its points.

    draw       which of nodes.SURFACE, POINTS, CLODS and POWDER; the others are made, and hidden
    speed      simulated seconds in a second of film;  fps: its pictures a second, which the scene takes over
    with_stage ground, obstacles, camera, sun and sky too
    Raises ValueError where the folder holds no run in three dimensions.
    """
    folder = bpy.path.abspath(folder)
    _open.pop(folder, None)
    run = run_of(folder)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
    scene.frame_start, scene.frame_end = 0, max(int(np.ceil(run.times[-1] / speed * fps)), 1)
    collection = bpy.data.collections.new(run.name)
    scene.collection.children.link(collection)
    mesh = bpy.data.meshes.new(f"{run.name} particles")
    mesh[FOLDER], mesh[SPEED] = folder, float(speed)
    look = nodes.snow_material(run.spacing)
    groups = {nodes.SURFACE: nodes.surface_group(run.spacing, look),
              nodes.POINTS: nodes.points_group(run.spacing, look),
              nodes.CLODS: nodes.clods_group(run.spacing, look),
              nodes.POWDER: nodes.powder_group(run.spacing, nodes.powder_material(0.15 / run.spacing))}
    for name, group in groups.items():
        made = bpy.data.objects.new(f"{run.name} {name}", mesh)
        made.modifiers.new(group.name, "NODES").node_group = group
        made.hide_render = made.hide_viewport = name not in draw
        collection.objects.link(made)
    if with_stage:
        stage.add_ground(run, collection)
        stage.add_solids(run, collection, lambda time: time / speed * fps)
        size = (scene.render.resolution_x, scene.render.resolution_y)
        stage.add_light(run, stage.add_camera(run, collection, size), collection)
    refresh(scene)
    listen()
    return mesh


@persistent
def refresh(scene, _=None):
    """Give the points of every run in the file the places that they have at the frame of the scene."""
    rate = scene.render.fps / scene.render.fps_base
    for mesh in bpy.data.meshes:
        if FOLDER in mesh:
            time = (scene.frame_current + scene.frame_subframe) / rate * mesh[SPEED]
            run = run_of(mesh[FOLDER])
            fill(mesh, run.snow(run.frame_at(time), time), mesh[SPEED])


def fill(mesh, snow, speed):
    """Put `Snow` into a mesh; its velocity becomes that of the film, which is what blurs."""
    if len(mesh.vertices) != len(snow.points):
        mesh.clear_geometry()
        mesh.vertices.add(len(snow.points))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(snow.points, np.float32).ravel())
    for name, values in snow.attributes.items():
        kind = "FLOAT_VECTOR" if values.ndim == 2 else KINDS[values.dtype]
        found = mesh.attributes.get(name) or mesh.attributes.new(name, kind, "POINT")
        values = values * np.float32(speed) if name == "velocity" else values
        found.data.foreach_set("vector" if values.ndim == 2 else "value", np.ascontiguousarray(values).ravel())
    mesh.update()


def listen():
    for handlers in (bpy.app.handlers.frame_change_pre, bpy.app.handlers.load_post):
        if refresh not in handlers:
            handlers.append(refresh)


def forget():
    for handlers in (bpy.app.handlers.frame_change_pre, bpy.app.handlers.load_post):
        if refresh in handlers:
            handlers.remove(refresh)
    _open.clear()
