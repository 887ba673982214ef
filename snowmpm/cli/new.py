"""`snowmpm new`: a commented scene to start from."""

import re
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli import choose, completion
from snowmpm.cli.options import Settings, setting_values
from snowmpm.draft import draft
from snowmpm.errors import InputError


class ElevationUnit(str, Enum):
    """Units of `terrain.elevation_unit`."""

    m = "m"
    ft = "ft"
    us_ft = "us-ft"


NEED_MORE = ("peak-pressure", "load")
"""Questions of which a place or an obstacle is part."""


class SceneMethod(str, Enum):
    """Methods that a scene on one's own slope may have."""

    mpm = "mpm"
    depth = "depth"


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the scene; its file is NAME.toml.")],
    ground: Annotated[
        Path | None,
        typer.Option(
            "--terrain",
            metavar="FILE",
            help="Your slope: a mesh (.stl, .obj, .ply, .glb) or an elevation raster (.asc, .tif), in metres.",
            autocompletion=completion.grounds,
        ),
    ] = None,
    release: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Where it releases: .geojson, .shp or .gpkg; a steep, high, even part when missing."
        ),
    ] = None,
    thickness: Annotated[
        float | None, typer.Option(min=0.01, metavar="M", help="Thickness of the snow, normal to the slope [m].")
    ] = None,
    unit: Annotated[
        ElevationUnit | None,
        typer.Option("--elevation-unit", help="Unit of the raster's elevations; what its file says by default."),
    ] = None,
    method: Annotated[
        SceneMethod | None,
        typer.Option(help="With --terrain: mpm resolves the depth of the flow; depth gives run-out and maps of"
                          " kilometres in seconds. mpm by default."),
    ] = None,
    settings: Settings = None,
    question: choose.Question = None,
    within: choose.Within = None,
    budget: choose.BudgetOption = None,
    like: Annotated[
        str | None,
        typer.Option(
            metavar="SCENE", help="Copy this library scene, with the files it names.", autocompletion=completion.scenes
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder of the file; this one by default.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
):
    """Write a commented scene that runs as it is.

    By default a slab on a slope in profile; with --terrain an avalanche on your own slope; with --like a copy of a
    library scene. With --question by the cheapest model that answers it within an error (`snowmpm choose`).
    """
    name = name.removesuffix(".toml")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.\-]{0,99}", name):
        raise InputError(f"NAME {name}: must be made of letters, digits, _, - and ., and start with a letter or digit;"
                         " -o says in which folder")
    if like and (ground or release or thickness):
        raise InputError("--like copies a scene as it is: --terrain, --release and --thickness do not go with it")
    if (within or budget) and not question:
        raise InputError(f"{'--within' if within else '--budget'}: goes with --question NAME")
    if question in NEED_MORE:
        raise InputError(f"--question {question}: needs a place or an obstacle: copy the scene, then snowmpm choose")
    choose.asked_for(within, budget)
    if question:
        choose.refuse_what_rungs_set(setting_values(settings))
    if question and method:
        raise InputError("--question chooses the method: --method does not go with it")
    if (release or thickness or unit or method) and not ground:
        raise InputError("--release, --thickness, --elevation-unit and --method go with --terrain FILE, your slope")
    folder = output or Path()
    file = folder / f"{name}.toml"
    if file.exists() and not overwrite:
        raise InputError(f"{file} is there already: --overwrite it, or choose another name")
    from snowmpm.cli.options import Backend
    from snowmpm.cli.run import start_taichi
    from snowmpm.scenes import load_scene, starts
    from snowmpm.scenes.edited import edited
    from snowmpm.setup.first_scene import outlook, scene_on_ground
    from snowmpm.setup.refusals import refuse_beyond

    told = []
    if like:
        copied_from = load_scene(like, setting_values(settings))  # before anything is copied
        if question:
            choose.check_question(copied_from, question)
        text, copied = starts.copy_of(like, name, folder)
        told = [str(path) for path in copied]
    elif ground:
        text, told = scene_on_ground(name, file, ground, release, thickness, unit and unit.value,
                                     method is SceneMethod.depth or question is not None)
    else:
        text = starts.start_from("profile", name=name, file=file)
    given = setting_values(settings)
    text = edited(text, given)
    with draft(file) as part:
        part.write_bytes(text.encode())
        try:
            scene = load_scene(part)
            refuse_beyond(scene)
            if ground:
                start_taichi(Backend.cpu, None)
                chosen, size = outlook(scene)
                text = edited(text, {key: value for key, value in chosen.items() if key not in given})
                part.write_bytes(text.encode())
                told.insert(3, "" if question else f"{size}, to {load_scene(part).end_time:g} s or until it rests")
            if question:
                start_taichi(Backend.cpu, None)

                def load(changed):
                    part.write_bytes(changed.encode())
                    return load_scene(part)

                text, line, taken = choose.rewritten(text, load, question, within, budget)
                load(text)
                told.append(line)
        except InputError as error:
            raise InputError(str(error).replace(str(part), str(file))) from None
    following = f"--question {question} --rung '{taken}'" if question else "--render"
    print("\n".join([str(file), *(f"  {line}" for line in told if line), f"  next: snowmpm run {file} {following}"]))
