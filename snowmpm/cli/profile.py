"""`snowmpm profile`: a snow profile, its weak layer, its stability, and scenes of it."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Json, Quiet
from snowmpm.cli.table import print_json
from snowmpm.errors import InputError

Pit = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="CAAML (.xml, .caaml), SNOWPACK (.pro), SnowMicroPen (.pnt) or a table (.csv);"
                                        " with --all a folder of them."),
]
LayerAt = Annotated[
    float | None,
    typer.Option("--layer", metavar="CM", help="Depth [cm] of the weak layer; the likeliest candidate by default."),
]
Slope = Annotated[
    float | None, typer.Option(metavar="DEG", help="Angle of the slope, in place of the file's.")
]
Modulus = Annotated[str, typer.Option(metavar="LAW", help="Of the moduli: bergfeld, scapozza, gerling, van_herwijnen.")]
Time = Annotated[
    str | None,
    typer.Option(metavar="TEXT", help="Of a .pro file: which of its profiles; the last one with snow by default."),
]


def profile(
    file: Pit,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; runs/NAME_profile by default.")
    ] = None,
    layer: LayerAt = None,
    slope: Slope = None,
    modulus: Modulus = "bergfeld",
    time: Time = None,
    run: Annotated[
        bool, typer.Option("--run", help="Run the saw test of the profile, its weak layer an interface: some seconds.")
    ] = False,
    every: Annotated[bool, typer.Option("--all", help="Every profile of a folder: one table and one picture.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="With --all: keep what an earlier run found.")] = False,
    workers: Annotated[int | None, typer.Option(min=1, metavar="N", help="With --all: processes; one a core.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="With --all: a Dask scheduler, or slurm.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Tell what a snow profile says of stability: weak layer, critical cut length, crack speed; write its scenes.

    Densities that were not measured come from hardness and grain form, moduli and strengths from densities, all by
    published laws with their scatter, which the intervals carry. Writes the profile as practice draws it (profile.png),
    all numbers (stability.json), and scenes to run: saw_test.toml, and slab_release.toml on a slope.
    """
    from snowmpm.pit.mechanics import MODULI

    if modulus not in MODULI:
        raise InputError.not_in("--modulus", modulus, MODULI)
    if slope is not None and not 0.0 <= slope <= 70.0:
        raise InputError.at("--slope", slope, "must be from 0 to 70 degrees")
    if every:
        for option, given in (("--layer", layer is not None), ("--time", time is not None), ("--run", run)):
            if given:
                raise InputError(f"{option}: goes with one profile, not with --all")
        _all(file, output, slope, modulus, quiet, as_json, resume=resume, workers=workers, scheduler=scheduler)
        return
    for option, given in (("--resume", resume), ("--workers", workers), ("--scheduler", scheduler)):
        if given:
            raise InputError(f"{option}: goes with --all")
    _one(file, output, layer, slope, modulus, time, run, quiet, as_json)


def _one(file, output, depth, slope, modulus, time, run, quiet, as_json):
    import json

    from snowmpm.draft import write_text
    from snowmpm.pit import record
    from snowmpm.pit.column import column_of
    from snowmpm.pit.reader import read_profile
    from snowmpm.pit.stability import stability_of
    from snowmpm.pit.weak_layers import candidates
    from snowmpm.render.pit_plot import render_pit

    if file.is_dir():
        raise InputError(f"{file}: a folder: --all takes every profile in it")
    overwriting.reads(file)
    read = read_profile(file, time)
    found = candidates(read)
    folder = output or Path("runs") / f"{file.stem}_profile"
    overwriting.guard_in(folder, ("profile.png", "stability.json", "saw_test.toml", "slab_release.toml"))
    index, fails, lines, refused = None, None, [*record.layers_told(read, found)], []
    if depth is None and not found:
        values = record.profile_record(read, found)
        made = []
    else:
        index, fails = chosen(read, found, depth)
        column = column_of(read, index, slope, modulus, fails)
        stability = stability_of(column)
        values = record.record_of(read, found, index, column, stability)
        lines = [*record.told(read, found, index, column, stability)]
        made, refused = _scenes(read, column, stability)
    written = [render_pit(read, folder / "profile.png", weak=index),
               *(write_text(folder / name, text) for name, text in made)]
    if run and made:
        values["interface"], outcome = _saw_test(folder)
        lines.append(outcome)
    written.append(write_text(folder / "stability.json", json.dumps(values, indent=1, ensure_ascii=False) + "\n"))
    if as_json:
        print_json({**values, "written": [str(path) for path in written], "refused": refused})
        return
    for path in () if quiet else written:
        print(path)
    for line in () if quiet else (*lines, *(f"not written: {one}" for one in refused)):
        print(line)


def chosen(read, found, depth):
    """(index of the weak layer, depth [m] at which it fails). depth: that a user gives [cm], or None."""
    if depth is not None:
        index = read.index_at(0.01 * depth, marked=False)
        if not index:
            top = 100 * read.layers[0].bottom
            raise InputError.at("--layer", depth, f"must be from {top:.4g} to below {100 * read.depth:.4g} cm: below"
                                                  " the layer at the surface, within the profile")
        return index, read.layers[index].top
    if not found:
        raise InputError(f"{read.source}: no candidate for the weak layer: no test failed, nothing is marked, no"
                         " persistent grains; --layer CM names one")
    return found[0].index, found[0].depth


def _scenes(read, column, stability):
    """[(name, text)] of the scenes, and why one is not made."""
    from snowmpm.cli.options import Backend
    from snowmpm.cli.run import start_taichi
    from snowmpm.pit import release_scenes, scenes

    made, refused = [], []
    start_taichi(Backend.cpu, None)
    try:
        law = scenes.weak_law(column)
        made.append(("saw_test.toml", scenes.saw_test_scene(column, law, "saw_test", read.name, stability.expected)))
        soft = release_scenes.of_release(column)
        made.append(("slab_release.toml", release_scenes.release_on_plane(
            soft, scenes.weak_law(soft, release_scenes.RUBS), "slab_release", read.name)))
    except InputError as error:
        refused.append(str(error))
    return made, refused


def _saw_test(folder):
    """What the saw test of the profile found, as numbers and as a line."""
    import snowmpm
    from snowmpm.io.saw_words import outcome

    done = snowmpm.run(snowmpm.load_scene(folder / "saw_test.toml"), folder / "saw_test")
    found = done.summary.get("saw_test", {})
    numbers = {name: found.get(name) for name in (
        "critical_length", "crack_speed", "collapse_height", "fracture_energy", "runs_to_the_end", "stopped")}
    return numbers, f"  saw test by MPM, weak layer as an interface: {outcome(found, done.saw_test)}"


def _all(folder, output, slope, modulus, quiet, as_json, **how):
    from snowmpm.pit import batch

    if not folder.is_dir():
        raise InputError(f"{folder}: --all takes a folder of profiles")
    target = output or Path("runs") / f"{folder.name}_profiles"
    found = batch.run(folder, target, slope, modulus, quiet=quiet or as_json, **how)
    if as_json:
        print_json(found.record)
        return
    for path in () if quiet else found.written:
        print(path)
    for line in () if quiet else found.told:
        print(line)
