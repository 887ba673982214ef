"""`snowmpm plot`: the history of a run."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import RunPath

Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FILE", help="A .png, .pdf or .svg file; RUN/history.png by default."),
]


def plot(run: RunPath, output: Output = None):
    """Plot the history of a run: front, speed, energies, time step, loads on obstacles.

    Also of a run that goes on, up to its last frame.
    """
    from snowmpm.io import Run
    from snowmpm.render import render_history

    opened = Run(run)
    print(render_history(opened, output or opened.path.with_name("history.png")))
