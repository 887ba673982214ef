"""`snowmpm plot`: the history of a run."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import RunPath

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
    deflection (RUN/saw_test.png). Also of a run that goes on, up to its last frame.
    """
    from snowmpm.io import Run
    from snowmpm.render import render_compression, render_history, render_saw_test

    opened = Run(run)
    if compression:
        print(render_compression(opened, output or opened.path.with_name("compression.png")))
        return
    if opened.saw_test:
        print(render_saw_test(opened, output or opened.path.with_name("saw_test.png")))
    if output is None or not opened.saw_test:
        print(render_history(opened, output or opened.path.with_name("history.png")))
