"""Geometry nodes and materials: the points of a run as snow."""

import bpy
import numpy as np

SURFACE, POINTS, CLODS, POWDER = "surface", "points", "clods", "powder"


def material(name, colour, roughness, *, subsurface=0.0, bump=0.0, size=1.0):
    """A principled material; bump: height [m] of a noise of a `size` [m] on it."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    if subsurface:
        # Light goes on in snow for centimetres, red the least far
        shader.inputs["Subsurface Weight"].default_value = subsurface
        shader.inputs["Subsurface Radius"].default_value = (0.5, 0.8, 1.0)
        shader.inputs["Subsurface Scale"].default_value = 0.08
    if bump:
        place, noise, bumps = (nodes.new(kind) for kind in ("ShaderNodeTexCoord", "ShaderNodeTexNoise",
                                                            "ShaderNodeBump"))
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1.0 / size, 6.0
        bumps.inputs["Distance"].default_value = bump
        links.new(place.outputs["Object"], noise.inputs["Vector"])
        links.new(noise.outputs["Fac"], bumps.inputs["Height"])
        links.new(bumps.outputs["Normal"], shader.inputs["Normal"])
    return made



def picture_material(name, picture):
    """A material with the colours of a picture (rows, columns, 3) uint8."""
    made = material(name, (0.5, 0.5, 0.5), 0.7)
    rows, columns = picture.shape[:2]
    image = bpy.data.images.new(name, columns, rows)
    pixels = np.ones((rows, columns, 4), np.float32)
    pixels[..., :3] = picture[::-1] / 255.0
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    nodes, links = made.node_tree.nodes, made.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return made

def snow_material(spacing):
    return material("snow", (0.90, 0.93, 0.97), 0.6, subsurface=0.5, bump=0.15 * spacing, size=1.5 * spacing)


def ground_material(cell):
    """Snow cover with a fine relief, rock where it is steep."""
    made = material("ground", (0.85, 0.88, 0.93), 0.7, subsurface=0.2, bump=0.15 * cell, size=1.5 * cell)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    normal, parts, steep, noise, add, mix = (nodes.new(kind) for kind in (
        "ShaderNodeNewGeometry", "ShaderNodeSeparateXYZ", "ShaderNodeMapRange", "ShaderNodeTexNoise",
        "ShaderNodeMath", "ShaderNodeMix"))
    mix.data_type = "RGBA"
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 0.3 / cell, 8.0
    add.operation = "MULTIPLY_ADD"
    add.inputs[1].default_value = 0.25
    # cos(slope): covered below some 46 degrees, bare from 54 on, shifted by the noise
    steep.inputs["From Min"].default_value, steep.inputs["From Max"].default_value = 0.71, 0.82
    links.new(normal.outputs["Normal"], parts.inputs[0])
    links.new(noise.outputs["Fac"], add.inputs[0])
    links.new(parts.outputs["Z"], add.inputs[2])
    links.new(add.outputs[0], steep.inputs["Value"])
    links.new(steep.outputs[0], mix.inputs["Factor"])
    rock, snow = (socket for socket in mix.inputs if socket.type == "RGBA")
    rock.default_value, snow.default_value = (0.12, 0.11, 0.10, 1.0), (0.85, 0.88, 0.93, 1.0)
    links.new(next(socket for socket in mix.outputs if socket.type == "RGBA"),
              nodes["Principled BSDF"].inputs["Base Color"])
    return made


def powder_material(density):
    """A cloud: scattering [1/m] where its grid is full."""
    made = bpy.data.materials.new("powder")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.remove(nodes["Principled BSDF"])
    shader = nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Color"].default_value = (0.97, 0.98, 1.0, 1.0)
    shader.inputs["Density"].default_value = density
    shader.inputs["Anisotropy"].default_value = 0.3
    links.new(shader.outputs["Volume"], nodes["Material Output"].inputs["Volume"])
    return made


class Group:
    """A node group in the making."""

    def __init__(self, name):
        self.tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        self.tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        self.begin = self.tree.nodes.new("NodeGroupInput").outputs[0]
        self.end = self.tree.nodes.new("NodeGroupOutput").inputs[0]
        self._column = 0

    def wish(self, name, value, least=0.0, most=1e6):
        """A number that the user sets in the modifier; -> its socket."""
        socket = self.tree.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketFloat")
        socket.default_value, socket.min_value, socket.max_value = value, least, most
        node = next(node for node in self.tree.nodes if node.type == "GROUP_INPUT")
        return node.outputs[name]

    def node(self, kind, inputs=None, **settings):
        """A node with settings, and inputs {name or number: value or socket}; -> the node."""
        made = self.tree.nodes.new(kind)
        self._column += 1
        made.location = (200 * self._column, -60 * (self._column % 5))
        for key, value in settings.items():
            setattr(made, key, value)
        for key, value in (inputs or {}).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, made.inputs[key])
            else:
                made.inputs[key].default_value = value
        return made

    def attribute(self, name, kind="FLOAT"):
        made = self.node("GeometryNodeInputNamedAttribute", {"Name": name}, data_type=kind)
        return made.outputs["Attribute"]

    def finish(self, geometry):
        self.tree.links.new(geometry, self.end)
        return self.tree


def points_group(spacing, look):
    """Particles as spheres."""
    group = Group("snowmpm points")
    radius = group.wish("Radius", 0.6 * spacing)
    made = group.node("GeometryNodeMeshToPoints", {"Mesh": group.begin, "Radius": radius})
    dressed = group.node("GeometryNodeSetMaterial", {"Geometry": made.outputs[0], "Material": look})
    return group.finish(dressed.outputs[0])


def surface_group(spacing, look):
    """A closed surface around the particles, rough in the small, with their velocity for motion blur."""
    group = Group("snowmpm surface")
    radius, voxel = group.wish("Radius", 1.1 * spacing), group.wish("Voxel", 0.5 * spacing, 1e-4)
    rough = group.wish("Roughness", 0.25 * spacing)
    points = group.node("GeometryNodeMeshToPoints", {"Mesh": group.begin, "Radius": radius})
    volume = group.node("GeometryNodePointsToVolume", {"Points": points.outputs[0], "Radius": radius,
                                                       "Voxel Size": voxel}, resolution_mode="VOXEL_SIZE")
    mesh = group.node("GeometryNodeVolumeToMesh", {"Volume": volume.outputs[0], "Voxel Size": voxel, "Threshold": 0.1},
                      resolution_mode="VOXEL_SIZE")
    smooth = group.node("GeometryNodeSetShadeSmooth", {"Geometry": mesh.outputs[0]})
    nearest = group.node("GeometryNodeSampleNearest", {"Geometry": points.outputs[0]}, domain="POINT")
    geometry = smooth.outputs[0]
    for name, kind in (("velocity", "FLOAT_VECTOR"), ("speed", "FLOAT"), ("density", "FLOAT"), ("age", "FLOAT")):
        sampled = group.node("GeometryNodeSampleIndex", {
            "Geometry": points.outputs[0], "Value": group.attribute(name, kind), "Index": nearest.outputs[0]},
            data_type=kind, domain="POINT")
        geometry = group.node("GeometryNodeStoreNamedAttribute", {
            "Geometry": geometry, "Name": name, "Value": sampled.outputs[0]}, data_type=kind, domain="POINT").outputs[0]
    noise = group.node("ShaderNodeTexNoise", {"Scale": 0.6 / spacing, "Detail": 5.0})
    centred = group.node("ShaderNodeVectorMath", {0: noise.outputs["Color"], 1: (0.5, 0.5, 0.5)}, operation="SUBTRACT")
    shift = group.node("ShaderNodeVectorMath", {0: centred.outputs[0], "Scale": rough}, operation="SCALE")
    rough = group.node("GeometryNodeSetPosition", {"Geometry": geometry, "Offset": shift.outputs[0]})
    dressed = group.node("GeometryNodeSetMaterial", {"Geometry": rough.outputs[0], "Material": look})
    return group.finish(dressed.outputs[0])


def clods_group(spacing, look):
    """Lumps of several sizes in place of loose particles."""
    group = Group("snowmpm clods")
    most, share = group.wish("Size", 0.9 * spacing), group.wish("Share", 0.8, 0.0, 1.0)
    chance = group.node("FunctionNodeRandomValue", {"Seed": 1}, data_type="FLOAT")
    chosen = group.node("FunctionNodeCompare", {0: next(o for o in chance.outputs if o.enabled), 1: share},
                        data_type="FLOAT", operation="LESS_THAN")
    among = group.node("ShaderNodeMath", {0: chosen.outputs[0], 1: group.attribute("loose")}, operation="MULTIPLY")
    points = group.node("GeometryNodeMeshToPoints", {"Mesh": group.begin, "Selection": among.outputs[0]})
    ball = group.node("GeometryNodeMeshIcoSphere", {"Radius": 1.0, "Subdivisions": 3})
    noise = group.node("ShaderNodeTexNoise", {"Scale": 1.4, "Detail": 4.0})
    centred = group.node("ShaderNodeVectorMath", {0: noise.outputs["Color"], 1: (0.5, 0.5, 0.5)}, operation="SUBTRACT")
    lumpy = group.node("GeometryNodeSetPosition", {"Geometry": ball.outputs[0], "Offset": centred.outputs[0]})
    smooth = group.node("GeometryNodeSetShadeSmooth", {"Geometry": lumpy.outputs[0]})
    size = group.node("FunctionNodeRandomValue", {"Seed": 2}, data_type="FLOAT")
    # Many small ones and few large ones
    curve = group.node("ShaderNodeMath", {0: next(o for o in size.outputs if o.enabled), 1: 3.0}, operation="POWER")
    scaled = group.node("ShaderNodeMath", {0: curve.outputs[0], 1: most, 2: 0.2 * spacing}, operation="MULTIPLY_ADD")
    turned = group.node("FunctionNodeRandomValue", {0: (0.0, 0.0, 0.0), 1: (6.3, 6.3, 6.3), "Seed": 3},
                        data_type="FLOAT_VECTOR")
    placed = group.node("GeometryNodeInstanceOnPoints", {
        "Points": points.outputs[0], "Instance": smooth.outputs[0], "Scale": scaled.outputs[0],
        "Rotation": turned.outputs[0]})
    dressed = group.node("GeometryNodeSetMaterial", {"Geometry": placed.outputs[0], "Material": look})
    return group.finish(dressed.outputs[0])


def powder_group(spacing, look):
    """A cloud around what moves fast. Drawn, not computed: the run holds the dense flow alone."""
    group = Group("snowmpm powder")
    fast, size = group.wish("From speed", 4.0), group.wish("Size", 3.0 * spacing)
    rise = group.wish("Rise", 2.0 * spacing)
    chosen = group.node("FunctionNodeCompare", {0: group.attribute("speed"), 1: fast}, data_type="FLOAT",
                        operation="GREATER_THAN")
    points = group.node("GeometryNodeMeshToPoints", {"Mesh": group.begin, "Selection": chosen.outputs[0],
                                                     "Radius": size})
    up = group.node("FunctionNodeRandomValue", {"Seed": 4}, data_type="FLOAT")
    height = group.node("ShaderNodeMath", {0: next(o for o in up.outputs if o.enabled), 1: rise}, operation="MULTIPLY")
    shift = group.node("ShaderNodeCombineXYZ", {"Z": height.outputs[0]})
    raised = group.node("GeometryNodeSetPosition", {"Geometry": points.outputs[0], "Offset": shift.outputs[0]})
    cloud = group.node("GeometryNodePointsToVolume", {"Points": raised.outputs[0], "Radius": size, "Density": 1.0,
                                                      "Voxel Size": 0.8 * spacing}, resolution_mode="VOXEL_SIZE")
    dressed = group.node("GeometryNodeSetMaterial", {"Geometry": cloud.outputs[0], "Material": look})
    return group.finish(dressed.outputs[0])
