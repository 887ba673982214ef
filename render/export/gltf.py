"""A run as binary glTF files (.glb), one a frame: snow, ground and obstacles, with all fields of the snow.

https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html. Fields are attributes of the vertices, _VELOCITY and so on,
as the standard has it for what it does not know; a tensor becomes one attribute a component. The standard has no whole
numbers of 32 bits for vertices: they are floats, and from 2^24 on, where floats skip some, two attributes of 16 bits,
_ID_LOW and _ID_HIGH.
"""

import json
import struct

import numpy as np

from snowmpm.draft import draft
from snowmpm.render.export.ply import AXES
from snowmpm.stages import counted

FLOAT, UNSIGNED = 5126, 5125
POINTS, TRIANGLES = 0, 4
VERTICES, INDICES = 34962, 34963
Z_UP = [-float(np.sqrt(0.5)), 0.0, 0.0, float(np.sqrt(0.5))]
"""Quaternion that turns z up into y up."""

EXACT = 1 << 24
"""Whole numbers up to this are exact as floats."""
COLOURS = {"snow": [0.95, 0.97, 1.0, 1.0], "ground": [0.45, 0.42, 0.38, 1.0], "obstacle": [0.35, 0.35, 0.4, 1.0]}


def write(sequence, folder):
    """snow_0000.glb ...; -> paths."""
    ground, paths = sequence.ground(), []
    for k, i in enumerate(counted(sequence.indices, "writing glTF", "frames")):
        scene = _Scene(sequence, i)
        scene.add("snow", sequence.snow(i), "snow")
        if ground is not None:
            scene.add("ground", ground, "ground")
        for name, shape in sequence.obstacles(i).items():
            scene.add(name, shape, "obstacle")
        paths.append(folder / f"snow_{k:04d}.glb")
        with draft(paths[-1]) as part:
            part.write_bytes(scene.bytes())
    return paths


class _Scene:
    """The parts of one file."""

    def __init__(self, sequence, i):
        notes = {"time": float(sequence.run.times[i]), "units": sequence.units, "origin": sequence.origin.tolist()}
        self._json = {"asset": {"version": "2.0", "generator": "snowmpm", "extras": notes}, "scene": 0,
                      "scenes": [{"nodes": [0]}], "nodes": [{"name": sequence.name, "rotation": Z_UP, "children": []}],
                      "meshes": [], "accessors": [], "bufferViews": [], "buffers": [],
                      "materials": [{"name": name, "doubleSided": True, "pbrMetallicRoughness": {
                          "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.9}}
                          for name, colour in COLOURS.items()]}
        self._parts, self._size = [], 0

    def add(self, name, shape, material):
        """A `Shape` as a node of its own; one without points is left out, as the standard demands."""
        if not len(shape.points) or (shape.faces is not None and not len(shape.faces)):
            return
        attributes = {"POSITION": self._accessor(shape.points, VERTICES, bounds=True)}
        for field, values in shape.fields.items():
            for end, part in _attributes(values):
                attributes[f"_{field.upper()}{end}"] = self._accessor(part, VERTICES)
        primitive = {"attributes": attributes, "mode": POINTS, "material": list(COLOURS).index(material)}
        if shape.faces is not None:
            primitive |= {"mode": TRIANGLES, "indices": self._accessor(shape.faces.ravel(), INDICES)}
        self._json["meshes"].append({"name": name, "primitives": [primitive]})
        self._json["nodes"].append({"name": name, "mesh": len(self._json["meshes"]) - 1})
        self._json["nodes"][0]["children"].append(len(self._json["nodes"]) - 1)

    def _accessor(self, values, target, bounds=False):
        index = target == INDICES
        values = np.ascontiguousarray(values, "<u4" if index else "<f4")
        columns = 1 if values.ndim == 1 else values.shape[1]
        data = values.tobytes()
        self._json["bufferViews"].append({"buffer": 0, "byteOffset": self._size, "byteLength": len(data),
                                          "target": target})
        accessor = {"bufferView": len(self._json["bufferViews"]) - 1, "componentType": UNSIGNED if index else FLOAT,
                    "count": len(values), "type": "SCALAR" if columns == 1 else f"VEC{columns}"}
        if bounds:
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        self._json["accessors"].append(accessor)
        self._parts.append(data)
        self._size += len(data)
        return len(self._json["accessors"]) - 1

    def bytes(self):
        """The file."""
        self._json["buffers"] = [{"byteLength": self._size}]
        text = json.dumps(self._json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = b"".join(self._parts)
        return b"".join([struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(body)),
                         struct.pack("<I4s", len(text), b"JSON"), text,
                         struct.pack("<I4s", len(body), b"BIN\0"), body])


def _attributes(values):
    """(end of the name, (n,) or (n, 2 to 4)) of a field."""
    if values.dtype.kind in "iu" and values.ndim == 1 and values.max(initial=0) > EXACT:
        return [("_LOW", values & 0xFFFF), ("_HIGH", values >> 16)]
    if values.ndim == 1 or values.shape[1] <= 4:
        return [("", values)]
    return [(f"_{axis}".upper(), values[:, k]) for k, axis in enumerate(AXES[values.shape[1]])]
