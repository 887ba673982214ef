"""`snowmpm plot`: the history of a run."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import RunPath
from snowmpm.stages import stage

Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FILE", help="A .png, .pdf or .svg file; RUN/history.png by default."),
]


Compression = Annotated[
    bool, typer.Option("--compression", help="Stress against strain under a piston instead; RUN/compression.png.")
]


def plot(run: RunPath, output: Output = None, compression: Compression = False):
    """Plot the history of a run: front, speed, energies, time step, loads on obstacles.

    Of a propagation saw test also, or with -o instead: the crack in space and time, its speed and energy, the slab's
    deflection, and theories beside them (RUN/saw_test.png). Also of a run that goes on, up to its last frame.
    """
    from snowmpm.io import Run

    opened = Run(run)
    with stage("drawing"):
        written = _draw(opened, output, compression)
    for path in written:
        print(path)


def _draw(opened, output, compression):
    """Paths of what was drawn."""
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
    """Why measured numbers and theories lie far apart, where they do."""
    from snowmpm.io.saw_theories import compared

    for one in compared(run.summary.get("saw_test", {}), run.saw_test.about["slope_angle"], theories):
        if one.remark:
            print(one.remark)
