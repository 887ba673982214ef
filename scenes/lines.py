"""Lines and areas of files in place of those of a scene: crests of dams, the profile of a slope, buildings.

Lines are read when the scene is, and written out in its resolved form with the name of their file. Results of a run
then need no other file.
"""

from typing import Any

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.registry import resolved
from snowmpm.scenes.space import base_dir
from snowmpm.scenes.spec import refuse

COUNTER = "snowmpm.seeding.region_files:count_of_areas"
"""(file, its key) -> how many areas it holds."""

READER = "snowmpm.seeding.region_files:lines_on_raster"
"""(file, its key, the terrain's raster or None) -> lines (n, 2) in the coordinates of the raster [m]."""


def with_lines_of_files(data: Any) -> Any:
    """Tables of a scene with the lines of the files that it names; the data given stays as it is. Raises
    PydanticCustomError for a file that holds none."""
    if isinstance(data, dict) and base_dir() is not None and isinstance(data.get("obstacles"), list | tuple):
        data = {**data, "obstacles": [one for i, obstacle in enumerate(data["obstacles"])
                                      for one in _of_each_area(obstacle, f"obstacles.{i}.shape.file")]}
    terrain = data.get("terrain") if isinstance(data, dict) else None
    if not isinstance(terrain, dict) or base_dir() is None:
        return data
    if terrain.get("kind") == "profile" and _names_file(terrain):
        return {**data, "terrain": _with_points(terrain)}
    dams = terrain.get("dams")
    if isinstance(dams, list | tuple) and any(map(_names_file, dams)):
        found = [one for i, dam in enumerate(dams) for one in _with_line(terrain, dam, f"terrain.dams.{i}")]
        return {**data, "terrain": {**terrain, "dams": found}}
    return data


def _of_each_area(obstacle, key):
    """An obstacle for each area of the file of a footprint."""
    shape = obstacle.get("shape") if isinstance(obstacle, dict) else None
    if not _names_file(shape) or shape.get("kind") != "footprint" or "part" in shape:
        return [obstacle]
    try:
        count = resolved(COUNTER)(existing(shape["file"], base_dir(), key), key)
    except InputError as error:
        raise refuse(str(error), key, shape["file"]) from None
    if count < 2:
        return [obstacle]
    return [{**obstacle, "name": f"{obstacle.get('name')}_{n}", "shape": {**shape, "part": n}}
            for n in range(1, count + 1)]


def _names_file(table):
    return isinstance(table, dict) and isinstance(table.get("file"), str)


def _with_points(terrain):
    from snowmpm.reading.number_table import read_number_table

    if "points" in terrain:
        raise refuse("does not go with points, which it gives", "terrain.file", terrain["file"])
    try:
        columns, _ = read_number_table(existing(terrain["file"], base_dir(), "terrain.file"), {"x": "m", "z": "m"})
        if set(columns) != {"x", "z"}:
            raise InputError(f"{terrain['file']}: needs columns x and z")
    except InputError as error:
        raise refuse(str(error), "terrain.file", terrain["file"]) from None
    points = [[float(x), float(z)] for x, z in zip(columns["x"], columns["z"], strict=True)]
    rest = {key: value for key, value in terrain.items() if key != "file"}
    return {**rest, "points": points, "points_source": terrain["file"]}


def _with_line(terrain, dam, key):
    """A dam for each line of its file."""
    if not _names_file(dam):
        return [dam]
    if "line" in dam:
        raise refuse("does not go with line, which it gives", f"{key}.file", dam["file"])
    try:
        ground = existing(terrain["file"], base_dir(), "terrain.file") if _names_file(terrain) else None
        lines = resolved(READER)(existing(dam["file"], base_dir(), f"{key}.file"), f"{key}.file", ground)
    except InputError as error:
        raise refuse(str(error), f"{key}.file", dam["file"]) from None
    rest = {name: value for name, value in dam.items() if name != "file"}
    names = [dam.get("name")] if len(lines) == 1 else [f"{dam.get('name')}_{n}" for n in range(1, len(lines) + 1)]
    return [{**rest, "name": name, "line": line.tolist(), "line_source": dam["file"]}
            for name, line in zip(names, lines, strict=True)]
