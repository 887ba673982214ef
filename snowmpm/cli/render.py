"""`snowmpm render`: pictures and films of a run."""

import re
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli import completion
from snowmpm.cli.options import Quiet, RunPath
from snowmpm.errors import InputError
from snowmpm.stages import stage

Output = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="A .mp4 or .gif film, a .png picture, an interactive .html page, or a folder for one PNG a frame;"
        " RUN/film.mp4 by default.",
    ),
]
Color = Annotated[
    str | None,
    typer.Option(
        metavar="FIELD",
        help='Field that colours the snow, "snow", or "fracture" (the weak layer by its damage); its speed by default.',
        autocompletion=completion.fields,
    ),
]
Camera = Annotated[
    str | None,
    typer.Option(
        metavar="VIEW", help='"auto" (frames the action), "top", "side", "front" or "BEARING,ELEVATION" in degrees;'
        ' "orbit" goes round the action, "follow" stays with what moves.'
    ),
]
CameraFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="The camera moves along this CSV file: time, eye_x, eye_y, eye_z, target_x,"
                 " target_y, target_z in the scene's coordinates and, if wanted, field_of_view in degrees."),
]
Size = Annotated[str, typer.Option(metavar="WxH", help="Width and height in pixels.")]
Time = Annotated[
    float | None, typer.Option(metavar="T", help="Draw the frame nearest to this time, in seconds, as a .png picture.")
]

SMALLEST, MOST_PIXELS = 16, 50_000_000


def render(
    run: RunPath,
    beside: Annotated[
        str | None,
        typer.Argument(
            metavar="[RUN2]", help="A second run, shown beside the first.", autocompletion=completion.runs
        ),
    ] = None,
    output: Output = None,
    color: Color = None,
    camera: Camera = None,
    camera_path: CameraFile = None,
    time: Time = None,
    cutaway: Annotated[
        bool,
        typer.Option(
            "--cutaway", help="Leave out the snow above the weak layer on the near side, to show its damage."
        ),
    ] = False,
    mirror: Annotated[
        bool, typer.Option("--mirror", help="Draw half and quarter bodies whole, with their mirror images.")
    ] = False,
    size: Size = "1280x720",
    fps: Annotated[float, typer.Option(metavar="N", help="Pictures per second of film.")] = 25.0,
    speed: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="Simulated seconds in a second of film: 1 is real time, 0.25 four times slower; every frame once, in"
            " the order of the run, by default.",
        ),
    ] = None,
    begin: Annotated[
        float | None, typer.Option("--from", metavar="T", help="Begin the film at this time of the run, in seconds.")
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", metavar="T", help="End the film at this time of the run, in seconds.")
    ] = None,
    every: Annotated[int, typer.Option(metavar="N", help="Every n-th frame only.")] = 1,
    plain: Annotated[
        bool, typer.Option("--plain", help="The picture alone: no title, clock, scales, notes and inset.")
    ] = False,
    ground: Annotated[
        str, typer.Option(metavar="NAME", help='Ground of runs in 3-D: "winter", under snow that the flow sweeps away;'
                          ' "summer"; or "auto": winter where snow moves on a slope.')
    ] = "auto",
    inset: Annotated[
        str, typer.Option(metavar="WHEN", help='The whole in a corner, "on", "off" or "auto": a map of the terrain'
                          " where the camera shows less than a quarter of it; in 2-D, where the view is close.")
    ] = "auto",
    look: Annotated[
        str, typer.Option(metavar="NAME", help='"diagram"; of runs in 3-D, with OpenGL: "cinematic", snow in the sun,'
                          ' haze, motion blur, no words; "slice", "arrows" or "streamlines" within the snow.')
    ] = "diagram",
    at: Annotated[
        str | None, typer.Option(metavar="PLACE", help='Of a slice: "x=12", "y=..." or "z=...", in the scene\'s'
                                 " coordinates.")
    ] = None,
    layer: Annotated[
        str, typer.Option("--pass", metavar="NAME", help='For compositing, of runs in 3-D: "transparent", without sky'
                          ' (.png or a folder), or "depth", metres along the view (.tif or a folder).')
    ] = "picture",
    quality: Annotated[
        str, typer.Option(metavar="NAME", help='"full", or "preview": coarser, in a fifth of the time.')
    ] = "full",
    stills: Annotated[
        int | None, typer.Option(metavar="N", help="So many moments, evenly over time, on one sheet (.jpg or .png;"
                                 " RUN/stills.jpg by default; --size is that of the sheet).")
    ] = None,
    quiet: Quiet = False,
):
    """Draw a run to a film, a picture or an interactive page; or two runs side by side.

    A film shows every frame once, and its clock says how much faster than real time that is.
    Needs no display and no graphics card. A run in progress is drawn up to its last frame. A page (-o scene.html) is
    self-contained: it opens in any browser, and can be sent.
    """
    shape = pixels(size)
    from snowmpm.io import Run
    from snowmpm.render.timing import Timing

    timing = Timing(fps, speed, begin, end, every)
    if mirror:
        from snowmpm.render.mirrored import MirroredRun as Run
    opened = Run(run)
    if output and output.suffix.lower() == ".html":
        others = {"RUN2": beside, "--time": time, "--cutaway": cutaway, "--plain": plain, "--speed": speed,
                  "--from": begin, "--to": end, "--every": every if every != 1 else None,
                  "--camera-path": camera_path, "--pass": layer if layer != "picture" else None,
                  "--ground": ground if ground != "auto" else None,
                  "--quality": quality if quality != "full" else None, "--stills": stills,
                  "--inset": inset if inset != "auto" else None, "--look": look if look != "diagram" else None,
                  "--at": at}
        _draw_page(opened, output, color, camera, quiet, others)
        return
    if stills is not None:
        others = {"RUN2": beside, "--time": time, "--plain": plain, "--speed": speed, "--camera-path": camera_path,
                  "--every": every if every != 1 else None, "--pass": layer if layer != "picture" else None}
        _refuse(others, "a sheet of stills")
        draw(opened, output or opened.path.with_name("stills.jpg"), quiet, count=stills, size=shape, begin=begin,
             end=end, color=color, camera=camera, cutaway=cutaway, ground=ground, quality=quality, inset=inset,
             look=look, at=at)
        return
    if beside:
        second = Run(beside)
        target = output or opened.path.with_name(f"beside_{second.path.resolve().parent.name}.mp4")
    else:
        second = None
        target = output or opened.path.with_name("film.mp4" if time is None else "picture.png")
    choices = {"color": color, "camera": camera, "time": time, "size": shape, "timing": timing, "cutaway": cutaway,
               "plain": plain}
    alone = {"camera_path": camera_path, "layer": layer if layer != "picture" else None,
             "ground": ground if ground != "auto" else None, "quality": quality if quality != "full" else None,
             "inset": inset if inset != "auto" else None, "look": look if look != "diagram" else None, "at": at}
    if second and any(alone.values()):
        raise InputError("--at, --camera-path, --ground, --inset, --look, --pass and --quality: not with two runs side"
                         " by side")
    choices |= {name: value for name, value in alone.items() if value is not None}
    draw(opened, target, quiet, second, **choices)


