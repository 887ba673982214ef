"""The scenes that hostile input is put into, and the files that they name."""

import shutil
from pathlib import Path

from tests.support.slope_scene import SQUARE, raster_text, slope_scene

BLOCK = """
name = "block"
dimension = 2
end_time = 0.02
[output]
interval = 0.01
[solver]
dx = 0.1
[domain]
min = [0.0, 0.0]
max = [1.0, 1.0]
boundary = "slip"
[materials.snow]
kind = "elastic"
density = 300.0
youngs_modulus = 1e5
poisson_ratio = 0.2
[[bodies]]
name = "snow"
material = "snow"
shape = { kind = "box", min = [0.2, 0.0], max = [0.6, 0.4] }
"""

GRID = raster_text([[5.0 - 0.4 * i for i in range(12)]] * 12)


def block(folder, more="", **changed):
    """scene.toml of a box of snow, with lines more, and pieces of its text changed {old: new}."""
    text = BLOCK
    for old, new in changed.pop("pieces", {}).items():
        assert old in text
        text = text.replace(old, new, 1)
    return written(folder / "scene.toml", text + more)


def on_terrain(folder, file, kind, region=SQUARE):
    """scene.toml of a layer on the terrain in a file."""
    return written(folder / "scene.toml", slope_scene(file, kind, region))


def on_region(folder, file):
    """scene.toml of a layer in the polygons of a file, on a raster."""
    written(folder / "grid.asc", GRID)
    return on_terrain(folder, "grid.asc", "dem", f'{{ file = "{file}" }}')


def of_voxels(folder, file, dim=3):
    """scene.toml of a body from an image."""
    box = {2: "min = [0, 0]\nmax = [8, 8]", 3: "min = [0, 0, 0]\nmax = [8, 8, 8]"}[dim]
    text = BLOCK.split("[domain]")[0].replace("dimension = 2", f"dimension = {dim}").replace("dx = 0.1", "dx = 0.5")
    materials = "[materials" + BLOCK.split("[materials")[1].split("shape")[0]
    shape = f'shape = {{ kind = "voxels", file = "{file}", voxel_size = 0.5, phase = 1 }}\n'
    return written(folder / "scene.toml", f"{text}[domain]\n{box}\n{materials}{shape}")


def written(path, content):
    """The path of a file that now holds this: bytes, text, or what a function makes, where it is large."""
    content = content() if callable(content) else content
    Path(path).write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def copied(folder, source):
    """The copy of a file or a folder in another."""
    target = Path(folder) / Path(source).name
    return Path(shutil.copytree(source, target) if Path(source).is_dir() else shutil.copy(source, target))
