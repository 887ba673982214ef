"""Ground, obstacles, camera, sun and sky around the snow of a run."""

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import nodes

SUN, SKY = 4.0, 0.45
"""Strength of the sun [W/m2] and of the sky."""

FIELD_OF_VIEW = 0.7
"""Of the camera, along the longer side [rad]."""


def mesh_object(name, vertices, facets, material, collection, smooth):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, float).tolist(), [], np.asarray(facets).tolist())
    if smooth:
        mesh.shade_smooth()
    mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    collection.objects.link(made)
    return made


def add_ground(run, collection):
    if run.ground is None:
        return None
    vertices, facets = run.ground
    cell = float(np.sqrt(np.prod(np.ptp(vertices[:, :2], axis=0)) / max(len(vertices), 1)))
    return mesh_object("ground", vertices, facets, nodes.ground_material(cell), collection, True)


def add_solids(run, collection, frame_of):
    """Obstacles; those that move have a key in each frame of the run. frame_of(time [s]): the frame of the film."""
    look = nodes.material("obstacle", (0.23, 0.20, 0.17), 0.7)
    for name, solid in run.solids.items():
        made = [mesh_object(name, solid.vertices, solid.facets, look, collection, False)] if not solid.skins else []
        for number, (vertices, facets, st, picture) in enumerate(solid.skins):
            part = f"{name}_{number}"
            made.append(mesh_object(part, vertices, facets, nodes.picture_material(part, picture), collection, False))
            made[-1].data.uv_layers.new(name="st").data.foreach_set("uv", st[facets.ravel()].astype(np.float32).ravel())
        for one in made if solid.moves else ():
            one.rotation_mode = "QUATERNION"
            for time, rotation, translation in zip(run.times, solid.rotation, solid.translation, strict=False):
                one.matrix_world = Matrix.Translation(Vector(translation)) @ Matrix(rotation.tolist()).to_4x4()
                for path in ("location", "rotation_quaternion"):
                    one.keyframe_insert(path, frame=frame_of(float(time)))


def add_camera(run, collection, size):
    """Obliquely from before the flow, so that all of what moves just fills the picture; -> the camera."""
    points = run.action()
    low, high = np.quantile(points, [0.002, 0.998], axis=0)
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    way = downhill(points)
    bearing = np.arctan2(way[0], way[1]) + np.radians(52.0)
    elevation = np.radians(16.0)
    out = np.array([np.sin(bearing) * np.cos(elevation), np.cos(bearing) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.cos(bearing), np.sin(bearing), 0.0])
    axes = np.stack([right, np.cross(out, right), out])
    local = (points - points.mean(axis=0)) @ axes.T
    middle = points.mean(axis=0) + 0.5 * (local.min(axis=0) + local.max(axis=0)) @ axes
    half = np.tan(0.5 * FIELD_OF_VIEW) * np.minimum(np.array(size) / max(size), 1.0)
    extent = 0.5 * np.ptp(local, axis=0)
    distance = 1.15 * float(np.max(extent[:2] / half)) + extent[2]
    data = bpy.data.cameras.new("camera")
    data.angle, data.clip_start, data.clip_end = FIELD_OF_VIEW, 0.01 * distance, 100.0 * distance
    data.dof.focus_distance = distance
    camera = bpy.data.objects.new("camera", data)
    camera.matrix_world = Matrix(np.block([[axes.T, (middle + distance * out)[:, None]],
                                           [np.zeros((1, 3)), np.ones((1, 1))]]).tolist())
    collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return camera


def downhill(points):
    """Unit vector (2,) in plan along which places (n, 3) lie lower."""
    plan = np.column_stack([points[:, :2] - points[:, :2].mean(axis=0), np.ones(len(points))])
    way = -np.linalg.lstsq(plan, points[:, 2], rcond=None)[0][:2]
    return way / max(float(np.linalg.norm(way)), 1e-9)


def add_light(run, camera, collection):
    """The sun from that side of the camera that lights the slope better, 24 degrees up, and a sky that is brighter at
    the horizon; below it, haze, into which the edge of the terrain fades."""
    towards, way = np.array(camera.matrix_world.col[2][:2]), downhill(run.action())
    height = np.radians(24.0)
    choices = [np.arctan2(towards[0], towards[1]) + np.radians(side) for side in (100.0, -100.0)]
    angle = max(choices, key=lambda one: float(way @ [np.sin(one), np.cos(one)]))
    sun = Vector((np.sin(angle) * np.cos(height), np.cos(angle) * np.cos(height), np.sin(height)))
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.angle, data.color = SUN, np.radians(0.53), (1.0, 0.94, 0.84)
    made = bpy.data.objects.new("sun", data)
    made.rotation_mode = "QUATERNION"
    made.rotation_quaternion = sun.to_track_quat("Z", "Y")
    collection.objects.link(made)
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    tree, links = world.node_tree.nodes, world.node_tree.links
    place, parts, ramp = (tree.new(kind) for kind in ("ShaderNodeTexCoord", "ShaderNodeSeparateXYZ",
                                                      "ShaderNodeValToRGB"))
    links.new(place.outputs["Generated"], parts.inputs[0])
    links.new(parts.outputs["Z"], ramp.inputs["Fac"])
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.80, 0.86, 0.93, 1), (0.12, 0.27, 0.55, 1)
    ramp.color_ramp.elements[1].position = 0.6
    background = tree["Background"]
    background.inputs["Strength"].default_value = SKY
    links.new(ramp.outputs["Color"], background.inputs["Color"])
    bpy.context.scene.world = world
