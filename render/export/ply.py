"""A run as PLY files, a binary one a frame, with all fields."""

import json

import numpy as np

from snowmpm.draft import draft, write_text
from snowmpm.stages import counted

KINDS = {"f4": "float", "f8": "double", "i4": "int", "u4": "uint", "i2": "short", "u2": "ushort", "i1": "char",
         "u1": "uchar"}
AXES = {3: "xyz", 6: ("xx", "yy", "zz", "xy", "yz", "xz")}


def write(sequence, folder):
    """snow_0000.ply ..., ground.ply, OBSTACLE_0000.ply (once, where it never moves), and sequence.json: times, radii of
    the particles [m], units, origin; -> paths."""
    paths, files, radii = [], [], []
    for k, i in enumerate(counted(sequence.indices, "writing PLY", "frames")):
        files.append(f"snow_{k:04d}.ply")
        snow = sequence.snow(i)
        radii.append(snow.radius)
        paths.append(write_ply(folder / files[-1], snow, f"time {sequence.run.times[i]:.9g} s"))
        for name, shape in sequence.obstacles(i).items():
            if k == 0 or moves(sequence, name):
                suffix = f"_{k:04d}" if moves(sequence, name) else ""
                paths.append(write_ply(folder / f"{name}{suffix}.ply", shape, f"obstacle {name}"))
    ground = sequence.ground()
    if ground is not None:
        paths.append(write_ply(folder / "ground.ply", ground, "ground"))
    record = {"name": sequence.name, "times": sequence.times.tolist(), "files": files, "radii": radii,
              "units": sequence.units, "origin": sequence.origin.tolist(), "crs": sequence.run.provenance.get("crs")}
    write_text(folder / "sequence.json", json.dumps(record, indent=1))
    return [*paths, folder / "sequence.json"]


def moves(sequence, name):
    """Whether an obstacle is ever elsewhere than at the start."""
    one = sequence.run.obstacles[name]
    return bool(np.ptp(one.rotation, axis=0).any() or np.ptp(one.translation, axis=0).any())


def write_ply(path, shape, comment):
    """Write one `Shape` as binary PLY; vectors and tensors as one property a component (velocity_x, stress_xx)."""
    columns = {axis: shape.points[:, k] for k, axis in enumerate("xyz")}
    for name, values in shape.fields.items():
        parts = values[:, None] if values.ndim == 1 else values
        ends = [""] if values.ndim == 1 else [f"_{axis}" for axis in AXES.get(parts.shape[1],
                                                                              range(parts.shape[1]))]
        columns |= {f"{name}{end}": parts[:, k] for k, end in enumerate(ends)}
    columns = {name: _storable(values) for name, values in columns.items()}
    table = np.empty(len(shape.points), [(name, "<" + _code(values)) for name, values in columns.items()])
    for name, values in columns.items():
        table[name] = values
    lines = ["ply", "format binary_little_endian 1.0", f"comment snowmpm: {comment}", f"element vertex {len(table)}"]
    lines += [f"property {KINDS[_code(values)]} {name}" for name, values in columns.items()]
    body = table.tobytes()
    if shape.faces is not None:
        lines += [f"element face {len(shape.faces)}", "property list uchar int vertex_indices"]
        faces = np.empty(len(shape.faces), [("count", "u1"), ("corners", "<i4", 3)])
        faces["count"], faces["corners"] = 3, shape.faces
        body += faces.tobytes()
    with draft(path) as part:
        part.write_bytes("\n".join([*lines, "end_header\n"]).encode("ascii") + body)
    return path


def _code(values):
    return values.dtype.str[1:]


def _storable(values):
    """Values of a type that PLY has, which for whole numbers beyond 32 bits is double: exact to 9e15."""
    if _code(values) in KINDS:
        return values
    if values.dtype.kind not in "iub":
        return values.astype(np.float32)
    held = np.iinfo(np.int32)
    small = not values.size or (values.min() >= held.min and values.max() <= held.max)
    return values.astype(np.int32 if small else np.float64)
