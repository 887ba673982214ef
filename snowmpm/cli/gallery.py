"""`snowmpm gallery`: a picture of every library scene, and the page that shows them."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli import completion
from snowmpm.cli.options import Backend, BackendOption, Settings, Threads, setting_values
from snowmpm.cli.run import simulate, start_taichi
from snowmpm.cli.wording import count, duration, short
from snowmpm.errors import InputError
from snowmpm.stages import counted


def gallery(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENE ...]",
            help="Library scenes; all of them by default.",
            autocompletion=completion.library_scenes,
        ),
    ] = None,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="DIR", help="Folder of pictures and page."),
    ] = Path("gallery"),
    runs: Annotated[Path, typer.Option(metavar="DIR", help="Folder that holds the runs, DIR/NAME.")] = Path("runs"),
    settings: Settings = None,
    backend: BackendOption = Backend.auto,
    threads: Threads = None,
    overwrite: Annotated[
        bool,
        typer.Option("--overwrite", help="Rerun scenes that have a run in DIR, and replace pictures of other origin."),
    ] = False,
):
    """Draw pictures of library scenes, and write the page of all of them.

    A scene without a finished run is run first; an interrupted run is continued. Times, colours and camera are those of
    the scene's section [picture]. The caption of a picture names what --set changed.
    """
    from snowmpm import overwriting
    from snowmpm.cli.gallery_page import PAGE, draw_exhibit, write_page
    from snowmpm.scenes import library, load_scene

    changed = setting_values(settings)
    chosen = [load_scene(name, changed) for name in scenes or library()]
    for scene in chosen:
        if scene.name not in library():
            raise InputError(f"{scene.source}: not a scene of the library, and the gallery shows those only")
    overwriting.guard_in(output, [PAGE, *(f"{scene.name}.png" for scene in chosen)])
    for scene in counted(chosen, "gallery", "scenes"):
        run = _finished(scene, runs / scene.name, backend, threads, overwrite)
        print(draw_exhibit(scene, run, output, settings))
    page, missing = write_page(output, _in_words)
    print(page if not missing else f"{page}; without a picture: {', '.join(missing)}")


def _finished(scene, output, backend, threads, overwrite):
    """The finished run of a scene; runs or completes it if needed."""
    from snowmpm.cli.gallery_page import run_of
    from snowmpm.io.checkpoint import FILE

    run = None if overwrite else run_of(scene, output)
    if run is None or not run.complete:
        start_taichi(backend, threads)
        run = simulate(scene, output, resume=run is not None and (output / FILE).exists())
    return run


def _in_words(facts):
    """The caption of a picture; empty for a picture that this command did not make."""
    if not facts:
        return ""
    changed = f" With {facts['settings']}." if facts.get("settings") else ""
    wall = duration(float(facts["wall_time"]))
    cost = f"{wall} on {facts['device']}"
    if "processor_time" in facts:  # wall time means little where other programs ran at the same time
        cost = f"{duration(float(facts['processor_time']))} of processor time on {facts['device']}, {wall} by the clock"
    return (f"{count(int(facts['particles']))} particles, dx = {float(facts['dx']):g} m, {float(facts['time']):g} s in"
            f" {short(float(facts['steps']))} steps: {cost}.{changed}")
