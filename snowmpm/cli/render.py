"""`snowmpm render`: pictures and films of a run."""

import re
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import RunPath
from snowmpm.errors import InputError


def render(
    run: RunPath,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help=".mp4, .gif or .png file, or a folder of PNGs; RUN/film.mp4 by default.",
        ),
    ] = None,
    color: Annotated[str, typer.Option(metavar="FIELD", help="Field that colours the snow.")] = "velocity",
    camera: Annotated[str, typer.Option(help="View: auto frames the action by itself.")] = "auto",
    time: Annotated[float | None, typer.Option(metavar="T", help="Only this moment [s], as a picture.")] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Width and height in pixels.")] = "1280x720",
    fps: Annotated[float, typer.Option(min=1.0, max=120.0, help="Pictures per second of film.")] = 25.0,
):
    """Draw a run to a film or a picture.

    Off-screen: no display is needed.
    """
    shape = _pixels(size)
    from snowmpm.io import Run
    from snowmpm.render import render_run

    folder = Run(run).path.parent
    target = output or folder / ("film.mp4" if time is None else "picture.png")
    render_run(run, target, color=color, camera=camera, time=time, size=shape, fps=fps)
    print(target)


def _pixels(size):
    match = re.fullmatch(r"(\d{2,5})[xX](\d{2,5})", size)
    if not match:
        raise InputError(f"--size {size}: must be WIDTHxHEIGHT in pixels, such as 1280x720")
    return int(match[1]), int(match[2])