def _draw_page(run, output, color, camera, quiet, others):
    """Write an interactive page and print its path; others: {option: value} that a page refuses where given."""
    from snowmpm.render import render_page

    _refuse(others, "an interactive page, which shows one run at any time")
    with stage("writing the page"):
        written = render_page(run, output, color=color, camera=camera)
    if not quiet:
        print(written)


def _refuse(others, what):
    """Raises InputError for options that were given; others: {option: value}."""
    given = [name for name, value in others.items() if value not in (None, False)]
    if given:
        raise InputError(f"{', '.join(given)}: not with {what}")


def draw(run, target, quiet=False, beside=None, **choices):
    """Draw a run, two side by side, or a `count` of stills to `target`; print and return the path."""
    from snowmpm.render import render_pair, render_run, render_stills

    overwriting.guard(*([] if Path(target).is_dir() else [target]))
    with stage("drawing", unit="pictures") as now:
        def progress(done, total):
            now.done, now.total = done, total

        if "count" in choices:
            written = render_stills(run, target, progress=progress, **choices)
        elif beside is None:
            written = render_run(run, target, progress=progress, **choices)
        else:
            written = render_pair(run, beside, target, progress=progress, **choices)
    if not quiet:
        print(written)
    return written


def pixels(size):
    """(width, height) in pixels from text such as "1280x720".

    Raises InputError where it does not fit this form, or is too small or too large to draw.
    """
    match = re.fullmatch(r"(\d{1,5})[xX](\d{1,5})", size)
    if not match:
        raise InputError(f"--size {size}: must be WIDTHxHEIGHT in pixels, such as 1280x720")
    width, height = int(match[1]), int(match[2])
    if not (min(width, height) >= SMALLEST and width * height <= MOST_PIXELS):
        raise InputError(f"--size {size}: must be {SMALLEST} pixels each way at least, and {MOST_PIXELS:.0g} in all at"
                         " most")
    return width, height
