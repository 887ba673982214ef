"""`snowmpm plot`: the history of a run."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli import completion
from snowmpm.cli.options import RunPath
from snowmpm.errors import InputError
from snowmpm.stages import stage

Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FILE", help="A .png, .pdf or .svg file; RUN/history.png by default."),
]


Compression = Annotated[
    bool, typer.Option("--compression", help="Stress against strain under a piston instead; RUN/compression.png.")
]


ThalwegTime = Annotated[
    bool, typer.Option("--thalweg-time", help="Depth and speed along the thalweg over time instead;"
                                              " RUN/thalweg_time.png.")
]


Panels = Annotated[bool, typer.Option("--panels", help="Pressure over the face of obstacles with panels instead;"
                                                       " RUN/panels.png and .csv.")]

Line = Annotated[
    str | None, typer.Option(metavar="X,Y,Z:X,Y,Z", help="A field along the line between two places of a run in 3-D"
                                                         " instead, in the scene's coordinates; RUN/line.png and .csv.")
]

Field = Annotated[
    str | None, typer.Option("--color", metavar="FIELD", help="Of --line; its speed by default.",
                             autocompletion=completion.fields)
]

Time = Annotated[float | None, typer.Option(metavar="T", help="In seconds: of --line, by default the last frame; of"
                                                      " --panels, by default that of the greatest force.")]


def plot(run: RunPath, output: Output = None, compression: Compression = False, thalweg_time: ThalwegTime = False,
         panels: Panels = False, line: Line = None, color: Field = None, time: Time = None):
    """Plot the history of a run: front, speed, energies, time step, loads on obstacles.

    For a propagation saw test, a second plot (with -o the only one) shows the crack in space and time, its speed and
    energy, and the slab's deflection, beside theory (RUN/saw_test.png). A run in progress is plotted up to its last
    frame.
    """
    from snowmpm.io import Run

    opened = Run(run)
    if line is not None and panels:
        raise InputError("--line and --panels are pictures of their own")
    if line is None and color is not None:
        raise InputError("--color goes with --line")
    if line is None and not panels and time is not None:
        raise InputError("--time goes with --line and --panels")
    overwriting.guard(*([output] if output else []))
    with stage("drawing"):
        if thalweg_time:
            from snowmpm.render import render_thalweg_time

            written = [render_thalweg_time(opened, output or opened.path.with_name("thalweg_time.png"))]
        elif panels:
            from snowmpm.render import render_panels

            target = output or opened.path.with_name("panels.png")
            overwriting.guard(target, target.with_suffix(".csv"))
            written = render_panels(opened, target, time=time)
        elif line is not None:
            from snowmpm.render import render_line

            target = output or opened.path.with_name("line.png")
            overwriting.guard(target, target.with_suffix(".csv"))
            written = render_line(opened, target, *_ends(line), field="velocity" if color in (None, "speed") else color,
                                  time=time)
        else:
            written = _draw(opened, output, compression)
    for path in written:
        print(path)


def _ends(line):
    """Two places of text such as "0,0,10:5,0,10"."""
    try:
        begin, end = ([float(number) for number in place.split(",")] for place in line.split(":"))
    except ValueError:
        raise InputError(f"--line {line}: must be two places, X,Y,Z:X,Y,Z") from None
    return begin, end


def _draw(opened, output, compression):
    """Draw the plots of a run; -> their paths."""
    from snowmpm.render import render_compression, render_history, render_saw_test
    from snowmpm.saw_test.theories import further_theories

    if compression:
        return [render_compression(opened, output or opened.path.with_name("compression.png"))]
    written = []
    if opened.saw_test:
        theories = further_theories(opened)
        written.append(render_saw_test(opened, output or opened.path.with_name("saw_test.png"), theories=theories))
        _print_remarks(opened, theories)
    if output is None or not opened.saw_test:
        written.append(render_history(opened, output or opened.path.with_name("history.png")))
    return written


def _print_remarks(run, theories):
    """Print the likely reasons where measurement and theory differ much."""
    from snowmpm.io.saw_theories import compared

    for one in compared(run.summary.get("saw_test", {}), run.saw_test.about["slope_angle"], theories):
        if one.remark:
            print(one.remark)
